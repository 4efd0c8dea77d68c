"""Every frame has its camera, its transforms and its annotations, in whatever order topics come."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from worm_bringup.overlay.frame_join import FrameJoin
from worm_bringup.overlay.shapes import shapes_of
from worm_bringup.overlay.viewer_messages import TYPE_OF_TOPIC, TYPES, camera_to_cdr, shapes_to_cdr
from worm_bringup.overlay.views import FrameViews
from worm_model.simulator.rig import Rig
from worm_msgs_py import BodyState, Geometry, Midline, Status, topics
from worm_msgs_py.colours import WALL_COLOUR
from worm_msgs_py.contract.camera_view import pinhole

FIRST = Rig(chamber_b=True).geometry()
BUMPED = replace(Rig(chamber_b=True, centre_px=(515.0, 509.0)).geometry(), version=2)


def decoded(topic, data):
    """Read a message by a library that is not ours and did not write it."""
    kind = TYPE_OF_TOPIC[topic]
    definition, _ = TYPES.generate_msgdef(kind, ros_version=2)
    return DecoderFactory().decoder_for("cdr", Schema(1, definition.encode(), "ros2msg", kind))(
        data
    )


def written(states, geometries, order=None):
    """Return topic, stamp and message of all that is written of some frames."""
    join, views = FrameJoin(), FrameViews()
    steps = [(join.add_geometry, item) for item in geometries]
    steps += [(join.add_state, state) for state in states]
    steps += [(join.add_midline, Midline.empty()) for _ in states]
    frames = [frame for add, item in (order(steps) if order else steps) for frame in add(item)]
    return [
        (topic, frame.state.stamp_ns, decoded(topic, data))
        for frame in (*frames, *join.finish())
        for topic, data in views.of(frame)
    ]


def states(*versions):
    return [
        BodyState(frame=k, stamp_ns=10**9 + k * 10**8, geometry=version)
        for k, version in enumerate(versions)
    ]


def on(topic, messages):
    return [(stamp_ns, message) for name, stamp_ns, message in messages if name == topic]


def in_order_of_each_topic(steps):
    """Yield some interleavings of the three topics, each in its own order."""
    for turn in itertools.permutations(range(3)):
        kinds = [[], [], []]
        for step in steps:
            kinds[["add_geometry", "add_state", "add_midline"].index(step[0].__name__)].append(step)
        yield [step for kind in turn for step in kinds[kind]]


def test_every_frame_has_a_camera_transforms_and_annotations_with_its_own_stamp():
    out = written(states(1, 1, 2), [FIRST, BUMPED])
    stamps = [10**9, 1_100_000_000, 1_200_000_000]
    for topic in (topics.CAMERA_INFO, topics.TF, topics.WORM_ANNOTATIONS):
        assert [stamp_ns for stamp_ns, _ in on(topic, out)] == stamps
    for stamp_ns, message in on(topics.CAMERA_INFO, out):
        own = message.header.stamp
        assert own.sec * 10**9 + own.nanosec == stamp_ns
        assert message.header.frame_id == "camera_optical_frame"


def test_the_camera_stands_once_and_no_frame_is_both_static_and_moving():
    out = written(states(1, 2), [FIRST, BUMPED])
    ((_, still),) = on(topics.TF_STATIC, out)
    children = {item.child_frame_id for item in still.transforms}
    moving = {t.child_frame_id for _, tf in on(topics.TF, out) for t in tf.transforms}
    assert children == {"rig"}
    assert moving == {"chamber_a", "chamber_b"}


def test_the_chambers_move_with_the_first_frame_after_a_bump():
    places = [
        tf.transforms[0].transform.translation.x
        for _, tf in on(topics.TF, written(states(1, 1, 2, 2), [FIRST, BUMPED]))
    ]
    assert places == pytest.approx([0.0, 0.0, 3.5 / 40e3, 3.5 / 40e3])


def test_the_order_between_topics_changes_nothing():
    frames, geometries = states(0, 1, 1, 0, 2), [FIRST, BUMPED]
    expected = str(written(frames, geometries))
    for turn in range(6):
        order = lambda steps, turn=turn: list(in_order_of_each_topic(steps))[turn]  # noqa: E731
        assert str(written(frames, geometries, order)) == expected


def test_a_bad_picture_has_the_rig_of_the_frame_before():
    out = written(states(2, 0), [FIRST, BUMPED])
    before, bad = (tf for _, tf in on(topics.TF, out))
    assert bad.transforms[0].transform.translation.x == before.transforms[0].transform.translation.x


def test_before_the_rig_is_found_the_camera_has_a_size_and_no_focal_length():
    out = written(states(0, 1), [FIRST])
    unknown, known = (message for _, message in on(topics.CAMERA_INFO, out))
    assert (unknown.width, unknown.height, unknown.k[0]) == (1024, 1024, 0.0)
    assert known.k[0] > 0
    assert len(on(topics.TF, out)) == 1


def test_pictures_without_a_chamber_have_no_transforms_and_an_uncalibrated_camera():
    out = written(states(0, 0), [Geometry(1, 0, 640, 480)])
    assert not on(topics.TF, out)
    assert not on(topics.TF_STATIC, out)
    for _, message in on(topics.CAMERA_INFO, out):
        assert np.asarray(message.k).tolist() == [0.0] * 9
        assert (message.width, message.height) == (640, 480)


def test_where_no_rig_is_ever_found_the_annotations_still_tell_of_each_frame():
    out = written(states(0, 0), [])
    assert [topic for topic, _, _ in out] == [topics.WORM_ANNOTATIONS] * 2


def test_foxglove_counts_from_the_corner_of_a_pixel_and_we_from_its_middle():
    state = BodyState(frame=0, stamp_ns=0, status=Status.TRACKED, geometry=1)
    data = shapes_to_cdr(shapes_of(state, Midline.empty(), FIRST), 0)
    wall = decoded(topics.WORM_ANNOTATIONS, data).circles[0]
    assert (wall.position.x, wall.position.y) == pytest.approx((512.0, 512.0))
    assert wall.diameter == pytest.approx(800.0)
    colour = [round(255 * part) for part in (wall.outline_color.r, wall.outline_color.g)]
    assert bytes(colour).hex() == WALL_COLOUR[1:5].lower()


def test_the_reason_is_written_in_the_corner():
    state = BodyState(frame=0, stamp_ns=0, status=Status.COILED)
    data = shapes_to_cdr(shapes_of(state, Midline.empty(), None), 0)
    (text,) = decoded(topics.WORM_ANNOTATIONS, data).texts
    assert text.text == "coiled"


def test_nothing_of_the_memory_gets_between_the_fields():
    """rclpy leaves the bytes between fields as it finds them; a bag is to be the same each time."""
    data = camera_to_cdr(pinhole(FIRST), 1)
    name = data.index(b"camera_optical_frame\0")
    end = name + len(b"camera_optical_frame\0")
    assert data[end : end + -(end - 4) % 4] == bytes(-(end - 4) % 4)
    assert len(data) > end
