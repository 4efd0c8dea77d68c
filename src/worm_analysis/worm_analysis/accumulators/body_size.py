"""The body's own size over a trial: length l_w and width d_w, with their intervals."""

import numpy as np

from worm_analysis.accumulators.bins import BODY_BINS, BODY_LENGTH_BIN_M, BODY_WIDTH_BIN_M
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_msgs_py.arrays import Floats

FRAMES_AT_ONCE = 1024
"""Frames are added so many together: an array costs less than its numbers one by one."""


class BodySums:
    """Medians of length and width by blocks of time: bounded memory, intervals for slow drifts.

    Lengths have bins of 0.1 mm up to 40 mm, widths of 5 µm up to 2 mm; what is larger is in the
    last bin. Within a bin the median is interpolated.
    """

    def __init__(self) -> None:
        self._blocks = BlockSums(2 * BODY_BINS)
        self._stamps: list[int] = []
        self._sizes: list[tuple[float, float]] = []

    def push(self, stamp_ns: int, length_m: float, width_m: float) -> None:
        """Take a frame; NaN is left out."""
        self._stamps.append(stamp_ns)
        self._sizes.append((length_m, width_m))
        if len(self._stamps) >= FRAMES_AT_ONCE:
            self.flush()

    def flush(self) -> None:
        """Sum what was gathered; `sums` does it itself."""
        if not self._stamps:
            return
        bins = np.array(self._sizes) / (BODY_LENGTH_BIN_M, BODY_WIDTH_BIN_M)
        known = np.isfinite(bins) & (bins >= 0)
        columns = np.minimum(np.where(known, bins, 0).astype(np.intp), BODY_BINS - 1)
        columns[:, 1] += BODY_BINS
        stamps = np.array(self._stamps, dtype=np.int64)
        self._blocks.add(stamps, np.where(known, columns, -1), np.ones(bins.shape))
        self._stamps, self._sizes = [], []

    def sums(self) -> dict[str, Floats]:
        """Return the histograms of length and width, by blocks of time."""
        self.flush()
        rows = self._blocks.rows()
        return {"l_w": rows[:, :BODY_BINS], "d_w": rows[:, BODY_BINS:]}

    def median_width(self) -> float:
        """Return the median width alone, m; NaN without any."""
        self.flush()
        counts = self._blocks.total(slice(BODY_BINS, 2 * BODY_BINS))
        return float(histogram_median(counts[None])[0]) * BODY_WIDTH_BIN_M


def histogram_median(counts: Floats, first_bin: int = 0) -> Floats:
    """Return the median of each row of counts, in bins; NaN for an empty row.

    Parameters
    ----------
    counts : ndarray, shape (m, n)
        Histograms.
    first_bin : int
        What the number of their first bin is.
    """
    cumulated = np.cumsum(counts, axis=1)
    half = cumulated[:, -1] / 2
    rows = np.arange(len(counts))
    at = np.argmax(cumulated >= half[:, None], axis=1)
    inside = counts[rows, at]
    below = cumulated[rows, at] - inside
    share = np.divide(half - below, inside, out=np.full(len(rows), np.nan), where=inside > 0)
    median: Floats = at + first_bin + share
    return median
