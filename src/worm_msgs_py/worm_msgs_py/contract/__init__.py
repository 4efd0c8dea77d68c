"""What the nodes tell each other, as frozen dataclasses; they import without ROS."""
