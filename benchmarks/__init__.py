"""Measurements: ratios within one run, because the absolute speed of a machine drifts."""
