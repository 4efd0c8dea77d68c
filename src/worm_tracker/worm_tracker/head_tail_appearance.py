"""What tells a worm's ends apart by sight: how wide and how dark it is towards either of them.

Which of both is the head does not follow from this. But once the ends have names, it tells whether
the body that is seen after a coil has them the same way round as the one before.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.midline.contour_midline import Floats

BINS = 8
"""Parts of a half of the body over which width and darkness are averaged."""
MEMORY = 200.0
"""Frames over which the marks and their scatter are remembered."""
FEWEST = 20
"""Frames that must have been seen before the marks tell anything."""
LEAST_SD = 0.02
"""Least scatter of a mark that is believed: part of the width, or of the darkness."""
INDEPENDENT = 0.25
"""Weight of each mark: those of neighbouring parts go together, and so do those of frames."""
MOST_ODDS = 4.0
"""Most that the marks can tell, as log-odds: they may change."""


def marks_of(
    points: Floats, widths: Floats, smooth: NDArray[np.uint8], first: tuple[int, int]
) -> Floats:
    """Return how the first half of a body differs from the last one, shape (2 BINS,).

    Parameters
    ----------
    points, widths : ndarray, shapes (n, 2) and (n,)
        Midline and widths.
    smooth : ndarray of uint8, shape (h, w)
        Smoothed signal in a window.
    first : (int, int)
        (u, v) of the window's first pixel.

    Returns
    -------
    ndarray
        Differences of width and of signal, relative to their means; seen from the other end they
        have the opposite sign.
    """
    at = (points - first).astype(np.float32)[None]
    dark = cv2.remap(  # the stubs do not know that pairs need no second map
        smooth,
        at,
        None,  # type: ignore[call-overload]
        cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_REPLICATE,
    )
    both = np.stack([widths, dark[0]])
    half = BINS * (len(points) // 2 // BINS)
    differences = (both[:, :half] - both[:, : -half - 1 : -1]).reshape(2, BINS, -1).sum(axis=2)
    per_bin = both.sum(axis=1) * (half / BINS / len(points))
    return np.asarray((differences / np.maximum(per_bin, 1e-6)[:, None]).ravel())


@dataclass(eq=False, slots=True)
class Appearance:
    """Marks that were seen of a body, all in the same order of its ends."""

    frames: int = 0
    mean: Floats = field(default_factory=lambda: np.zeros(2 * BINS))
    variance: Floats = field(default_factory=lambda: np.zeros(2 * BINS))

    def learn(self, marks: Floats) -> None:
        """Take the marks of a frame in."""
        self.frames += 1
        rate = 1 / min(self.frames, MEMORY)
        off = marks - self.mean
        self.mean = self.mean + rate * off
        self.variance = (1 - rate) * (self.variance + rate * off**2)

    def log_odds(self, marks: Floats) -> float:
        """Return the log-odds that some marks are of the same order, not of the contrary."""
        if self.frames < FEWEST:
            return 0.0
        spread = self.variance + LEAST_SD**2
        told = INDEPENDENT * float((2 * marks * self.mean / spread).sum())
        return min(max(told, -MOST_ODDS), MOST_ODDS)
