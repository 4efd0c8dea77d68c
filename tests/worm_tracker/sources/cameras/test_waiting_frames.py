"""A tracker that is busy for a moment loses no frame; one that lags gets the newest; all count."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.sources.cameras.waiting_frames import CapturedFrame, WaitingFrames


def frame(number):
    return CapturedFrame(np.zeros((1, 1), np.uint8), number)


def begun(most):
    frames = WaitingFrames(most)
    frames.begin()
    return frames


def put(frames, numbers):
    for number in numbers:
        frames.put(frame(number))


def taken(frames):
    found = []
    while (one := frames.take()) is not None:
        found.append(one.stamp_ns)
    return found


@given(st.lists(st.booleans(), max_size=60), st.integers(1, 8))
def test_no_frame_is_lost_count_of(puts, most):
    frames, given_ns = begun(most), []
    for number, is_put in enumerate(puts, start=1):
        if is_put:
            frames.put(frame(number))
        elif (one := frames.take()) is not None:
            given_ns.append(one.stamp_ns)
    captured, count, skipped, waiting = frames.counts()
    assert (captured, count) == (sum(puts), len(given_ns))
    assert captured == count + skipped + waiting
    assert frames.waiting == bool(waiting)
    assert given_ns == sorted(set(given_ns))
    assert waiting <= most


@given(st.lists(st.integers(0, 8), max_size=30))
def test_a_tracker_that_catches_up_again_and_again_skips_none(bursts):
    frames, number, given_ns = begun(8), 0, []
    for burst in bursts:
        put(frames, range(number, number + burst))
        number += burst
        given_ns += taken(frames)
    assert given_ns == list(range(number))
    assert frames.counts() == (number, number, 0, 0)


def test_where_the_tracker_lags_the_newest_frame_wins():
    frames = begun(4)
    put(frames, range(5))
    assert taken(frames) == [4]
    put(frames, range(5, 8))  # it still lags: none waits but the newest
    assert taken(frames) == [7]
    assert frames.counts() == (8, 2, 6, 0)


def test_once_it_has_kept_up_for_long_enough_frames_may_wait_again():
    frames = begun(4)
    put(frames, range(5))
    for number in range(5, 8):
        assert frames.take().stamp_ns == number - 1
        frames.put(frame(number))
    assert taken(frames) == [7]
    put(frames, range(8, 12))
    assert taken(frames) == [8, 9, 10, 11]


def test_before_the_graph_is_ready_the_newest_is_held_and_nothing_counts():
    frames = WaitingFrames(4)
    put(frames, range(3))
    frames.begin()
    put(frames, range(3, 5))
    assert taken(frames) == [2, 3, 4]
    assert frames.counts() == (3, 3, 0, 0)


def test_of_large_frames_fewer_wait():
    frames = WaitingFrames(8, most_bytes=5, least=2)  # a frame has one byte
    frames.begin()
    put(frames, range(5))
    assert taken(frames) == [0, 1, 2, 3, 4]
    put(frames, range(5, 11))
    assert taken(frames) == [10]


def test_so_many_wait_however_large_they_are():
    frames = WaitingFrames(8, most_bytes=0, least=3)
    frames.begin()
    put(frames, range(3))
    assert taken(frames) == [0, 1, 2]


def test_at_the_end_the_oldest_few_are_taken_and_the_others_counted():
    frames = WaitingFrames(8, least=3)
    frames.begin()
    put(frames, range(8))
    frames.end()
    assert taken(frames) == [0, 1, 2]
    assert frames.counts() == (8, 3, 5, 0)
