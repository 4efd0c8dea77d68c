"""How R − r_h is spread in contact and out of it, under noise: fitted to a trial's own depths."""

from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np
from scipy.special import ndtr

from worm_msgs_py.arrays import Floats

BINS_PER_THRESHOLD = 60
FIRST_BIN, LAST_BIN = -8 * BINS_PER_THRESHOLD, 16 * BINS_PER_THRESHOLD
"""Depths are counted from 8 thresholds outside of the wall to 16 inside."""
STRAY_CONTACTS = 0.02
"""Part of the contacts that is anywhere below the threshold: a real wall is no Gaussian."""
FAR = 0.1
"""Part of the excursions that is anywhere: a worm that crosses the middle."""
FAR_THRESHOLDS = 80.0
LEAST_NOISE, MOST_NOISE = 0.5 / BINS_PER_THRESHOLD, 1.0
"""In thresholds."""
MOST_KEPT = 0.9
"""Of noise, from frame to frame: what stays longer is motion as much as noise."""
ROUNDS = 60


@dataclass(frozen=True, slots=True)
class DepthLaw:
    """The law of R − r_h, in thresholds of contact (0.3 d_w).

    In contact it is normal, out of contact exponential from the threshold on, and both are blurred
    by the noise. A wall that is drawn too far out or in shows as a head that touches beyond the
    threshold's half, or outside: the threshold moves with it.

    Attributes
    ----------
    touch, noise : float
        Mean and standard deviation in contact.
    excursion : float
        Mean of what an excursion is deeper than the threshold, by time.
    share : float
        Part of the time in contact.
    kept : float
        Correlation of the noise from frame to frame, 0 to `MOST_KEPT`.
    """

    touch: float = 1 / 3
    noise: float = 1 / 8
    excursion: float = 8.0
    share: float = 0.5
    kept: float = 0.0

    @property
    def edge(self) -> float:
        """Where contact ends, without noise."""
        return 1.0 + self.touch - min(max(self.touch, 0.0), 0.5)

    @property
    def noise_above_bins(self) -> float:
        """The noise, 0 where it is not told from the width of a bin."""
        return self.noise if self.noise > 2 * LEAST_NOISE else 0.0

    def densities(self, depth: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the densities in contact (normal, and stray) and out of contact."""
        noise, edge = self.noise, self.edge
        z = (depth - self.touch) / noise
        normal = np.exp(-z * z / 2) / (noise * sqrt(2 * pi))
        inside = ndtr((depth - edge) / noise)
        low = min(0.0, self.touch)
        stray = (ndtr((depth - low) / noise) - inside) / (edge - low)
        over = np.maximum(depth - edge, 0.0)
        broad = (1 - FAR) * np.exp(-over / self.excursion) / self.excursion + FAR / FAR_THRESHOLDS
        return normal, stray, broad * inside

    def log_odds(self, depth: Floats) -> Floats:
        """Return ln(density in contact/density out of it).

        Each frame counts in full, although noise may stay for several: that the tails of both laws
        are known tells excursions from noise, and half the weight misses a tenth of them.
        """
        normal, stray, free = self.densities(depth)
        contact = (1 - STRAY_CONTACTS) * normal + STRAY_CONTACTS * stray
        tiny = 1e-30
        return np.asarray(np.log(contact + tiny) - np.log(free + tiny))


def fit_depth_law(counts: Floats, beyond: tuple[float, float], kept: float) -> DepthLaw:
    """Fit the law to a histogram of depths, by expectation and maximisation.

    Parameters
    ----------
    counts : ndarray, shape (LAST_BIN - FIRST_BIN,)
        Frames in bins of 1/60 of the threshold.
    beyond : (float, float)
        Frames that are deeper than all bins, and the sum of their depths.
    kept : float
        The noise's correlation from frame to frame.
    """
    depth = (np.arange(FIRST_BIN, LAST_BIN) + 0.5) / BINS_PER_THRESHOLD
    held = counts > 0
    depth, counts = depth[held], counts[held]
    near = (depth > -2.0) & (depth < 1.5)
    if not near.any():
        return DepthLaw(kept=kept)
    law = replace(DepthLaw(), touch=_densest(depth[near], counts[near]), kept=kept)
    for _ in range(ROUNDS):
        law = _better(law, depth, counts, (float(beyond[0]), float(beyond[1])))
    return law


def _densest(depth: Floats, counts: Floats) -> float:
    """Return where most depths lie within a third of a threshold."""
    total = np.concatenate([[0.0], np.cumsum(counts)])
    ends = np.searchsorted(depth, depth + 1 / 3)
    at = int(np.argmax(total[ends] - total[:-1]))
    part = slice(at, int(ends[at]))
    return float(np.average(depth[part], weights=counts[part]))


def _better(law: DepthLaw, depth: Floats, counts: Floats, beyond: tuple[float, float]) -> DepthLaw:
    normal, stray, free = law.densities(depth)
    normal, stray = law.share * (1 - STRAY_CONTACTS) * normal, law.share * STRAY_CONTACTS * stray
    free = (1 - law.share) * free
    every = normal + stray + free + 1e-300
    in_normal, in_free = counts * normal / every, counts * free / every
    n, n_free = float(in_normal.sum()), float(in_free.sum()) + beyond[0]
    total = float(counts.sum()) + beyond[0]
    if n < 1.0:
        return law
    touch = min(max(float(in_normal @ depth) / n, -2.0), 1.0)
    noise = sqrt(float(in_normal @ (depth - touch) ** 2) / n)
    over = float(in_free @ np.maximum(depth - law.edge, 0.0)) + beyond[1] - law.edge * beyond[0]
    return DepthLaw(
        touch,
        min(max(noise, LEAST_NOISE), MOST_NOISE),
        min(max(over / max(n_free, 1.0), 1.0), 40.0),
        min(max(1 - n_free / total, 0.02), 0.98),
        law.kept,
    )
