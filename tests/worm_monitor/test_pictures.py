"""One picture at a time, with the pose that was found in it, whatever encoding it came in."""

import array

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image

from worm_monitor.pictures import (
    MOST_A_SECOND,
    WAIT_FOR_POSE_S,
    WIDEST_PX,
    NextPicture,
    Waiting,
    as_jpeg,
)
from worm_msgs_py.errors import MalformedMessage

GREY = np.tile(np.linspace(10, 240, 96, dtype=np.uint8), (64, 1))


def image(picture, encoding, pad=0):
    rows = picture.reshape(picture.shape[0], -1).view(np.uint8)
    rows = np.pad(rows, ((0, 0), (0, pad)))
    return Image(
        height=picture.shape[0],
        width=picture.shape[1],
        encoding=encoding,
        step=rows.shape[1],
        data=array.array("B", rows.tobytes()),
    )


def compressed(suffix, picture):
    return CompressedImage(data=array.array("B", cv2.imencode(suffix, picture)[1].tobytes()))


def seen(message):
    jpeg, scale = as_jpeg(message)
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE), scale


@pytest.mark.parametrize(
    "message",
    [
        image(GREY, "mono8"),
        image(GREY, "mono8", pad=5),
        image(np.ascontiguousarray(np.repeat(GREY[:, :, None], 3, axis=2)), "bgr8"),
        image(np.ascontiguousarray(np.repeat(GREY[:, :, None], 3, axis=2)), "rgb8"),
        image(GREY.astype(np.uint16) << 4, "mono16"),
        compressed(".jpg", GREY),
        compressed(".png", GREY),
    ],
    ids=["mono8", "padded", "bgr8", "rgb8", "12 bits", "jpeg", "png"],
)
def test_a_picture_is_shown_as_it_is(message):
    picture, scale = seen(message)
    assert scale == 1.0
    assert np.abs(picture.astype(int) - GREY).max() <= 8


def test_a_wide_picture_is_made_smaller_by_the_scale_that_is_told():
    picture, scale = seen(image(np.zeros((100, 2 * WIDEST_PX), np.uint8), "mono8"))
    assert picture.shape == (50, WIDEST_PX)
    assert scale == 0.5


@pytest.mark.parametrize(
    "message",
    [
        CompressedImage(data=array.array("B", b"no picture")),
        Image(height=4, width=4, encoding="mono8", step=4, data=array.array("B", b"short")),
        Image(height=4, width=4, encoding="bayer_rggb8", step=4, data=array.array("B", 16 * b"a")),
    ],
    ids=["not compressed so", "short", "unknown encoding"],
)
def test_what_is_no_picture_is_refused(message):
    with pytest.raises(MalformedMessage):
        as_jpeg(message)


def test_a_picture_waits_for_its_own_pose():
    next_picture, poses = NextPicture(), {}
    assert next_picture.is_wanted(0.0)
    next_picture.offer(Waiting(7, "picture", 0.0))
    assert not next_picture.is_wanted(10.0)  # one at a time
    poses[6] = "of another frame"
    assert next_picture.take(0.1, poses.get) is None
    poses[7] = "its own"
    assert next_picture.take(0.2, poses.get).stamp_ns == 7
    assert next_picture.take(0.3, poses.get) is None


def test_a_pose_that_is_held_back_for_long_is_not_waited_for():
    next_picture = NextPicture()
    next_picture.offer(Waiting(7, "picture", 0.0))
    assert next_picture.take(0.99 * WAIT_FOR_POSE_S, {}.get) is None
    assert next_picture.take(WAIT_FOR_POSE_S, {}.get).stamp_ns == 7


def test_pictures_come_no_faster_than_people_see():
    next_picture, shown = NextPicture(), 0
    for k in range(1000):  # a thousand a second, each acknowledged at once
        now_s = k / 1000
        if next_picture.is_wanted(now_s):
            next_picture.offer(Waiting(k, "picture", now_s))
        shown += next_picture.take(now_s, lambda stamp_ns: "pose") is not None
    assert MOST_A_SECOND - 1 <= shown <= MOST_A_SECOND + 1
