"""The latest frame wins, and every frame is taken, overwritten or still there."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.sources.cameras.latest_frame import CapturedFrame, LatestFrame


@given(st.lists(st.booleans(), max_size=40))
def test_no_frame_is_lost_count_of(puts):
    latest, last_ns, given_ns = LatestFrame(), 0, []
    for number, put in enumerate(puts, start=1):
        if put:
            latest.put(CapturedFrame(np.zeros((1, 1), np.uint8), number))
            last_ns = number
        elif (frame := latest.take()) is not None:
            assert frame.stamp_ns == last_ns
            given_ns.append(frame.stamp_ns)
    captured, taken, skipped, waiting = latest.counts()
    assert (captured, taken, waiting) == (sum(puts), len(given_ns), int(latest.waiting))
    assert captured == taken + skipped + waiting
    assert given_ns == sorted(set(given_ns))
