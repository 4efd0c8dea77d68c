"""A real WebSocket client sees every channel that is advertised, and a message of each is right."""

import json
import struct
import sys
import time
from contextlib import contextmanager

import cv2
import numpy as np
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from shown_frames import Sender, film
from websockets.sync.client import connect

from worm_bringup.cli import main
from worm_bringup.cli.options import ViewOptions
from worm_bringup.overlay.foxglove_node import FoxgloveNode
from worm_bringup.overlay.foxglove_server import SERVED, FoxgloveServer
from worm_bringup.overlay.plain_numbers import SCHEMAS
from worm_bringup.rig.rig_file import read_rig
from worm_msgs_py.errors import BadInput

LONG_S = 120.0
SUBPROTOCOL = "foxglove.sdk.v1"


class Client:
    """What Foxglove does: takes the advertised channels, subscribes to all, reads messages."""

    def __init__(self, socket):
        self._socket = socket
        self.channels, self.got = {}, {}

    def pump(self):
        """Take what has come."""
        try:
            while True:
                self._take(self._socket.recv(timeout=0.01))
        except TimeoutError:
            return

    def _take(self, message):
        if isinstance(message, str):
            document = json.loads(message)
            if document["op"] == "advertise":
                fresh = {channel["id"]: channel for channel in document["channels"]}
                self.channels |= fresh
                wanted = [{"id": number, "channelId": number} for number in fresh]
                self._socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
        elif message[0] == 1:
            number, log_ns = struct.unpack_from("<IQ", message, 1)
            self.got.setdefault(self.channels[number]["topic"], []).append((log_ns, message[13:]))

    def newest(self, topic):
        """Return the last message of a topic, read by the schema that was advertised."""
        (channel,) = [item for item in self.channels.values() if item["topic"] == topic]
        _, data = self.got[topic][-1]
        if channel["encoding"] == "json":
            return json.loads(data)
        schema = Schema(1, channel["schema"].encode(), "ros2msg", channel["schemaName"])
        return DecoderFactory().decoder_for("cdr", schema)(data)


@contextmanager
def foxglove_at(address):
    with connect(address, subprotocols=[SUBPROTOCOL], max_size=None) as socket:
        yield Client(socket)


@pytest.fixture
def served(ros_context):
    """The node, a sender, and a function that runs them until a thing is so."""
    node = FoxgloveNode(context=ros_context, parameter_overrides=[Parameter("port", value=0)])
    sender = Sender(ros_context)
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(node)
    executor.add_node(sender)

    def until(reached, client):
        end_s = time.monotonic() + LONG_S
        while not reached():
            assert time.monotonic() < end_s, f"it has not come: {sorted(client.got)}"
            executor.spin_once(timeout_sec=0.01)
            client.pump()

    yield node, sender, until
    executor.shutdown()
    node.destroy_node()
    sender.destroy_node()


def test_a_client_gets_a_message_of_every_channel(served):
    node, sender, until = served
    frames, topics = list(film()), {f"/{topic}" for topic in (*SERVED, *SCHEMAS)}
    last_ns = frames[-1][1].stamp_ns
    with foxglove_at(node.address) as client:
        until(lambda: {item["topic"] for item in client.channels.values()} == topics, client)
        until(lambda: node.watched >= topics, client)
        for frame in frames:
            sender.send(*frame)
        until(lambda: client.got.keys() == topics, client)
        until(lambda: client.got["/worm/annotations"][-1][0] == last_ns, client)
        until(lambda: client.got["/image_raw/compressed"][-1][0] == last_ns, client)
        until(lambda: client.got["/analysis/numbers"][-1][0] == last_ns, client)
    check(client, sender.geometry.chambers[0], frames[-1])


def check(client, chamber, last):
    """Check the newest message of each channel against the frame that was sent last."""
    wall = client.newest("/worm/annotations").circles[0]
    assert wall.diameter == pytest.approx(2 * chamber.radius_px)
    assert client.newest("/camera_info").k[0] == pytest.approx(chamber.px_per_m)
    (still,) = client.newest("/tf_static").transforms
    assert (still.header.frame_id, still.child_frame_id) == ("camera_optical_frame", "rig")
    assert client.newest("/tf").transforms[0].child_frame_id == "chamber_a"
    numbers = client.newest("/analysis/numbers")
    assert numbers["r_h_mm"] == pytest.approx(last[3].r_h_m * 1e3)
    assert numbers["psi_b_deg"] == pytest.approx(np.degrees(0.5))
    assert "theta_h_deg" not in numbers  # is not known
    assert client.newest("/analysis/C_theta") == {"lag_s": [0.0, 1.0], "C_theta": [1.0, 0.5]}
    picture = client.newest("/image_raw/compressed")
    seen = cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert np.abs(seen.astype(int) - last[0].astype(int)).mean() < 3.0
    assert client.newest("/chamber").markers[0].header.frame_id == "chamber_a"


def test_a_client_that_comes_late_is_told_what_is_sent_once(served):
    node, sender, until = served
    with foxglove_at(node.address) as first:
        until(lambda: node.watched, first)
        sender.send(*next(iter(film())))
        until(lambda: {"/tf_static", "/chamber"} <= first.got.keys(), first)
        with foxglove_at(node.address) as late:
            until(lambda: {"/tf_static", "/chamber"} <= late.got.keys(), late)


def test_it_listens_to_this_machine_alone(served):
    node, _, _ = served
    assert node.address.startswith("ws://127.0.0.1:")


def test_a_port_that_is_taken_and_an_address_of_another_machine_are_a_line(served):
    node, _, _ = served
    port = int(node.address.rpartition(":")[2])
    with pytest.raises(BadInput, match="Address already in use"):
        FoxgloveServer("127.0.0.1", port)
    with pytest.raises(BadInput, match="--foxglove-host"):
        FoxgloveServer("192.0.2.1", 0)


def test_without_the_extra_a_line_says_what_to_install(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "foxglove", None)
    larva = "bags/larva"
    arguments = ["worm", "replay", larva, "--out", str(tmp_path / "out"), "--foxglove"]
    monkeypatch.setattr(sys, "argv", arguments)
    with pytest.raises(SystemExit) as ended:
        main()
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("worm: ")]
    assert ended.value.code == 2
    assert len(said) == 1
    assert "pip install 'worm-escape[foxglove]'" in said[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", [["--foxglove-port", "9"], ["--foxglove-host", "0.0.0.0"]])
def test_an_address_without_a_server_is_refused(monkeypatch, capsys, tmp_path, option):
    arguments = ["worm", "replay", "bags/larva", "--out", str(tmp_path / "out"), *option]
    monkeypatch.setattr(sys, "argv", arguments)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "--foxglove" in capsys.readouterr().err


def test_a_rig_file_may_say_the_port(tmp_path):
    rig = tmp_path / "rig.yaml"
    rig.write_text("foxglove:\n  ros__parameters:\n    port: 9999\n    jpeg_quality: 50\n")
    told = read_rig([rig])
    (spec,) = ViewOptions(foxglove=True).viewers(told, visible=False)
    assert spec.parameters == {"port": 9999, "jpeg_quality": 50}
    *_, over = ViewOptions(foxglove=True, foxglove_port=7).viewers(told, visible=True)
    assert over.parameters == {"port": 7, "jpeg_quality": 50}
