"""A worm with a loop, which crosses itself there or touches itself: both cover the same."""

from dataclasses import replace

import numpy as np
from waiting_frames import SEEN, WIDTH

from worm_msgs_py import Status
from worm_tracker.observation import Observation

NODES = 101
LOOP = slice(30, 71)
"""Its nodes between where it meets itself."""


def looped(*, crosses, slid_px=0.0):
    """Return its midline."""
    angle = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 41)
    round_ = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 3 * WIDTH + [4.2 * WIDTH, 0]
    arm = np.linspace(5 * WIDTH, 0.7 * WIDTH, 30)[:, np.newaxis] * [-1, 1]
    into, out = arm, (arm * [1, -1])[::-1]
    if not crosses:
        round_ = round_[::-1]
    return np.concatenate([into, round_, out]) + 200 + [slid_px, 0]


def folded(points, **more):
    """Return what a picture says that tells it."""
    widths = np.full(NODES, WIDTH)
    known = Observation(Status.FOLDED, 200.0, 200.0, points, widths, 0.9, WIDTH, unresolved=SEEN)
    return replace(known, **more)


CROSSING, TOUCHING = folded(looped(crosses=True)), folded(looped(crosses=False))
