"""Following one worm from picture to picture: its midline, and what is learned of its body."""
