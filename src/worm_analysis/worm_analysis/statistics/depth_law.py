"""How R − r_h is spread in contact and out of it, under noise: fitted to a trial's own depths."""

from dataclasses import dataclass, replace
from math import exp, pi, sqrt

import numpy as np
from scipy.special import ndtr

from worm_msgs_py.arrays import Floats

BINS_PER_THRESHOLD = 60
FIRST_BIN, LAST_BIN = -8 * BINS_PER_THRESHOLD, 16 * BINS_PER_THRESHOLD
"""Depths are counted from 8 thresholds outside of the wall to 16 inside."""
FAR_THRESHOLDS = 80.0
"""Depths far away are spread over so many thresholds."""
ONE_SIDE = 1.0
"""Deviation beyond the mean up to which a depth in contact shows the noise, and no flank."""
BEYOND, BEYOND_MEAN, BEYOND_SQUARE = 0.1587, 1.5251, 2.5251
"""Beyond that: the part of a normal law, its mean and mean square there, in deviations."""
LEAST_NOISE = 0.5 / BINS_PER_THRESHOLD
"""In thresholds: less is not told from the width of a bin."""


@dataclass(frozen=True, slots=True)
class DepthLawSettings:
    """What a law of depths may be.

    Attributes
    ----------
    likely_stray, prior_weight : float
        Stray contacts as a part of all, and how much this weighs beside the trial's frames: noise
        hides which contacts are stray.
    stray_within, far_within : (float, float)
        Between which the parts that are anywhere are sought; never 0, or one such depth would make
        the whole law impossible.
    most_noise_thresholds : float
        With more noise contact is not told from excursions.
    touch_within : (float, float)
        Between which the mean in contact is sought, in thresholds: a wall may be drawn as far out
        of its place.
    first_touch_within : (float, float)
        Between which the fit begins, where most depths are: no excursion is as shallow on average.
    first_touch_span : float
        Depths that lie together where it begins.
    excursion_within : (float, float)
        Between which the mean excursion is sought, in thresholds.
    share_within : (float, float)
        Between which the part of the time in contact is sought: with all of it the law out of
        contact would be anything.
    most_kept : float
        Of noise, from frame to frame: what stays longer is motion as much as noise.
    rounds : int
        Of expectation and maximisation; the law stands still long before.
    """

    likely_stray: float = 0.03
    prior_weight: float = 0.3
    stray_within: tuple[float, float] = (0.002, 0.3)
    far_within: tuple[float, float] = (0.005, 0.5)
    most_noise_thresholds: float = 1.0
    touch_within: tuple[float, float] = (-2.0, 1.0)
    first_touch_within: tuple[float, float] = (-2.0, 1.5)
    first_touch_span: float = 1 / 3
    excursion_within: tuple[float, float] = (1.0, 40.0)
    share_within: tuple[float, float] = (0.02, 0.98)
    most_kept: float = 0.9
    rounds: int = 60


DEPTH_LAW = DepthLawSettings()


@dataclass(frozen=True, slots=True)
class DepthLaw:
    """The law of R − r_h, in thresholds of contact (0.3 d_w).

    In contact it is normal, but for stray contacts, which are anywhere up to the threshold: flanks
    of excursions, and those that stay below it. Out of contact it is exponential from the threshold
    on, but for a part that is anywhere: a worm that crosses the middle. All are blurred by the
    noise. A wall that is drawn too far out or in shows as a head that touches beyond the
    threshold's half, or outside: the threshold moves with it.

    Attributes
    ----------
    touch, noise : float
        Mean and standard deviation in contact.
    excursion : float
        Mean of what an excursion is deeper than the threshold, by time, those far away left out.
    share : float
        Part of the time in contact.
    kept : float
        Correlation of the noise from frame to frame, 0 to `most_kept`.
    stray, far : float
        Parts of the time in contact, and out of it, that are anywhere.
    """

    touch: float = 1 / 3
    noise: float = 1 / 8
    excursion: float = 8.0
    share: float = 0.5
    kept: float = 0.0
    stray: float = DEPTH_LAW.likely_stray
    far: float = 0.1

    @property
    def edge(self) -> float:
        """Where contact ends, without noise."""
        return 1.0 + self.touch - min(max(self.touch, 0.0), 0.5)

    @property
    def noise_above_bins(self) -> float:
        """The noise, 0 where it is not told from the width of a bin."""
        return self.noise if self.noise > 2 * LEAST_NOISE else 0.0

    def densities(self, depth: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the densities, by parts: contact, stray contact; excursion, one far away."""
        noise, edge = self.noise, self.edge
        z = (depth - self.touch) / noise
        normal = (1 - self.stray) * np.exp(-z * z / 2) / (noise * sqrt(2 * pi))
        inside = ndtr((depth - edge) / noise)
        stray = self.stray * (ndtr(z) - inside) / (edge - self.touch)
        over = np.maximum(depth - edge, 0.0)
        near = (1 - self.far) * np.exp(-over / self.excursion) / self.excursion
        return normal, stray, near * inside, self.far / FAR_THRESHOLDS * inside

    def log_odds(self, depth: Floats) -> Floats:
        """Return ln(density in contact/density out of it).

        Each frame counts in full, although noise may stay for several: that the tails of both laws
        are known tells excursions from noise, and half the weight misses a tenth of them.
        """
        normal, stray, near, far = self.densities(depth)
        tiny = 1e-30
        return np.asarray(np.log(normal + stray + tiny) - np.log(near + far + tiny))


def fit_depth_law(
    counts: Floats,
    beyond: tuple[float, float],
    kept: float,
    settings: DepthLawSettings = DEPTH_LAW,
) -> DepthLaw:
    """Fit the law to a histogram of depths, by expectation and maximisation.

    Parameters
    ----------
    counts : ndarray, shape (LAST_BIN - FIRST_BIN,)
        Frames in bins of 1/60 of the threshold.
    beyond : (float, float)
        Frames that are deeper than all bins, and the sum of their depths.
    kept : float
        The noise's correlation from frame to frame.
    settings : DepthLawSettings
    """
    depth = (np.arange(FIRST_BIN, LAST_BIN) + 0.5) / BINS_PER_THRESHOLD
    held = counts > 0
    depth, counts = depth[held], counts[held]
    least, most = settings.first_touch_within
    near = (depth > least) & (depth < most)
    if not near.any():
        return DepthLaw(kept=kept)
    first_touch = _densest(depth[near], counts[near], settings.first_touch_span)
    law = replace(DepthLaw(), touch=first_touch, kept=kept)
    for _ in range(settings.rounds):
        law = _better(law, depth, counts, (float(beyond[0]), float(beyond[1])), settings)
    return law


def _densest(depth: Floats, counts: Floats, span: float) -> float:
    """Return where most depths lie within a span."""
    total = np.concatenate([[0.0], np.cumsum(counts)])
    ends = np.searchsorted(depth, depth + span)
    at = int(np.argmax(total[ends] - total[:-1]))
    part = slice(at, int(ends[at]))
    return float(np.average(depth[part], weights=counts[part]))


def _better(
    law: DepthLaw,
    depth: Floats,
    counts: Floats,
    beyond: tuple[float, float],
    settings: DepthLawSettings,
) -> DepthLaw:
    """Return the law after one round; `beyond` as in `fit_depth_law`."""
    in_contact, out = law.share, 1 - law.share
    weights = (in_contact, in_contact, out, out)
    parts = [w * part for w, part in zip(weights, law.densities(depth), strict=True)]
    per_density = counts / (sum(parts) + 1e-300)
    normal, stray, near, far = (per_density * part for part in parts)
    n, n_stray = float(normal.sum()), float(stray.sum())
    if n < 1.0:
        return law
    touch, noise = _left_normal(law, depth, normal)
    deep, deep_m = beyond[0], beyond[1] - law.edge * beyond[0]
    odds = law.far / (1 - law.far) * law.excursion / FAR_THRESHOLDS
    odds *= exp(min(deep_m / deep / law.excursion, 60.0)) if deep else 0.0
    deep_near = 1 / (1 + odds)
    n_near, n_far = float(near.sum()) + deep_near * deep, float(far.sum()) + (1 - deep_near) * deep
    over = float(near @ np.maximum(depth - law.edge, 0.0)) + deep_near * deep_m
    prior = settings.prior_weight * n
    strays = n_stray + prior * settings.likely_stray
    return DepthLaw(
        _within(settings.touch_within, touch),
        _within((LEAST_NOISE, settings.most_noise_thresholds), noise),
        _within(settings.excursion_within, over / max(n_near, 1.0)),
        _within(settings.share_within, (n + n_stray) / (float(counts.sum()) + deep)),
        law.kept,
        _within(settings.stray_within, strays / (n + n_stray + prior)),
        _within(settings.far_within, n_far / max(n_near + n_far, 1.0)),
    )


def _within(ends: tuple[float, float], value: float) -> float:
    return min(max(value, ends[0]), ends[1])


def _left_normal(law: DepthLaw, depth: Floats, normal: Floats) -> tuple[float, float]:
    """Return mean and deviation in contact from the depths at the wall's side of it.

    Flanks of excursions lie on the other side and would be taken for noise: what is there is
    replaced by what a normal law has there.
    """
    left = depth < law.touch + ONE_SIDE * law.noise
    depth, weight = depth[left], normal[left]
    seen = float(weight.sum())
    unseen = seen * BEYOND / (1 - BEYOND)
    mean = law.touch + BEYOND_MEAN * law.noise
    touch = (float(weight @ depth) + unseen * mean) / max(seen + unseen, 1e-300)
    off = law.touch - touch
    square = (BEYOND_SQUARE * law.noise + 2 * BEYOND_MEAN * off) * law.noise + off * off
    squares = float(weight @ (depth - touch) ** 2) + unseen * square
    return touch, sqrt(squares / max(seen + unseen, 1e-300))
