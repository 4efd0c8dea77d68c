"""Of a recording any frame that was tracked is shown again: its own picture with its own pose."""

import json

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from picture_bags import numbered_picture, stamps, write_bag

from worm_monitor.past_frames import PastFrames
from worm_msgs_py.errors import BadInput

COUNT, PERIOD_S = 40, 0.05


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("past") / "bag", COUNT)


def shown(frame):
    """Return the head and the picture of what a page is sent."""
    length = int.from_bytes(frame[:4], "little")
    jpeg = np.frombuffer(frame[4 + length :], np.uint8)
    return json.loads(frame[4 : 4 + length]), cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE)


def remembering(bag, first=0, **how):
    past = PastFrames(json.dumps({"bag": str(bag), "start_offset": first * PERIOD_S}), **how)
    for k, stamp_ns in enumerate(stamps(COUNT)[first:]):
        past.remember(k * PERIOD_S, stamp_ns, {"frame": k, "head": [1.5, None]})
    return past


@pytest.mark.parametrize("first", [0, 7])
@pytest.mark.parametrize("k", [0, 11, 32])
def test_the_picture_is_that_of_the_pose(bag, first, k):
    head, picture = shown(remembering(bag, first).frame_at(k * PERIOD_S + 0.01))
    assert head["pose"] == {"frame": k, "head": [1.5, None]}
    assert head["t"] == pytest.approx(k * PERIOD_S)
    differences = [np.abs(picture.astype(int) - numbered_picture(n)).mean() for n in range(COUNT)]
    assert np.argmin(differences) == first + k


@given(st.floats(-10.0, 10.0))
def test_the_nearest_frame_is_shown(time_s):
    past = PastFrames('{"bag": "a bag"}')
    for k in range(5):
        past.remember(float(k), k, {"frame": k})
    time, stamp_ns, _ = past._next_to(time_s)
    assert abs(time - time_s) == min(abs(k - time_s) for k in range(5))
    assert stamp_ns == time


def test_what_is_remembered_is_bounded_and_the_last_ones_stay(bag):
    past = remembering(bag, most=10)
    assert shown(past.frame_at(0.0))[0]["pose"]["frame"] == COUNT - 10


def test_before_the_first_frame_there_is_none(bag):
    with pytest.raises(BadInput, match="no frame"):
        PastFrames(json.dumps({"bag": str(bag)})).frame_at(0.0)


@pytest.mark.parametrize("player", ["{", "[]", "3", "{}", '{"bag": 7}'])
def test_a_player_without_a_bag_is_refused_in_a_line(player):
    with pytest.raises(BadInput, match="names no bag"):
        PastFrames(player)
