"""Tracks of a worm with known reversals, lost about each of them as a fold hides it."""

import numpy as np
from walked_tracks import R, track_from_polar, walk


def reversal_times(times, angles):
    """Times at which a walk turns around."""
    way = np.sign(np.diff(angles))
    return times[1:-1][way[1:] != way[:-1]]


def folded(seed, duration_s, rate_hz, *, reversal, lost=1.0, fold_s=(2.0, 5.0), dull_gaps=0):
    """A walk along the wall of a closed ring, filmed; return its track.

    Each reversal is hidden with the probability `lost`, by a gap of a length drawn from `fold_s`
    that holds it anywhere; as many gaps as `dull_gaps` lie anywhere.
    """
    times, angles, depths = walk(seed, duration_s, reversal=reversal)
    t = np.arange(0, duration_s, 1 / rate_hz)
    episode = np.searchsorted(times, t, side="right") - 1
    heading = np.sign(np.diff(angles))[episode]
    r = R - np.minimum(depths[episode], 0.9 * R)
    track = track_from_polar(t, r, np.interp(t, times, angles), heading * np.radians(32))
    rng = np.random.default_rng([seed, 7])
    turns = reversal_times(times, angles)
    hidden = turns[rng.random(len(turns)) < lost]
    hidden = np.concatenate([hidden, rng.uniform(0, duration_s, dull_gaps)])
    gone = np.zeros(len(t), bool)
    for at in hidden:
        length = rng.uniform(*fold_s)
        start = at - length * rng.uniform(0.25, 0.75)
        gone |= (t >= start) & (t < start + length)
    for points in (track.head, track.centroid, track.tail):
        points[gone] = np.nan
    track.yaw[gone] = np.nan
    return track, gone.mean(), len(turns) / duration_s
