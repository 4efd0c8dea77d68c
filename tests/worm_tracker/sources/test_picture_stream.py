"""Every message of a source is a picture that can be used, or is told as one that cannot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import CompressedImage, Image

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.picture_stream import PictureStream

SHAPES = {"first": (4, 6), "other": (8, 6)}
EVENT_OF = {"empty": "", "cut": "needs", "other": "it is not rescaled", "unread": "32FC1"}


def message(what):
    height, width = SHAPES.get(what, (4, 6))
    image = Image(height=height, width=width, step=width, encoding="mono8")
    image.data = bytes(np.full(height * width, 7, np.uint8))
    if what == "cut":
        image.data = image.data[:5]
    elif what == "empty":
        image.height = image.width = image.step = 0
        image.encoding, image.data = "", b""
    elif what == "unread":
        image.encoding = "32FC1"
    return image


@given(st.lists(st.sampled_from(["first", "cut", "other", "unread", "empty"]), max_size=30))
def test_good_pictures_are_given_and_each_bad_one_is_counted(kinds):
    stream = PictureStream(64.0)
    told = []
    for frame, kind in enumerate(["first", *kinds]):
        picture, events = stream.read(message(kind), frame, 10 * frame, SHAPES["first"])
        assert picture.shape == (SHAPES["first"] if kind == "first" else (0, 0))
        told += events
    told += stream.end()
    bad = [kind for kind in kinds if EVENT_OF.get(kind)]
    assert sum(event.count for event in told) == len(bad)
    frames = [frame for frame, kind in enumerate(kinds, start=1) if EVENT_OF.get(kind)]
    for event in told:
        assert event.frame in frames
        assert event.stamp_ns == 10 * event.frame
        assert EVENT_OF[kinds[event.frame - 1]] in event.why


def test_a_source_of_which_no_picture_can_be_read_is_refused():
    with pytest.raises(BadInput, match="32FC1"):
        PictureStream(64.0).read(message("unread"), 0, 0, None)


def test_a_camera_that_offers_two_forms_is_heard_in_the_first():
    stream = PictureStream(64.0)
    heard = [stream.is_mine(m) for m in (CompressedImage(), Image(), CompressedImage(), Image())]
    assert heard == [True, False, True, False]
