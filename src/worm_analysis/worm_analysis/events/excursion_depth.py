"""Δr_h of an excursion from noisy radii: the largest depth, less what noise alone adds to it."""

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np
from scipy.ndimage import uniform_filter1d

from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, slots=True)
class EpisodeSettings:
    """What is told of a contact or an excursion under noise.

    Attributes
    ----------
    turn_deviations : float
        Of the noise: a way beyond the ends of an episode that is longer is the head's own.
    may_touch : float
        Probability of contact from which on a frame may be in contact; else where it is seen so
        near.
    noise_rows : int
        Times that noise is added again to the depths of an excursion; their mean is what noise adds
        to the largest one.
    frames_a_piece : int
        A longer excursion is looked at in pieces of so many frames.
    smoothed_part : float
        Of the excursion, over which the way of the head is smoothed: less leaves bumps of the
        noise.
    past_peak : float
        An excursion whose depth has fallen below this part of its largest one is on its way back.
    """

    turn_deviations: float = 4.0
    may_touch: float = 0.02
    noise_rows: int = 16
    frames_a_piece: int = 1024
    smoothed_part: float = 2 / 3
    past_peak: float = 0.75


CONTACT_EPISODES = EpisodeSettings()


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
    settings : EpisodeSettings
    """

    def __init__(self, noise: RadiusNoise, settings: EpisodeSettings = CONTACT_EPISODES):
        self._noise = noise
        self._settings = settings
        self._depths: list[float] = []
        self._largest = -np.inf

    def push(self, depth_m: float) -> None:
        """Take a frame."""
        if len(self._depths) == self._settings.frames_a_piece:
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
            shape = self._settings.noise_rows, self._settings.frames_a_piece
            again = (
                way + self._noise.deviation_m * _unit_noise(self._noise.kept, shape)[:, : len(way)]
            )
            largest -= max(0.0, float(again.max(axis=1).mean() - way.max()))
        return max(float(self._largest), largest)

    @property
    def is_past_peak(self) -> bool:
        """Whether the last depth is clearly below the largest."""
        if not self._depths:
            return False
        way = self._smoothed(np.array(self._depths))
        return bool(way[-1] < self._settings.past_peak * max(float(self._largest), way.max()))

    def _smoothed(self, depths: Floats) -> Floats:
        if not self._noise.deviation_m > 0:
            return depths
        frames = 1 + int(len(depths) * self._settings.smoothed_part)
        smoothed: Floats = uniform_filter1d(depths, frames, mode="nearest")
        return smoothed


@lru_cache(maxsize=4)
def _unit_noise(kept: float, shape: tuple[int, int]) -> Floats:
    """Return rows of noise of unit deviation, always the same ones."""
    noise = np.random.default_rng(1).normal(size=shape)
    noise[:, 0] /= sqrt(1 - kept * kept)
    noise *= sqrt(1 - kept * kept)
    for k in range(1, shape[1]):  # scipy.signal would load 20 MiB for this line
        noise[:, k] += kept * noise[:, k - 1]
    return noise
