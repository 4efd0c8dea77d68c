"""The body's own size over a trial: length l_w and width d_w, with their intervals."""

from math import nan

import numpy as np
from numpy.typing import NDArray

from worm_analysis.statistics.block_jackknife import BlockSums, jackknife_half_width

Floats = NDArray[np.float64]

WIDTH_BIN_M = 5e-6
LENGTH_BIN_M = 1e-4
BINS = 400
AT_ONCE = 1024


class BodySums:
    """Medians of length and width by blocks of time: bounded memory, intervals for slow drifts.

    Lengths have bins of 0.1 mm up to 40 mm, widths of 5 µm up to 2 mm; what is larger is in the
    last bin. Within a bin the median is interpolated.
    """

    def __init__(self) -> None:
        self._blocks = BlockSums(2 * BINS)
        self._stamps: list[int] = []
        self._sizes: list[tuple[float, float]] = []

    def push(self, stamp_ns: int, length_m: float, width_m: float) -> None:
        """Take a frame; NaN is left out."""
        self._stamps.append(stamp_ns)
        self._sizes.append((length_m, width_m))
        if len(self._stamps) >= AT_ONCE:
            self.settle()

    def settle(self) -> None:
        """Sum what was gathered; must be called before the sums are read."""
        if not self._stamps:
            return
        bins = np.array(self._sizes) / (LENGTH_BIN_M, WIDTH_BIN_M)
        known = np.isfinite(bins) & (bins >= 0)
        columns = np.minimum(np.where(known, bins, 0).astype(np.intp), BINS - 1)
        columns[:, 1] += BINS
        stamps = np.array(self._stamps, dtype=np.int64)
        self._blocks.add(stamps, np.where(known, columns, -1), np.ones(bins.shape))
        self._stamps, self._sizes = [], []

    def length(self) -> tuple[int, float, float | None]:
        """Return the number of frames with a length, its median in m and the half interval."""
        return self._median(slice(0, BINS), LENGTH_BIN_M)

    def width(self) -> tuple[int, float, float | None]:
        """Return the number of frames with a width, its median in m and the half interval."""
        return self._median(slice(BINS, 2 * BINS), WIDTH_BIN_M)

    def median_width(self) -> float:
        """Return the median width alone, m; NaN without any."""
        counts = self._blocks.total()[None, BINS:]
        return float(histogram_median(counts)[0]) * WIDTH_BIN_M

    def _median(self, part: slice, bin_m: float) -> tuple[int, float, float | None]:
        counts = self._blocks.total()[part]
        n = int(counts.sum())
        if n == 0:
            return 0, nan, None

        def estimate(sums: Floats) -> Floats:
            return histogram_median(sums) * bin_m

        value = float(estimate(counts[None])[0])
        return n, value, jackknife_half_width(self._blocks, estimate, part)


def histogram_median(counts: Floats) -> Floats:
    """Return the median of each row of counts, in bins; NaN for an empty row.

    Parameters
    ----------
    counts : ndarray, shape (m, n)
        Histograms.
    """
    cumulated = np.cumsum(counts, axis=1)
    half = cumulated[:, -1] / 2
    rows = np.arange(len(counts))
    at = np.argmax(cumulated >= half[:, None], axis=1)
    inside = counts[rows, at]
    below = cumulated[rows, at] - inside
    share = np.divide(half - below, inside, out=np.full(len(rows), np.nan), where=inside > 0)
    median: Floats = at + share
    return median
