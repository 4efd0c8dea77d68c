"""How long the boundary walk keeps its direction: C_θ(t) and t_per, exactly.

Direction and phase are a Markov process of four states. By symmetry the direction's expectation in
each phase obeys two linear equations, whatever the place on the ring; so C_θ(t) is a sum of two
exponentials, which its value and its slope at 0 fix.
"""

from math import exp, nan

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from worm_model.boundary_walk.parameters import WalkParameters

_LAST_IN_DECAYS = 50.0
"""Decays of the slow exponential after which C_θ is 0, or what it stays at."""


def direction_correlation(
    parameters: WalkParameters, lag_s: NDArray[np.float64]
) -> NDArray[np.float64]:
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
    slow, fast = _exponents(parameters)
    t = np.asarray(lag_s, dtype=np.float64)
    # The divided difference of exp at the two exponents.
    apart = slow - fast
    part = -np.expm1(-apart * t) / apart if apart != 0.0 else t + 0j
    correlation = np.exp(fast * t) + (_slope_at_zero(parameters) - fast) * np.exp(slow * t) * part
    return np.asarray(correlation.real, dtype=np.float64)


def persistence_time_s(parameters: WalkParameters) -> float:
    """Return t_per: the time in which C_θ first falls to 1/e; NaN where it never does.

    So it is without reversals, and where each end of a phase turns a head whose phases are of very
    different length: then most of its time it goes one way.
    """
    if parameters.reversal <= 0.0:
        return nan
    slow, fast = _exponents(parameters)
    first_s = 1e-3 / abs(fast)
    last_s = _LAST_IN_DECAYS / max(-slow.real, 1e-12 * abs(fast))
    # Fine enough for an oscillation; a sum of two real exponentials turns once at most.
    lag_s = np.concatenate([[0.0], np.geomspace(first_s, last_s, 4000)])
    below = np.flatnonzero(direction_correlation(parameters, lag_s) < exp(-1.0))
    if not len(below):
        return nan

    def excess(lag: float) -> float:
        return float(direction_correlation(parameters, np.array([lag]))[0]) - exp(-1.0)

    return float(brentq(excess, lag_s[below[0] - 1], lag_s[below[0]], rtol=1e-12))


def _slope_at_zero(parameters: WalkParameters) -> float:
    """Return dC_θ/dt at 0, 1/s: twice the rate of reversals."""
    cycle_s = (parameters.mean_slide_mm + parameters.mean_hop_mm) / parameters.speed_mm_s
    turns = (parameters.flip_after_slide + parameters.flip_after_hop) / cycle_s
    return -2.0 * (turns + parameters.flip_rate_s)


def _exponents(parameters: WalkParameters) -> tuple[complex, complex]:
    """Return the slow and the fast exponent of C_θ, 1/s."""
    slide_ends = parameters.speed_mm_s / parameters.mean_slide_mm
    hop_ends = parameters.speed_mm_s / parameters.mean_hop_mm
    q_s, q_h = parameters.flip_after_slide, parameters.flip_after_hop
    fade = 2.0 * parameters.flip_rate_s
    both = slide_ends * hop_ends
    # Written so that nothing cancels where reversals are rare.
    determinant = 2.0 * both * (q_s + q_h - 2.0 * q_s * q_h) + fade * (slide_ends + hop_ends + fade)
    middle = -(slide_ends + hop_ends) / 2.0 - fade
    kept = (1.0 - 2.0 * q_s) * (1.0 - 2.0 * q_h)
    gap = complex(((slide_ends - hop_ends) / 2.0) ** 2 + both * kept) ** 0.5
    fast = middle - gap
    return determinant / fast, fast
