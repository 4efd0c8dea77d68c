"""Chooses stretches of a trial that show how the worm moves: steady, and turning back."""

import numpy as np
from numpy.typing import NDArray

from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.results import Results
from worm_msgs_py.arrays import Floats, Integers

Indices = Integers


def example_spans(results: Results, count: int = 3) -> list[Indices]:
    """Return the frames of up to `count` examples, in the order of few to many reversals.

    A trial of up to 90 s is one example. Of a longer one the `candidates` are ranked by the number
    of reversals of direction; the first, the last and those evenly between are taken.

    Parameters
    ----------
    results : Results
        The trial.
    count : int
        How many, 1 or more.

    Returns
    -------
    list of ndarray of int64
        Indices of rows, ascending in each; empty where θ_h is not known anywhere long enough.
    """
    t_s, theta = results.t_s, results.tracks["theta_h_rad"]
    if not np.isfinite(theta).any():
        return []
    if t_s[-1] <= FIGURES.whole_s:
        return [np.arange(len(t_s), dtype=np.int64)]
    ranked = sorted(candidates(results), key=lambda item: item[0])
    chosen = np.unique(np.rint(np.linspace(0, len(ranked) - 1, count)).astype(int))
    return [ranked[index][1] for index in chosen] if ranked else []


def candidates(results: Results) -> list[tuple[int, Indices]]:
    """Return reversals and frames of all stretches that may be shown, in order of time.

    The trial is cut into stretches of 60 s; those in one chamber with θ_h in 90 % of their frames
    count. A worm that never stays so long has its stays in a chamber of 20 s and more instead.
    """
    t_s, theta = results.t_s, results.tracks["theta_h_rad"]
    where = results.tracks["where"]
    found = []
    window = (t_s // FIGURES.example_s).astype(np.int64)
    for rows in np.split(np.arange(len(t_s)), np.flatnonzero(np.diff(window)) + 1):
        if (
            len(rows) == 0
            or t_s[rows[-1]] - t_s[rows[0]] < FIGURES.fewest_known * FIGURES.example_s
        ):
            continue
        known = np.isfinite(theta[rows])
        one_place = len(set(where[rows][known])) == 1
        if one_place and known.mean() >= FIGURES.fewest_known:
            found.append((count_reversals(t_s[rows], theta[rows]), rows))
    return found or _stays(t_s, theta, where)


def _stays(t_s: Floats, theta: Floats, where: NDArray[np.object_]) -> list[tuple[int, Indices]]:
    """Return the stays in one chamber, up to their first minute."""
    inside = np.isin(where, ("chamber_a", "chamber_b")) & np.isfinite(theta)
    change = np.flatnonzero((where[1:] != where[:-1]) | (inside[1:] != inside[:-1])) + 1
    found = []
    for stay in np.split(np.arange(len(t_s)), change):
        rows = stay[t_s[stay] - t_s[stay[0]] <= FIGURES.example_s] if len(stay) else stay
        if (
            len(rows)
            and inside[rows[0]]
            and t_s[rows[-1]] - t_s[rows[0]] >= FIGURES.shortest_stay_s
        ):
            found.append((count_reversals(t_s[rows], theta[rows]), rows))
    return found


def count_reversals(t_s: Floats, theta_rad: Floats) -> int:
    """Count changes of direction between successive steps of 5 s; NaN frames are left out."""
    known = np.isfinite(theta_rad)
    t_s, theta_rad = t_s[known], theta_rad[known]
    if len(t_s) < 2:
        return 0
    at = np.arange(t_s[0], t_s[-1], FIGURES.direction_s)
    turned = np.sign(np.diff(np.interp(at, t_s, theta_rad)))
    turned = turned[turned != 0]
    return int(np.count_nonzero(turned[1:] != turned[:-1]))
