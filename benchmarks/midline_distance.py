"""How far a midline that is told is from the true one."""

import numpy as np
from numpy.typing import NDArray

POINTS = 121
"""Of a midline that is compared whole."""


def largest(values: NDArray[np.float64]) -> float:
    """Return the largest value, NaN without any."""
    return float(values.max()) if len(values) else np.nan


def largest_of_parts_px(given: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """Return the largest distance of what is told of a midline, NaN elsewhere, from the true one.

    Each part against the true stretch that it follows best, whose ends are no farther along the
    true midline than an eighth of its length from where the part's ends are.
    """
    told = np.isfinite(given).all(axis=1)
    edges = np.flatnonzero(np.diff(np.r_[False, told, False]))
    even, scale = at_even_steps(true), (POINTS - 1) / (len(given) - 1)
    away = []
    for first, behind in edges.reshape(-1, 2):
        count = round((behind - 1 - first) * scale) + 1
        part = (
            at_even_steps(given[first:behind], count) if behind - first > 1 else given[first:behind]
        )
        away.append(_frechet_of_part_px(part, even, (first * scale, (behind - 1) * scale)))
    return largest(np.array(away))


def _frechet_of_part_px(
    part: NDArray[np.float64], line: NDArray[np.float64], ends: tuple[float, float]
) -> float:
    """Return the least discrete Fréchet distance of a part (m, 2) from a stretch of a line (n, 2).

    The stretch begins and ends within an eighth of the line from these nodes.
    """
    reach, node = len(line) // 8, np.arange(len(line))
    begins, stops = (np.abs(node - round(end)) <= reach for end in ends)
    away = np.hypot(*np.moveaxis(part[:, np.newaxis] - line, 2, 0))
    leads = np.where(begins, away[0], np.inf)
    for here in away[1:]:
        from_before = np.minimum(leads, np.r_[np.inf, leads[:-1]])
        lead, found = np.inf, []
        for distance, before in zip(here.tolist(), from_before.tolist(), strict=True):
            lead = max(distance, min(lead, before))
            found.append(lead)
        leads = np.array(found)
    return float(leads[stops].min())


def at_even_steps(line: NDArray[np.float64], count: int = POINTS) -> NDArray[np.float64]:
    """Return a line's points at even steps of arc length."""
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))]
    at = np.linspace(0.0, s[-1], count)
    return np.stack([np.interp(at, s, line[:, k]) for k in (0, 1)], axis=1)


def frechet_px(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the discrete Fréchet distance of two lines of equally many points, (n, 2)."""
    n = len(one)
    away = np.hypot(*np.moveaxis(one[:, np.newaxis] - other, 2, 0))
    before = np.full(n + 1, np.inf)  # by the row i + 1 of each antidiagonal
    last = np.full(n + 1, np.inf)
    last[1] = away[0, 0]
    for diagonal in range(1, 2 * n - 1):
        i = np.arange(max(0, diagonal - n + 1), min(diagonal, n - 1) + 1)
        now = np.full(n + 1, np.inf)
        way = np.minimum(np.minimum(last[i], last[i + 1]), before[i])
        now[i + 1] = np.maximum(way, away[i, diagonal - i])
        before, last = last, now
    return float(last[n])
