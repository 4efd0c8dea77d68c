"""Frames that wait in a queue: coils and midlines, without a picture behind them."""

from itertools import zip_longest

import numpy as np
from crawling_worm import FRAME_NS

from worm_msgs_py import Status
from worm_tracker.frame_intervals import AT_ONCE, Elapsed
from worm_tracker.head_tail.identity import HeadTail, HeadTailSettings
from worm_tracker.observation import Observation
from worm_tracker.tracker import TRACKER
from worm_tracker.waiting.frame_queue import FrameQueue
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.worm_track import WormTrack

WIDTH = 12.0
SEEN = object()
"""Stands for what was kept of a picture: the queue hands it on and never looks into it."""
LINE = np.stack([np.linspace(20, 120, 121), np.full(121, 40.0)], axis=1)


def midline(**more):
    return Observation(
        Status.TRACKED, 70.0, 40.0, LINE, np.full(121, WIDTH), 1.0, WIDTH, (0, 0), None, **more
    )


def coil(**more):
    return Observation(Status.COILED, 70.0, 40.0, unresolved=SEEN, **more)


def queue_of(*observations, hold_back_frames=256, steps=(), track=None):
    queue = FrameQueue(
        HeadTail(track or WormTrack(), HeadTailSettings()),
        hold_back_frames,
        np.nan,
        most_frames_for_body=TRACKER.most_frames_for_body,
        agreement=TRACKER.agreement,
        brief_gaps=TRACKER.brief_gaps,
    )
    for frame, (observation, elapsed) in enumerate(zip_longest(observations, map(Elapsed, steps))):
        stamp_ns = frame * FRAME_NS
        queue.push(PendingFrame(frame, stamp_ns, observation, None, elapsed or AT_ONCE))
    return queue
