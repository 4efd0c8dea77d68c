"""What a driver sent and never came is counted by DDS's numbers; its stamps are the frames'."""

from itertools import accumulate
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.cameras import topic_camera
from worm_tracker.sources.cameras.topic_camera import TopicCamera


def message(stamp_ns, encoding="mono8", data=bytes(range(12))):
    sec, nanosec = divmod(stamp_ns, 10**9)
    stamp = SimpleNamespace(sec=sec, nanosec=nanosec)
    header = SimpleNamespace(stamp=stamp)
    return SimpleNamespace(
        header=header, encoding=encoding, width=4, height=3, step=4, is_bigendian=0, data=data
    )


def camera():
    found = TopicCamera("/camera/image_raw", 600.0, 5.0, 64.0)
    found.begin()
    return found


@given(st.lists(st.integers(1, 5), min_size=1, max_size=50), st.integers(0, 10**6))
def test_what_came_and_what_was_lost_is_what_was_sent(steps, first):
    driver = camera()
    numbers = list(accumulate(steps, initial=first))
    for number in numbers:
        driver.take_message(message(number + 1), number)
    stamps = [frame.stamp_ns for frame in iter(driver.take, None)]
    assert stamps == [number + 1 for number in numbers]
    assert len(stamps) + driver.counts.lost == numbers[-1] - first + 1


def test_a_driver_is_silent_from_when_all_are_ready_and_not_while_they_get_ready(monkeypatch):
    now_s = [0.0]
    clock = SimpleNamespace(now_ns=lambda: round(now_s[0] * 1e9))
    monkeypatch.setattr(topic_camera, "SteadyClock", lambda: clock)
    driver = TopicCamera("/camera/image_raw", reconnect_s=0.0, stall_s=5.0, max_megapixels=64.0)
    now_s[0] = 60.0
    driver.begin()
    now_s[0] = 64.9
    assert driver.outage is None
    assert not driver.ended
    now_s[0] = 65.1
    assert driver.outage is not None
    assert driver.ended
    assert driver.why_lost == "no frame has come on /camera/image_raw for 5 s"


def test_a_driver_that_begins_anew_has_lost_nothing():
    driver = camera()
    for stamp, number in enumerate((7, 8, 1, 2, 3), start=1):
        driver.take_message(message(stamp), number)
    assert (driver.counts.captured, driver.counts.lost) == (5, 0)


def test_a_stamp_that_does_not_grow_is_no_frame():
    driver = camera()
    for number, stamp in enumerate((10, 20, 20, 15, 30)):
        driver.take_message(message(stamp), number)
    assert [frame.stamp_ns for frame in iter(driver.take, None)] == [10, 20, 30]
    assert driver.counts.lost == 2


def test_a_picture_that_is_cut_is_a_bad_frame_and_says_why():
    driver = camera()
    driver.take_message(message(1), 1)
    driver.take_message(message(2, data=b"123"), 2)
    good, bad = iter(driver.take, None)
    np.testing.assert_array_equal(good.picture.ravel(), range(12))
    assert (good.why_bad, bad.picture.size) == ("", 0)
    assert "needs 4 bytes a row" in bad.why_bad


def test_an_encoding_that_is_not_read_is_refused_with_those_that_are():
    with pytest.raises(BadInput, match=r"'bayer_rggb8'.*mono8, mono16, bgr8, rgb8"):
        camera().take_message(message(1, "bayer_rggb8"), 1)


def test_pictures_without_a_stamp_are_refused():
    with pytest.raises(BadInput, match="bear no stamp"):
        camera().take_message(message(0), 1)
