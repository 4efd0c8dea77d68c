"""The bins of all histograms: part of the format of `sums.parquet`, so that trials add up."""

from math import pi

import numpy as np

LENGTH_BIN_M, LENGTH_BINS = 1e-5, 6001
"""d_c, d_nc, Δr_h and x_p: fine enough for any limit of resolution, up to 60 mm, a chamber's
circumference; what is longer is in the last bin."""
BLOCK_BINS = 101
"""The same by blocks of time, up to 1 mm: a larger limit of resolution is not allowed for."""
FINE_BINS_IN_DEPTH_BIN = 10
DEPTH_BIN_M = FINE_BINS_IN_DEPTH_BIN * LENGTH_BIN_M
"""F(x_p) is fitted to depths in bins of 0.1 mm."""
TAU_BIN_S, TAU_BINS = 0.1, 18_001
"""τ_h, up to the 30 min of a trial; what is longer is in the last bin."""
ENTRY_EDGES = np.linspace(-pi, pi, 25)
"""θ_h⁰."""
ANGLE_BINS = 180
ANGLE_EDGES = np.linspace(-pi, pi, ANGLE_BINS + 1)
"""ψ_b and ψ_h, 2°."""
RADIUS_BINS_PER_R, RADIUS_BINS = 100, 120
RADIUS_EDGES = np.linspace(0.0, RADIUS_BINS / RADIUS_BINS_PER_R, RADIUS_BINS + 1)
"""r/R, up to 1.2; what lies beyond is left out."""
BODY_LENGTH_BIN_M, BODY_WIDTH_BIN_M, BODY_BINS = 1e-4, 5e-6, 400
"""l_w up to 40 mm and d_w up to 2 mm; what is larger is in the last bin."""
