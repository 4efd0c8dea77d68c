"""Δr_h of an excursion from noisy radii: the largest depth, less what noise alone adds to it."""

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np
from scipy.ndimage import uniform_filter1d

from worm_msgs_py.arrays import Floats

NOISE_ROWS = 16
"""Times that noise is added again; their mean is what noise adds to the largest depth."""
FRAMES_A_PIECE = 1024
"""A longer excursion is looked at in pieces of so many frames."""
SMOOTHED_PART = 2 / 3
"""Of the excursion, over which the way of the head is smoothed: less leaves bumps of the noise."""
PAST_PEAK = 0.75
"""An excursion whose depth has fallen below this part of its largest one is on its way back."""


@dataclass(frozen=True, slots=True)
class RadiusNoise:
    """Of the head's radius.

    Attributes
    ----------
    deviation_m : float
        Standard deviation.
    kept : float
        Correlation from frame to frame.
    """

    deviation_m: float = 0.0
    kept: float = 0.0


class ExcursionDepth:
    """Takes R − r_h of the frames of an excursion, in bounded memory.

    The largest of many noisy depths is too large. By how much is found by adding as much noise
    again to the smoothed way of the head, and looking by how much that raises the largest.

    Parameters
    ----------
    noise : RadiusNoise
        As it is known when the excursion begins.
    """

    def __init__(self, noise: RadiusNoise):
        self._noise = noise
        self._depths: list[float] = []
        self._largest = -np.inf

    def push(self, depth_m: float) -> None:
        """Take a frame."""
        if len(self._depths) == FRAMES_A_PIECE:
            self._largest = self.maximum()
            self._depths = []
        self._depths.append(depth_m)

    def maximum(self) -> float:
        """Return max(R − r_h) without noise, as far as can be told."""
        if not self._depths:
            return float(self._largest)
        depths = np.array(self._depths)
        largest = float(depths.max())
        if self._noise.deviation_m > 0:
            way = self._smoothed(depths)
            again = way + self._noise.deviation_m * _unit_noise(self._noise.kept)[:, : len(way)]
            largest -= max(0.0, float(again.max(axis=1).mean() - way.max()))
        return max(float(self._largest), largest)

    @property
    def is_past_peak(self) -> bool:
        """Whether the last depth is clearly below the largest."""
        if not self._depths:
            return False
        way = self._smoothed(np.array(self._depths))
        return bool(way[-1] < PAST_PEAK * max(float(self._largest), way.max()))

    def _smoothed(self, depths: Floats) -> Floats:
        if not self._noise.deviation_m > 0:
            return depths
        smoothed: Floats = uniform_filter1d(
            depths, 1 + int(len(depths) * SMOOTHED_PART), mode="nearest"
        )
        return smoothed


@lru_cache(maxsize=4)
def _unit_noise(kept: float) -> Floats:
    """Return rows of noise of unit deviation, always the same ones."""
    noise = np.random.default_rng(1).normal(size=(NOISE_ROWS, FRAMES_A_PIECE))
    noise[:, 0] /= sqrt(1 - kept * kept)
    noise *= sqrt(1 - kept * kept)
    for k in range(1, FRAMES_A_PIECE):  # scipy.signal would load 20 MiB for this line
        noise[:, k] += kept * noise[:, k - 1]
    return noise
