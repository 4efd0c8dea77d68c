"""How far the head gets before it fails: β, α and the constant of F(x_p), by likelihood."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from worm_msgs_py.arrays import Floats, Integers, Mask
from worm_msgs_py.intervals import Interval

LOG_LIKELIHOOD_FALL = 1.9207
"""Fall of the log likelihood at the ends of a 95 % interval: half of χ²'s quantile."""


@dataclass(frozen=True, slots=True)
class PenetrationSettings:
    """How F(x_p) is fitted and tested.

    Attributes
    ----------
    most_constant_share : float
        Part of the failures that may be the constant's: where the decay is the smaller part, it is
        some narrow heap of depths that is fitted by it.
    slowest_decay_per_span, fastest_decay_per_bin : float
        β is sought from one to the other, in 1/(range that was observed) and in 1/bin: depths do
        not tell a slower or a faster one.
    coarse_grid, fine_grid : (int, int)
        Points in log β and in the share, in the two rounds of the search for the likeliest.
    fewest_expected, most_groups, fewest_groups : int
        Failures that a group of bins must hold by the law to be tested, groups at most, and at
        least: two parameters are fitted.
    """

    most_constant_share: float = 0.5
    slowest_decay_per_span: float = 0.1
    fastest_decay_per_bin: float = 4.0
    coarse_grid: tuple[int, int] = (48, 21)
    fine_grid: tuple[int, int] = (49, 49)
    fewest_expected: int = 5
    most_groups: int = 20
    fewest_groups: int = 4


PENETRATION = PenetrationSettings()


@dataclass(frozen=True, slots=True)
class Penetration:
    """F(x_p) = α·exp(−β·(x_p − x₀)) + const, a probability density of x₀ ≤ x_p ≤ x₀ + range.

    Attributes
    ----------
    beta, alpha, const : (float, float, float)
        Value, low and high, 1/unit of the edges; an end that the data do not bound is NaN.
    """

    beta: Interval
    alpha: Interval
    const: Interval


def fit_penetration(
    edges: Floats, counts: Integers, settings: PenetrationSettings = PENETRATION
) -> Penetration:
    """Fit a decay over a constant to depths in bins (paper, section on Fig. 9).

    A failure is one of two kinds: the head turns back with a constant probability per length, or
    it turns back anywhere in the range that was observed, with the same probability. The mixture's
    likelihood is exact for binned depths; all intervals are where it is, maximal over the other
    parameter, within 1.92 of its maximum.

    Parameters
    ----------
    edges : ndarray, shape (n + 1,)
        Bin edges, ascending; the first one is the least depth that is seen, the last one the end
        of the range that was observed.
    counts : ndarray of int64, shape (n,)
        Failures in each bin.
    settings : PenetrationSettings
    """
    chances = _Chances(edges, counts)
    span = float(edges[-1] - edges[0])
    log_beta, share = _coarse_grid(span, float(edges[1] - edges[0]), settings)
    likelihood = chances.log_likelihood(log_beta, share)
    best = _climb(chances, log_beta, share, likelihood)
    # A finer grid over the part that matters, which holds the best point.
    near = likelihood > likelihood.max() - 3 * LOG_LIKELIHOOD_FALL
    log_beta = _finer_grid(log_beta, near.any(axis=1), settings.fine_grid[0], best[0])
    share = _finer_grid(share, near.any(axis=0), settings.fine_grid[1], best[1])
    likelihood = chances.log_likelihood(log_beta, share)
    top = float(likelihood.max())
    fall = top - likelihood
    alpha = _alpha(log_beta[:, None], share, span)
    inside = alpha[fall <= LOG_LIKELIHOOD_FALL]
    at = _interval(log_beta, fall.min(axis=1), best[0])
    of_share = _interval(share, fall.min(axis=0), best[1])
    beta = float(np.exp(best[0]))
    return Penetration(
        beta=(beta, float(np.exp(at[0])), float(np.exp(at[1]))),
        alpha=(
            float(_alpha(np.array(best[0]), np.array(best[1]), span)),
            float(inside.min()),
            float(inside.max()),
        ),
        const=(
            best[1] / span,
            (0.0 if np.isnan(of_share[0]) else of_share[0]) / span,
            of_share[1] / span,
        ),
    )


def penetration_p(
    edges: Floats, counts: Integers, fit: Penetration, settings: PenetrationSettings = PENETRATION
) -> float:
    """Return the probability of a fit as bad as this one, were F(x_p) the law of the depths.

    Pearson's χ² over groups of bins that the law fills alike, with two parameters fitted.

    Parameters
    ----------
    edges, counts, fit, settings
        As `fit_penetration` took them, and what it gave.

    Returns
    -------
    float
        NaN where there are too few failures to test two parameters.
    """
    n = int(counts.sum())
    groups = min(settings.most_groups, n // settings.fewest_expected)
    if groups < settings.fewest_groups:
        return float("nan")
    from scipy.stats import chisquare  # takes a second to import, and few trials come here

    x = edges - edges[0]
    beta = fit.beta[0]
    law = -fit.alpha[0] / beta * np.expm1(-beta * x) + fit.const[0] * x
    expected = np.diff(law) / law[-1] * n
    group = np.minimum((groups * (law[1:] + law[:-1]) / 2 / law[-1]).astype(int), groups - 1)
    wanted, seen = (np.bincount(group, values, groups) for values in (expected, counts))
    filled = wanted > 0
    return float(chisquare(seen[filled], wanted[filled], ddof=2).pvalue)


class _Chances:
    """The bins that hold something, and the chance of each under the mixture."""

    def __init__(self, edges: Floats, counts: Integers):
        held = counts > 0
        self._low, self._high = edges[:-1][held] - edges[0], edges[1:][held] - edges[0]
        self._span = float(edges[-1] - edges[0])
        self._counts = counts[held].astype(np.float64)
        self._even = (self._high - self._low) / self._span

    def log_likelihood(self, log_beta: Floats, share: Floats) -> Floats:
        """Return it on the grid of both, shape (len(log_beta), len(share))."""
        beta = np.exp(log_beta)[:, None]
        decay = np.exp(-beta * self._low) - np.exp(-beta * self._high)
        decay /= -np.expm1(-beta * self._span)
        # A floor keeps the logarithm finite where a steep decay leaves a bin no chance.
        chance = decay[:, None, :] * (1 - share)[:, None] + share[:, None] * self._even
        return np.asarray(np.log(np.maximum(chance, 1e-300)) @ self._counts)


def _coarse_grid(
    span: float, bin_width: float, settings: PenetrationSettings
) -> tuple[Floats, Floats]:
    slowest = settings.slowest_decay_per_span / span
    fastest = settings.fastest_decay_per_bin / bin_width
    return (
        np.linspace(np.log(slowest), np.log(fastest), settings.coarse_grid[0]),
        np.linspace(0.0, settings.most_constant_share, settings.coarse_grid[1]),
    )


def _climb(
    chances: _Chances, log_beta: Floats, share: Floats, likelihood: Floats
) -> tuple[float, float]:
    row, column = np.unravel_index(int(np.argmax(likelihood)), likelihood.shape)

    def loss(x: Floats) -> float:
        return -float(chances.log_likelihood(x[:1], x[1:])[0, 0])

    found = minimize(
        loss,
        x0=[log_beta[row], share[column]],
        method="L-BFGS-B",
        bounds=[(log_beta[0], log_beta[-1]), (0.0, share[-1])],
    )
    return float(found.x[0]), float(found.x[1])


def _finer_grid(grid: Floats, near: Mask, n: int, best: float) -> Floats:
    """Return a finer grid over the part of a grid that is near, one step wider on each side."""
    at = np.flatnonzero(near)
    low, high = grid[max(0, at[0] - 1)], grid[min(len(grid) - 1, at[-1] + 1)]
    return np.union1d(np.linspace(low, high, n), [best])


def _alpha(log_beta: Floats, share: Floats, span: float) -> Floats:
    beta = np.exp(log_beta)
    alpha: Floats = (1 - share) * beta / -np.expm1(-beta * span)
    return alpha


def _interval(grid: Floats, fall: Floats, best: float) -> tuple[float, float]:
    """Return where the fall of the likelihood is critical on both sides; NaN where it is not.

    The root of the fall is nearly straight in the parameter, so it is what is interpolated.
    """
    root = np.sqrt(np.maximum(fall, 0.0))
    critical = np.sqrt(LOG_LIKELIHOOD_FALL)
    ends = []
    for side in (grid < best, grid > best):
        place, height = grid[side], root[side]
        order = np.argsort(np.abs(place - best))
        height = np.concatenate([[0.0], np.maximum.accumulate(height[order])])
        place = np.concatenate([[best], place[order]])
        beyond = height[-1] >= critical
        ends.append(float(np.interp(critical, height, place)) if beyond else float("nan"))
    return ends[0], ends[1]
