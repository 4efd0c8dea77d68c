"""What a camera does not take is told; the region is cut out of whatever it sends."""

import time

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mjpeg_server import jpeg_picture, mjpeg_server
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from worm_msgs_py import SourceEventKind
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.pictures import pictures_of_bag
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.sources.cameras import camera
from worm_tracker.sources.cameras.camera_address import Kind
from worm_tracker.sources.cameras.camera_settings import CameraSettings, Region
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame
from worm_tracker.sources.source_node import spin_source

WISHES = CameraSettings(width_px=1024, height_px=1024, frames_per_s=30.0, exposure_ms=8.0)


class Device:
    """A V4L2 device as OpenCV shows it: it takes what it can, and says of the rest what it does."""

    def __init__(self, **fixed):
        self.values = {getattr(cv2, name): value for name, value in fixed.items()}
        self.fixed = set(self.values)
        self.asked = {}

    def set(self, number, value):
        self.asked[number] = value
        if number not in self.fixed:
            self.values[number] = value
        return True  # as drivers say, whether they have taken it or not

    def get(self, number):
        return self.values.get(number, 0.0)


def test_what_a_device_takes_is_set_in_its_own_units():
    device = Device()
    assert WISHES.apply(device, Kind.DEVICE) == []
    assert device.asked == {
        cv2.CAP_PROP_AUTO_EXPOSURE: 1,
        cv2.CAP_PROP_FRAME_WIDTH: 1024,
        cv2.CAP_PROP_FRAME_HEIGHT: 1024,
        cv2.CAP_PROP_FPS: 30.0,
        cv2.CAP_PROP_EXPOSURE: 80.0,
    }


def test_what_a_device_does_not_take_is_told_with_what_it_gives():
    device = Device(CAP_PROP_FRAME_HEIGHT=768.0, CAP_PROP_EXPOSURE=156.0)
    assert WISHES.apply(device, Kind.DEVICE) == [
        "1024 px of height were asked for, 768 are given",
        "8 ms of exposure were asked for, 15.6 are given",
    ]


def test_a_device_that_is_asked_for_nothing_is_left_alone():
    device = Device()
    assert CameraSettings().apply(device, Kind.DEVICE) == []
    assert device.asked == {}


@pytest.mark.parametrize("kind", [Kind.STREAM, Kind.FILE])
def test_what_cannot_be_set_is_told(kind):
    assert CameraSettings(frames_per_s=30.0).apply(None, kind) == [
        f"the rate of a {kind.value} cannot be set: 30 frames/s were asked for"
    ]


@given(st.lists(st.integers(0, 60), min_size=2, max_size=2), st.integers(1, 70), st.integers(1, 60))
def test_a_region_is_that_part_or_a_bad_frame(corner, width, height):
    picture = np.arange(48 * 64, dtype=np.uint16).reshape(48, 64).astype(np.uint8)
    u, v = corner
    frame = Region(u, v, width, height).of(CapturedFrame(picture, 7))
    assert frame.stamp_ns == 7
    if u + width <= 64 and v + height <= 48:
        np.testing.assert_array_equal(frame.picture, picture[v : v + height, u : u + width])
        assert frame.why_bad == ""
    else:
        assert frame.picture.size == 0
        assert "not within the picture of 64 × 48" in frame.why_bad


def watched(context, address, **parameters):
    """Run a camera node to its end; return it and what it told."""
    given = {"camera": address, "reconnect": 0.0, **parameters}
    node = CameraNode(
        context=context,
        parameter_overrides=[Parameter(name, value=value) for name, value in given.items()],
    )
    events = []
    tell = node._tell
    node._tell = lambda event: (events.append(event), tell(event))
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        spin_source(executor, node, lambda: True, heed_window=False)
    finally:
        executor.shutdown()
        node.destroy_node()
    return events


def test_the_region_is_what_is_sent_and_recorded_and_the_rest_is_told(ros_context, tmp_path):
    region = {"region_u_px": 8, "region_v_px": 16, "region_width_px": 32, "region_height_px": 24}
    with mjpeg_server(5) as address:
        events = watched(
            ros_context, address, record=str(tmp_path / "bag"), frames_per_s=30.0, **region
        )
    first, *_ = events
    assert first.kind is SourceEventKind.NOT_ACCEPTED
    assert "the rate of a stream cannot be set" in first.why
    pictures = [grey for grey, _ in pictures_of_bag(tmp_path / "bag")]
    last = jpeg_picture(4)[16:40, 8:40].astype(int)
    assert np.abs(pictures[-1].astype(int) - last).max() < 40


def test_a_region_outside_the_pictures_is_refused_at_the_first(ros_context):
    with mjpeg_server(5) as address, pytest.raises(BadInput, match=r"--region-px"):
        watched(ros_context, address, region_width_px=640, region_height_px=480)


class FilmingDevice(Device):
    """A device that films: each picture is as bright as its exposure is long, 100 µs a grey."""

    def __init__(self, **fixed):
        super().__init__(CAP_PROP_FPS=200.0, **fixed)
        self.values.setdefault(cv2.CAP_PROP_EXPOSURE, 50.0)

    def grab(self):
        time.sleep(0.005)  # the pace of this camera
        return True

    def retrieve(self):
        return True, np.full((48, 64), self.values[cv2.CAP_PROP_EXPOSURE], np.uint8)

    def release(self):
        pass


@pytest.fixture
def filming(ros_context, monkeypatch):
    """Give a function that makes a camera node of a device, and what it told."""
    nodes = []

    def make(device):
        monkeypatch.setattr(camera, "open_capture", lambda *_: device)
        given = [Parameter("camera", value="/dev/video0")]
        node = CameraNode(context=ros_context, parameter_overrides=given)
        nodes.append(node)
        events = []
        node._tell = events.append
        node.begin()
        return node, events

    yield make
    for node in nodes:
        node.destroy_node()


def sent(node, until):
    """Publish frames until one is such; return its level and number."""
    levels = []
    node._publisher.publish = lambda raw: levels.append(raw[-1])
    while not (levels and until(levels[-1])):
        node.publish_next()
    return levels[-1]


def test_an_exposure_that_is_set_while_it_films_holds_for_frames_after_it_and_is_told(filming):
    device = FilmingDevice()
    node, events = filming(device)
    sent(node, lambda level: level == 50)
    (result,) = node.set_parameters([Parameter("exposure_ms", value=8)])
    assert result.successful, result.reason
    frame = node.sent
    assert sent(node, lambda level: level != 50) == 80
    (event,) = events
    assert (event.kind, event.frame) == (SourceEventKind.PARAMETER_CHANGED, frame)
    assert event.why == "image_source: exposure_ms changed from 0.0 to 8.0"
    assert set(device.asked) == {cv2.CAP_PROP_AUTO_EXPOSURE, cv2.CAP_PROP_EXPOSURE}


def test_an_exposure_that_a_device_does_not_take_is_told(filming):
    node, events = filming(FilmingDevice(CAP_PROP_EXPOSURE=50.0))
    assert node.set_parameters([Parameter("exposure_ms", value=8.0)])[0].successful
    while len(events) < 2:
        node.publish_next()
    assert events[1].kind is SourceEventKind.NOT_ACCEPTED
    assert events[1].why == "8 ms of exposure were asked for, 5 are given"


def test_a_new_trial_ends_the_stream_in_order_once_a_frame_has_come(filming):
    node, _ = filming(FilmingDevice())

    def asked():
        answer = node._on_new_trial(Trigger.Request(), Trigger.Response())
        return answer.success, answer.message

    assert asked() == (False, "no frame has come yet")
    assert not node.next_is_asked
    while not node.sent:
        node.publish_next()
    assert asked()[0]
    assert node.next_is_asked
    assert asked() == (False, "the trial is ending")
    while node.publish_next():
        pass
    assert node.done
    assert not node.ended_early


def test_an_exposure_that_cannot_be_set_is_refused(filming, ros_context):
    node, _ = filming(FilmingDevice())
    assert "by itself" in node.set_parameters([Parameter("exposure_ms", value=0.0)])[0].reason
    assert node.set_parameters([Parameter("width_px", value=640)])[0].reason.startswith("width_px")
    with mjpeg_server(5) as address:
        given = [Parameter("camera", value=address)]
        stream = CameraNode(context=ros_context, parameter_overrides=given)
        (result,) = stream.set_parameters([Parameter("exposure_ms", value=8.0)])
        assert result.reason == "the exposure of a stream cannot be set from here"
        stream.destroy_node()
