"""A frame in, a BodyState out: picture sources, chamber calibration, tracking."""
