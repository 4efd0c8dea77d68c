"""What lies between frames is told by their stamps alone."""

from itertools import accumulate

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.frame_intervals import FrameIntervals, FrameIntervalSettings

FRAME_NS = 40_000_000


def elapsed(stamps_ns):
    intervals = FrameIntervals(FrameIntervalSettings())
    return [intervals.push(stamp_ns) for stamp_ns in stamps_ns]


def counted(stamps_ns):
    return [between.frames_missing for between in elapsed(stamps_ns)]


@given(
    gaps=st.lists(st.integers(0, 400), max_size=12),
    late=st.lists(st.floats(-0.05, 0.05), min_size=80, max_size=80),
    frame_ns=st.integers(1_000_000, 500_000_000),
)
def test_frames_that_are_missing_here_and_there_are_counted_however_stamps_jitter(
    gaps, late, frame_ns
):
    missing = [0] * 6
    for gap in gaps:
        missing += [gap, 0, 0, 0]
    numbers = list(accumulate(1 + gap for gap in missing))
    stamps = [round((n + j) * frame_ns) for n, j in zip(numbers, late[: len(numbers)], strict=True)]
    assert counted(stamps) == pytest.approx(missing, rel=0.35, abs=0)
    exact = [n * frame_ns for n in numbers]
    assert counted(exact) == missing


@pytest.mark.parametrize("every", [1, 2, 25])
def test_a_recording_of_every_so_many_th_frame_misses_none(every):
    assert counted(range(0, 3_000_000_000, every * FRAME_NS)) == [0] * len(
        range(0, 3_000_000_000, every * FRAME_NS)
    )


def test_a_rate_that_changes_is_the_usual_one_before_long():
    fast, slow = [FRAME_NS] * 40, [2 * FRAME_NS] * 40
    missing = counted(accumulate(fast + slow))
    assert sum(missing[:40]) == 0
    assert sum(missing[40:]) == 16, "half of what the usual interval is taken of"
    assert missing[-20:] == [0] * 20


@given(st.lists(st.integers(-FRAME_NS, 0), max_size=20))
def test_stamps_that_do_not_increase_show_nothing_missing(steps):
    assert counted(accumulate([0, *steps])) == [0] * (1 + len(steps))


def test_a_stamp_that_falls_back_is_not_taken_for_the_usual_interval():
    stamps = [n * FRAME_NS for n in (0, 1, 2, 3, 4, 2, 5, 6, 8)]
    assert counted(stamps) == [0, 0, 0, 0, 0, 0, 2, 0, 1]


@pytest.mark.parametrize(
    ("rate_hz", "steps"), [(100, 1), (30, 1), (25, 1), (15, 1), (8, 2), (5, 3), (1, 15), (0.1, 15)]
)
def test_a_worm_may_move_for_as_long_as_a_slow_camera_does_not_look(rate_hz, steps):
    between = elapsed(range(0, 90_000_000_000, round(1_000_000_000 / rate_hz)))
    assert [each.steps for each in between[1:]] == [steps] * (len(between) - 1)


@pytest.mark.parametrize(
    ("interval_ms", "steps", "over"),
    [
        pytest.param(40, 1, 1.0, id="25 a second"),
        pytest.param(80, 1, 1.2, id="12.5 a second"),
        pytest.param(133, 2, 1.0, id="7.5 a second"),
        pytest.param(150, 2, 1.125, id="6.7 a second"),
    ],
)
def test_a_worm_may_do_as_much_more_as_an_interval_is_longer_than_whole_steps(
    interval_ms, steps, over
):
    between = elapsed([k * interval_ms * 1_000_000 for k in range(4)])[-1]
    assert between.steps == steps
    assert between.over_steps == pytest.approx(over, abs=0.005)
