"""How long the boundary walk keeps its direction: C_θ(t) and t_per, exactly.

Direction and phase are a Markov process of four states. By symmetry the direction's expectation in
each phase obeys two linear equations, whatever the place on the ring.
"""

from cmath import sqrt
from math import exp, nan

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from worm_model.boundary_walk import WalkParameters

_SAME = 1e-9
"""Rates that differ by less than this, relatively, are one."""
_STEPS = 400


def direction_correlation(parameters: WalkParameters, lag_s: ArrayLike) -> NDArray[np.float64]:
    """Return C_θ(t) of a head that goes on along the wall for ever.

    Parameters
    ----------
    parameters : WalkParameters
        The walk; R, W and h do not matter.
    lag_s : ndarray, shape (n,)
        Time lags, not below 0.

    Returns
    -------
    ndarray, shape (n,)
        1 at lag 0. A slide and a hop are equally frequent, so at a random time the head slides
        with probability ⟨d_c⟩ / (⟨d_c⟩ + ⟨d_nc⟩).
    """
    lag = np.asarray(lag_s, dtype=np.float64)
    slow, fast, drift = _rates(parameters)
    gap = (slow - fast) / 2.0
    if abs(gap) <= _SAME * abs(fast):
        return np.asarray((np.exp(slow * lag) * (1.0 + drift * lag)).real)
    share = (1.0 + drift / gap) / 2.0
    return np.asarray((share * np.exp(slow * lag) + (1.0 - share) * np.exp(fast * lag)).real)


def persistence_time_s(parameters: WalkParameters) -> float:
    """Return t_per: the time in which C_θ falls to 1/e; NaN where it never does (no reversal)."""
    if parameters.reversal <= 0.0:
        return nan
    slow, fast, _ = _rates(parameters)
    times = np.geomspace(1e-3 / abs(fast), 2.0 / -slow.real, _STEPS)
    below = np.flatnonzero(direction_correlation(parameters, times) < exp(-1.0))
    first = int(below[0])
    found = brentq(
        lambda lag_s: float(direction_correlation(parameters, lag_s)) - exp(-1.0),
        times[first - 1] if first else 0.0,
        times[first],
        rtol=1e-12,
    )
    return float(found)


def _rates(parameters: WalkParameters) -> tuple[complex, complex, float]:
    """Return the generator's two eigenvalues, the slower first, and C_θ's slope beyond their mean.

    With these C_θ(t) = e^{mt} (cosh gt + drift · sinh(gt)/g), where m is the eigenvalues' mean and
    g half of their difference.
    """
    generator = _generator(parameters)
    (a, b), (c, d) = generator
    middle = (a + d) / 2.0
    fast = middle - sqrt(((a - d) / 2.0) ** 2 + b * c)
    # Their product is the determinant: their sum would lose the slow one to rounding.
    kept = (1.0 - 2.0 * parameters.flip_after_slide) * (1.0 - 2.0 * parameters.flip_after_hop)
    fade = 2.0 * parameters.flip_rate_s
    slide_ends, hop_ends = -a - fade, -d - fade
    determinant = slide_ends * hop_ends * (1.0 - kept) + fade * (slide_ends + hop_ends + fade)
    drift = float((generator @ _at_random_time(parameters)).sum()) - middle
    return determinant / fast, fast, drift


def _at_random_time(parameters: WalkParameters) -> NDArray[np.float64]:
    """Probabilities of sliding and of hopping at a random time."""
    means = np.array([parameters.mean_slide_mm, parameters.mean_hop_mm])
    return np.asarray(means / means.sum(), dtype=np.float64)


def _generator(parameters: WalkParameters) -> NDArray[np.float64]:
    """Rates of change of E[direction while sliding] and E[direction while hopping]."""
    slide_ends = parameters.speed_mm_s / parameters.mean_slide_mm
    hop_ends = parameters.speed_mm_s / parameters.mean_hop_mm
    kept_after_slide = 1.0 - 2.0 * parameters.flip_after_slide
    kept_after_hop = 1.0 - 2.0 * parameters.flip_after_hop
    fade = 2.0 * parameters.flip_rate_s
    return np.array(
        [
            [-slide_ends - fade, hop_ends * kept_after_hop],
            [slide_ends * kept_after_slide, -hop_ends - fade],
        ]
    )
