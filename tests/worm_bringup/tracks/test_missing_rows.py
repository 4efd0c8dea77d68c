"""Rows that a table of tracks skips are counted, however it is read in parts."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from worm_bringup.tracks.missing_rows import MissingRows

STEP_NS = 40_000_000
START_NS = 1_700_000_000_123_456_789


@given(st.sets(st.integers(1, 398)), st.integers(10, 400))
def test_each_frame_that_has_no_row_is_counted_once(left_out, rows_at_once):
    left_out = {frame for frame in left_out if frame > 30}
    frames = np.array([frame for frame in range(400) if frame not in left_out])
    found = MissingRows()
    for start in range(0, len(frames), rows_at_once):
        found.take(START_NS + STEP_NS * frames[start : start + rows_at_once])
    events = found.events()
    assert sum(event.count for event in events) == len(left_out)
    if left_out:
        after = np.flatnonzero(np.diff(frames) > 1)[0] + 1
        assert events[0].frame == after
        assert events[0].stamp_ns == START_NS + STEP_NS * frames[after]
        gaps = np.count_nonzero(np.diff(frames) > 1)
        assert f"at {gaps} place" in events[0].why


def test_stamps_that_jitter_miss_nothing():
    stamps = START_NS + STEP_NS * np.arange(1000)
    stamps += np.random.default_rng(0).integers(-STEP_NS // 5, STEP_NS // 5, 1000)
    found = MissingRows()
    found.take(stamps)
    assert found.events() == []


def test_a_single_row_misses_nothing():
    found = MissingRows()
    found.take(np.array([START_NS]))
    assert found.events() == []
