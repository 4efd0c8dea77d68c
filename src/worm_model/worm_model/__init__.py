"""Models of the worm: the boundary walk, and the synthetic rig that films a worm."""
