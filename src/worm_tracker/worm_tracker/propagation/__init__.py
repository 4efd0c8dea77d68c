"""Propagates a midline through folds, where the contour gives none."""
