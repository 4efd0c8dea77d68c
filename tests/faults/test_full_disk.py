"""A disk that fills, a real one of a few megabytes, costs neither the trial nor what is on it."""

import json
import subprocess

import numpy as np
import pyarrow.parquet as pq
import pytest
from mjpeg_server import mjpeg_server
from picture_bags import image, numbered_picture, serialised
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from std_msgs.msg import UInt64

from worm_bringup.recorder.recorder_node import RecorderNode
from worm_msgs_py import (
    BodyState,
    Midline,
    Observables,
    SourceEventKind,
    Status,
    convert,
    topics,
)
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.counting_publisher import Ledger
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW
from worm_msgs_py.ros.worm_node import WormNode
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.sources.cameras.live_record import LiveRecord
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame
from worm_tracker.sources.source_node import drain, spin_source

MIB = 1 << 20


@pytest.fixture
def small_disk(tmp_path):
    """A function that mounts a file system of so many MiB and returns it."""
    mounted = []

    def mount(mib):
        place = tmp_path / "disk"
        place.mkdir()
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={mib}m", "worm-test", place],
            capture_output=True,
            check=False,
        )
        if done.returncode:
            pytest.skip(f"no file system can be mounted here: {done.stderr.decode().strip()}")
        mounted.append(place)
        return place

    yield mount
    for place in mounted:
        subprocess.run(["umount", "--lazy", place], check=True)


def fill(disk, leave=0):
    """Fill what is left of a disk by a file of somebody else's, but for so many bytes."""
    with (disk / "others").open("wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            file.truncate(max(0, file.tell() - leave))


def noise(number):
    return np.random.default_rng(number).integers(0, 256, (300, 400), np.uint8)


def write(record, numbers):
    """Write numbered pictures until the record stops; return why, and the warnings."""
    said = []
    for number in numbers:
        frame = CapturedFrame(numbered_picture(number, (300, 400)), 10**9 + number * 10**8)
        record.write(frame, serialised(image(frame.picture, frame.stamp_ns)))
        record._writer.submit(int).result()  # it is written
        said += record.take_warnings()
        stopped = record.take_stopped()
        if stopped:
            return stopped, said
    return "", said


def test_a_record_warns_early_stops_in_good_order_and_is_whole(small_disk):
    record = LiveRecord(small_disk(12) / "record", "/image_raw")
    stopped, said = write(record, range(200))
    assert "the first" in stopped
    assert "minutes of recording" in said[0]
    assert said.index(stopped) > 0
    with BagPictures(record._directory) as bag:
        stamps = [picture.stamp_ns for picture in bag]
    assert stamps == [10**9 + number * 10**8 for number in range(record.count)]
    assert 40 < record.count < 110
    assert write(record, range(200, 203)) == ("", [])


def test_the_time_that_is_left_is_told_of_the_rate_that_the_record_has(small_disk):
    """The first picture and the head of the file came in no time at all."""
    disk = small_disk(100)
    record = LiveRecord(disk / "record", "/image_raw")
    assert write(record, range(15)) == ("", [])
    assert write(record, range(15, 60))[0] == ""
    left_s = float(record.counts()["disk lasts (minutes)"]) * 60.0
    rate = record._recorder.bytes_on_disk / record._recorder.duration_s
    assert left_s * rate == pytest.approx(record._room.free_bytes, rel=0.1, abs=30.0 * rate)
    record.close()


def test_a_disk_that_others_fill_leaves_the_record_whole(small_disk):
    disk = small_disk(12)
    record = LiveRecord(disk / "record", "/image_raw")
    assert write(record, range(15))[0] == ""
    fill(disk)
    stopped, _ = write(record, range(15, 200))
    assert "No space left on device" in stopped
    with BagPictures(disk / "record") as bag:
        assert len(list(bag)) == record.count > 15
    assert sorted(file.suffix for file in (disk / "record").iterdir()) == [".mcap", ".yaml"]


def test_a_record_for_which_there_is_no_room_is_refused_at_the_start(small_disk):
    with pytest.raises(BadInput, match="No space left on device"):
        LiveRecord(small_disk(1) / "record", "/image_raw")


def test_tracking_goes_on_where_the_record_has_stopped(ros_context, small_disk):
    with mjpeg_server(150, pause_s=0.002, picture=noise) as address:
        node = CameraNode(
            context=ros_context,
            parameter_overrides=[
                Parameter("camera", value=address),
                Parameter("record", value=str(small_disk(6) / "record")),
                Parameter("reconnect", value=0.0),
            ],
        )
        events = []
        tell = node._tell
        node._tell = lambda event: (events.append(event), tell(event))
        executor = SingleThreadedExecutor(context=ros_context)
        executor.add_node(node)
        assert spin_source(executor, node, lambda: True, heed_window=False)
        executor.shutdown()
        node.destroy_node()
    stopped = events[0]
    assert stopped.kind is SourceEventKind.RECORD_STOPPED
    assert 0 < stopped.count < node.sent
    assert "tracking goes on" in stopped.why


class Sender(WormNode):
    """Stands for all other nodes: sends a frame's results through a ledger."""

    def __init__(self, context):
        super().__init__("sender", context=context)
        self.ledger = Ledger(self)
        self.results = {
            topic: self.ledger.publisher(kind, topic, qos) for topic, (kind, qos) in RESULTS.items()
        }
        self.end = self.create_publisher(UInt64, topics.FLOW_END, FLOW)

    def send_frame(self, frame, chance):
        stamp_ns = 10**9 + frame * 40_000_000
        length_px = float(chance.random())
        state = BodyState(frame, stamp_ns, Status.TRACKED, length_px=length_px)
        observables = Observables(frame=frame, stamp_ns=stamp_ns, psi_b_rad=float(chance.random()))
        self.results[topics.WORM_STATE].publish(convert.body_state_to_msg(state))
        self.results[topics.WORM_MIDLINE].publish(convert.midline_to_msg(Midline.empty(), state))
        self.results[topics.ANALYSIS_STATE].publish(convert.observables_to_msg(observables))


def record_results(ros_context, out, frames, before_the_end):
    out.mkdir()
    recorder = RecorderNode(
        context=ros_context,
        parameter_overrides=[
            Parameter("out", value=str(out)),
            Parameter("expect", value=["sender"]),
        ],
    )
    sender, chance = Sender(ros_context), np.random.default_rng(1)
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(recorder)
    executor.add_node(sender)
    try:
        for frame in range(frames):
            sender.send_frame(frame, chance)
            drain(executor)
        before_the_end()
        sender.end.publish(convert.count_to_msg(frames))
        sender.ledger.announce()
        drain(executor)
        return recorder
    finally:
        executor.shutdown()
        recorder.destroy_node()
        sender.destroy_node()


def test_where_the_results_do_not_fit_the_tables_go_before_the_bag(ros_context, small_disk):
    disk = small_disk(2)
    out = disk / "out"
    assert record_results(ros_context, out, 1200, lambda: fill(disk, leave=8192)).done
    summary = json.loads((out / "summary.json").read_text())
    assert summary["frames"]["read"] == 1200
    (event,) = summary["source_events"]
    assert event["kind"] == "record_stopped"
    assert "bag/ is left out" in event["why"]
    assert not (out / "bag").exists()
    assert pq.read_table(out / "tracks.parquet").num_rows == 1200


def test_where_nothing_fits_one_line_says_so(ros_context, small_disk):
    disk = small_disk(2)
    with pytest.raises(BadInput, match=r"cannot be written \(No space left on device\)"):
        record_results(ros_context, disk / "out", 300, lambda: fill(disk))
