"""Frames that wait: for a later one that tells how a coil lay, and for the head to be decided."""
