"""Where points of the body are between pictures that show them, moving on as they did in these.

The end of a worm neither leaps nor stops at once. How much its velocity changes by chance is taken
from the pictures that show it; where it was between them, and how unsure that is, follows from it.
"""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, slots=True)
class SmoothMotionSettings:
    """How a point of the body moves.

    Its velocity changes by chance, in each moment independently and to all sides alike (nearly
    constant velocity: Bar-Shalom, Li and Kirubarajan 2001, section 6.2.2).
    """

    lag_s: float = 0.16
    """Over so long before a picture and after it the change of velocity is asked: over less the
    noise of what is seen counts for more than the motion."""
    unsteadiness: float = 300.0
    """How unsteady a point is held to be before it is seen to move: the variance that its velocity
    gains in a second, in squared widths per cubed second. Ends of worms that fold: 5 to 500."""
    weight: float = 4.0
    """For how many independent changes of velocity that counts beside those that are seen."""
    least_sd_widths: float = 0.15
    """How unsure a place that is seen is held to be, at least."""


def unsteadiness_of(times_s: Floats, points: Floats, settings: SmoothMotionSettings) -> Floats:
    """Return how unsteadily points move: the variance that their velocity gains in a second.

    Parameters
    ----------
    times_s : ndarray, shape (n,)
        When they were seen, in their order.
    points : ndarray, shape (n, m, 2)
        Where, in widths of the body.
    settings : SmoothMotionSettings

    Returns
    -------
    ndarray, shape (m,)
        Along one axis, squared widths per cubed second.
    """
    lag_s = settings.lag_s
    away_s = times_s - times_s[:, np.newaxis]
    before, after = (np.abs(away_s - lead_s).argmin(axis=1) for lead_s in (-lag_s, lag_s))
    ago_s, ahead_s = times_s - times_s[before], times_s[after] - times_s
    asked = np.minimum(ago_s, ahead_s) > 0.7 * lag_s
    asked &= np.maximum(ago_s, ahead_s) < 1.4 * lag_s
    if not asked.any():
        return np.full(points.shape[1], settings.unsteadiness)
    steps = (points[before], points, points[after])
    there, here, then = (step[asked] for step in steps)
    ago_s, ahead_s = (span_s[asked, np.newaxis, np.newaxis] for span_s in (ago_s, ahead_s))
    change = (then - here) / ahead_s - (here - there) / ago_s
    # Of a velocity that wanders, the means over two spans side by side differ by a third of what
    # it gains in both.
    gained = (change**2).mean(axis=2) / ((ago_s + ahead_s)[..., 0] / 3)
    # Changes asked over spans that overlap tell the same.
    count = np.median(np.diff(times_s)) * np.count_nonzero(asked) / (2 * lag_s)
    told = settings.weight * settings.unsteadiness + count * gained.mean(axis=0)
    return np.asarray(told / (settings.weight + count))


def bridged(
    times_s: Floats, points: Floats, sd: Floats, at_s: float, unsteadiness: Floats
) -> tuple[Floats, Floats, float]:
    """Return where points are at another time, how unsure that is, and what speaks against it.

    The mean and the standard deviation of a motion whose velocity wanders, given where the points
    were seen: the smoothing spline through these places.

    Parameters
    ----------
    times_s : ndarray, shape (n,)
        When they were seen: at two times or more.
    points : ndarray, shape (n, m, 2)
        Where, in widths.
    sd : ndarray, shape (n, m)
        Standard deviation of these places along one axis, widths.
    at_s : float
    unsteadiness : ndarray, shape (m,)
        See `unsteadiness_of`.

    Returns
    -------
    points : ndarray, shape (m, 2)
    sd : ndarray, shape (m,)
        Along one axis, widths.
    misfit : float
        How far any point was seen from that spline, at most, in standard deviations of its place.
    """
    n, m = sd.shape
    since = np.append(times_s, at_s) - min(times_s.min(), at_s)
    first, last = np.minimum.outer(since, since), np.maximum.outer(since, since)
    covariance = first**2 * (last / 2 - first / 6)  # of what is gained, by unit of unsteadiness
    drift = np.column_stack([np.ones(n + 1), since])  # where it was at first, and how fast
    system = np.zeros((m, n + 2, n + 2))
    system[:, :n, :n] = unsteadiness[:, np.newaxis, np.newaxis] * covariance[:n, :n]
    system[:, np.arange(n), np.arange(n)] += sd.T**2
    system[:, :n, n:], system[:, n:, :n] = drift[:n], drift[:n].T
    asked = np.empty((m, n + 2))
    asked[:, :n] = unsteadiness[:, np.newaxis] * covariance[:n, n]
    asked[:, n:] = drift[n]
    given = np.zeros((m, n + 2, 3))  # what is seen, and what the time asked for has to do with it
    given[:, :n, :2], given[..., 2] = points.transpose(1, 0, 2), asked
    solved = np.linalg.solve(system, given)
    place = np.einsum("mn,mnk->mk", asked, solved[..., :2])
    variance = unsteadiness * covariance[n, n] - (asked * solved[..., 2]).sum(axis=1)
    misfit = np.hypot(solved[:, :n, 0], solved[:, :n, 1]) * sd.T
    return place, np.sqrt(np.maximum(variance, 0.0)), float(misfit.max())
