"""A simulated worm, the rig that films it, and the truth of every frame."""
