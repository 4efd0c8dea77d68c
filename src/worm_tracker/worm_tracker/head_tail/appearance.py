"""What tells a worm's ends apart by their appearance: how wide and dark it is towards either.

Which of both is the head does not follow from this. But once the ends have names, it tells whether
the body that is seen after a coil has them the same way round as the one before.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture

_PARTS = 8
"""Parts of a half of the body over which width and darkness are averaged."""


@dataclass(frozen=True, slots=True)
class AppearanceSettings:
    """How much the appearance of the ends tells."""

    memory_frames: float = 200.0
    """Frames over which the appearance and its scatter are remembered: it changes as a worm turns
    about its axis."""
    least_frames: int = 20
    """Frames that must have been seen before it tells anything."""
    least_sd: float = 0.02
    """Least scatter that is believed: part of the width, or of the darkness."""
    independent_part: float = 0.25
    """Weight of each difference: neighbouring parts of a body go together, and so do frames."""
    most_log_odds: float = 4.0
    """Most that it can tell: it may change."""


def appearance_difference(
    points: Floats, widths: Floats, smooth: Picture, origin: tuple[int, int]
) -> Floats:
    """Return how the first half of a body differs in appearance from the last one.

    Parameters
    ----------
    points, widths : ndarray, shapes (n, 2) and (n,)
        Midline and widths.
    smooth : ndarray of uint8, shape (h, w)
        Smoothed signal in a window.
    origin : (int, int)
        (u, v) of the window's first pixel.

    Returns
    -------
    ndarray, shape (16,)
        Differences of width and of signal, part by part, relative to their means; seen from the
        other end they have the opposite sign.
    """
    at = (points - origin).astype(np.float32)[None]
    dark = cv2.remap(  # the stubs do not know that pairs need no second map
        smooth,
        at,
        None,  # type: ignore[call-overload]
        cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_REPLICATE,
    )
    both = np.stack([widths, dark[0]])
    half = _PARTS * (len(points) // 2 // _PARTS)
    differences = (both[:, :half] - both[:, : -half - 1 : -1]).reshape(2, _PARTS, -1).sum(axis=2)
    per_part = both.sum(axis=1) * (half / _PARTS / len(points))
    return np.asarray((differences / np.maximum(per_part, 1e-6)[:, None]).ravel())


@dataclass(frozen=True, eq=False, slots=True)
class AppearanceModel:
    """Mean and variance of the differences seen of a body, all in the same order of its ends."""

    settings: AppearanceSettings
    frames: int = 0
    mean: Floats = field(default_factory=lambda: np.zeros(2 * _PARTS))
    variance: Floats = field(default_factory=lambda: np.zeros(2 * _PARTS))

    def updated(self, difference: Floats) -> "AppearanceModel":
        """Return the model with one frame more."""
        frames = self.frames + 1
        rate = 1 / min(frames, self.settings.memory_frames)
        off = difference - self.mean
        variance = (1 - rate) * (self.variance + rate * off**2)
        return AppearanceModel(self.settings, frames, self.mean + rate * off, variance)

    def log_odds(self, difference: Floats) -> float:
        """Return the log odds that a difference is of the same order, not of the contrary."""
        settings = self.settings
        if self.frames < settings.least_frames:
            return 0.0
        spread = self.variance + settings.least_sd**2
        told = settings.independent_part * float((2 * difference * self.mean / spread).sum())
        return min(max(told, -settings.most_log_odds), settings.most_log_odds)
