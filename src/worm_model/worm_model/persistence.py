"""How long the boundary walk keeps its direction: C_θ(t) and t_per, exactly.

Direction and phase are a Markov process of four states. By symmetry the direction's expectation in
each phase obeys two linear equations, whatever the place on the ring.
"""

from math import exp, nan

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

from worm_model.boundary_walk import WalkParameters


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
    generator = _generator(parameters)
    powers = expm(generator * np.asarray(lag_s, dtype=np.float64)[:, np.newaxis, np.newaxis])
    return np.asarray((powers @ _at_random_time(parameters)).sum(axis=1), dtype=np.float64)


def persistence_time_s(parameters: WalkParameters) -> float:
    """Return t_per: the time in which C_θ falls to 1/e; NaN where it never does (no reversal)."""
    if parameters.reversal <= 0.0:
        return nan
    slowest = -float(np.linalg.eigvals(_generator(parameters)).real.max())
    step_s = 0.01 / slowest

    def excess(lag_s: float) -> float:
        return float(direction_correlation(parameters, np.array([lag_s]))[0]) - exp(-1.0)

    return float(brentq(excess, *_first_fall(parameters, step_s), rtol=1e-12))


def _first_fall(parameters: WalkParameters, step_s: float) -> tuple[float, float]:
    """Return two times, a few steps apart, between which C_θ first falls below 1/e."""
    advance = expm(_generator(parameters) * step_s)
    state, steps = _at_random_time(parameters), 0
    while state.sum() >= exp(-1.0):
        state, steps = advance @ state, steps + 1
    # A step more on either side: at the edge, rounding would decide.
    return max(steps - 2, 0) * step_s, (steps + 1) * step_s


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
