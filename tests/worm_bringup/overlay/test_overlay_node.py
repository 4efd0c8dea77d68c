"""The overlay is drawn for those who look, on the frame's own picture, and costs nobody else."""

import sys
import time
import types

import cv2
import numpy as np
import pytest
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import CompressedImage
from shown_frames import Sender, film

from worm_bringup.overlay.overlay_node import OverlayNode
from worm_msgs_py import topics
from worm_msgs_py.colours import HEAD_COLOUR, WALL_COLOUR
from worm_msgs_py.ros.qos import RESULT
from worm_msgs_py.ros.worm_node import WormNode

LONG_S = 120.0


@pytest.fixture
def graph(ros_context):
    """The overlay, a sender, a viewer, and a function that runs them until a thing is so."""
    overlay, sender = OverlayNode(context=ros_context), Sender(ros_context)
    viewer = WormNode("viewer", context=ros_context)
    executor = SingleThreadedExecutor(context=ros_context)
    for node in (overlay, sender, viewer):
        executor.add_node(node)

    def until(reached):
        end_s = time.monotonic() + LONG_S
        while not reached():
            assert time.monotonic() < end_s, "it has not come"
            executor.spin_once(timeout_sec=0.05)

    yield overlay, sender, viewer, until
    executor.shutdown()
    for node in (overlay, sender, viewer):
        node.destroy_node()


def pixels_of(picture, colour):
    blue_green_red = np.array(list(bytes.fromhex(colour[1:])))[::-1]
    v, u = np.nonzero(np.abs(picture.astype(int) - blue_green_red).sum(axis=2) < 110)
    return np.array([np.median(u), np.median(v)]), len(u)


def test_the_overlay_shows_head_and_wall_on_the_frames_own_picture(graph):
    overlay, sender, viewer, until = graph
    seen = []
    viewer.create_subscription(CompressedImage, topics.WORM_OVERLAY, seen.append, RESULT)
    until(lambda: overlay.geometries)  # it has found that somebody looks, and listens
    for frame in film():
        before = len(seen)
        sender.send(*frame)
        until(lambda before=before: len(seen) > before)
    frames = {state.stamp_ns: state for _, state, _, _ in film()}
    for message in seen:
        state = frames[message.header.stamp.sec * 10**9 + message.header.stamp.nanosec]
        drawn = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
        place, _ = pixels_of(drawn, HEAD_COLOUR)
        assert place == pytest.approx((state.head.u_px, state.head.v_px), abs=2.0)
        assert pixels_of(drawn, WALL_COLOUR)[1] > 200
    assert len(seen) == len(frames)


def test_where_nobody_looks_it_listens_to_nothing(graph):
    overlay, _, viewer, until = graph
    assert not list(overlay.subscriptions)
    subscription = viewer.create_subscription(
        CompressedImage, topics.WORM_OVERLAY, lambda _: None, RESULT
    )
    until(lambda: list(overlay.subscriptions))
    viewer.destroy_subscription(subscription)
    until(lambda: not list(overlay.subscriptions))


def test_a_full_ros_has_the_transforms_too(ros_context, monkeypatch):
    """Where `tf2_msgs` can be imported; another message stands for its own, which has no wheel."""
    package, messages = types.ModuleType("tf2_msgs"), types.ModuleType("tf2_msgs.msg")
    messages.TFMessage = CompressedImage
    monkeypatch.setitem(sys.modules, "tf2_msgs", package)
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", messages)
    overlay = OverlayNode(context=ros_context, namespace="/rig1")
    names = {publisher.topic_name for publisher in overlay.publishers}
    overlay.destroy_node()
    assert {"/rig1/tf", "/rig1/tf_static"} <= names
    assert "/rig1/camera_info" not in names  # the tracker's


def test_without_them_it_has_the_pictures_alone(ros_context):
    overlay = OverlayNode(context=ros_context)
    names = {publisher.topic_name for publisher in overlay.publishers}
    overlay.destroy_node()
    assert "/worm/overlay/compressed" in names
    assert not names & {"/tf", "/tf_static", "/worm/annotations"}
