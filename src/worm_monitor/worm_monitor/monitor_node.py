"""Node `monitor`: hears all of a trial and shows it on a page."""

import json
import sys
import time
from functools import partial
from typing import Any

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage, Image, JointState, PointCloud2
from std_msgs.msg import UInt64MultiArray

from worm_monitor.json_numbers import rounded
from worm_monitor.operator_commands import OperatorCommands
from worm_monitor.page_content import PageContent
from worm_monitor.page_server import PageServer
from worm_monitor.past_frames import PastFrames
from worm_monitor.pictures import NextPicture, Waiting, as_jpeg, with_head
from worm_msgs_py import convert, topics
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.errors import BadInput, MalformedMessage
from worm_msgs_py.limits import PAGE_PORT
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.network import LOOPBACK
from worm_msgs_py.ros.qos import FLOW, IMAGE_LIVE, RESULT
from worm_msgs_py.ros.running import run_alone
from worm_msgs_py.ros.worm_node import WormNode
from worm_msgs_py.units import NS_PER_S

NAME = "monitor"
NEWS_EVERY_S = 0.1
_MOST_LATENCY_S = 3600.0
"""Stamps that are further from this machine's clock are of another time."""
LATEST_ONLY = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=256,
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
)
"""What comes with every frame: whoever sends it neither waits nor sends it twice."""


class MonitorNode(WormNode):
    """Shows a trial to browsers; it says nothing on any topic, and nobody waits for it.

    Pictures are subscribed to while a browser looks, one at a time is kept, and it is made a JPEG
    when a browser has shown the last one.

    Raises
    ------
    BadInput
        Where a parameter is out of range, or the port is taken.

    Attributes
    ----------
    pause_s : float
        How long its process may let messages lie: it wakes up for several, not for each.
    """

    pause_s = 0.03
    PARAMETERS = (
        Declaration("host", LOOPBACK, "Address that the page is served on."),
        Declaration(
            "port",
            0,
            "Port of the page; 0: 8642, or a free one where that is taken.",
            PAGE_PORT,
        ),
        Declaration(
            "token",
            "",
            "First part of the page's path, which only those know who may look; where other "
            "machines reach the page and none is given, a new one.",
            shown=lambda token: "(set)" if token else "",
        ),
        Declaration("replay", False, "The trial is a recording, not live."),
        Declaration(
            "player",
            "",
            "Parameters of the node that plays the recording, as JSON: past frames are shown.",
        ),
        Declaration("trial", "", "What the trial is called on the page."),
    )

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(NAME, **node_arguments)
        self._shown = PageContent()
        self._next_picture = NextPicture()
        self._replay = bool(self.read_parameter("replay"))
        self._looking: list[Any] = []
        self._past: PastFrames | None = None
        cv2.setNumThreads(1)
        try:
            self._page = self._open_page()
        except BaseException:
            self.destroy_node()
            raise
        self._commands = OperatorCommands(self, self._shown.take_remark, replay=self._replay)
        self._subscribe()
        self.create_timer(NEWS_EVERY_S, self._tell)

    def _open_page(self) -> PageServer:
        parameter = self.read_parameter
        past = None
        if parameter("player"):
            self._past = PastFrames(parameter("player"))
            past = self._past.frame_at
        return PageServer(parameter("host"), parameter("port"), parameter("token"), past)

    @property
    def address(self) -> str:
        """What a person types into a browser."""
        return self._page.address

    def destroy_node(self) -> None:
        """Tell browsers that this is the end, and close the page."""
        if hasattr(self, "_page"):
            if hasattr(self, "_commands"):
                self._tell(ended=True)
            self._page.close()
        super().destroy_node()

    def _subscribe(self) -> None:
        shown = self._shown
        latest: dict[str, tuple[type, Any]] = {
            topics.WORM_STATE: (JointState, self._on_state),
            topics.WORM_MIDLINE: (PointCloud2, self._on_midline),
            topics.ANALYSIS_STATE: (
                JointState,
                lambda msg: shown.take_observables(convert.observables_from_msg(msg)),
            ),
            topics.MODEL_FORECAST: (
                JointState,
                lambda msg: shown.take_forecast(convert.forecast_from_msg(msg)),
            ),
        }
        for topic, (kind, on_message) in latest.items():
            self.create_subscription(kind, topic, on_message, LATEST_ONLY)
        kept: dict[str, Any] = {
            topics.CHAMBER_GEOMETRY: lambda m: shown.take_geometry(convert.geometry_from_msg(m)),
            topics.ANALYSIS_EVENTS: lambda m: shown.take_events(convert.events_from_msg(m)),
            topics.ANALYSIS_CORRELATION: lambda m: shown.take_correlation(
                convert.correlation_from_msg(m), of_model=False
            ),
            topics.MODEL_CORRELATION: lambda m: shown.take_correlation(
                convert.correlation_from_msg(m), of_model=True
            ),
            topics.ANALYSIS_DISTRIBUTIONS: lambda m: shown.take_distribution(
                convert.distribution_from_msg(m)
            ),
            topics.ANALYSIS_SUMMARY: lambda m: shown.take_quantities(
                convert.quantities_from_msg(m)
            ),
            topics.MODEL_COMPARISON: lambda m: shown.take_comparison(
                convert.comparison_from_msg(m)
            ),
            topics.SOURCE_EVENTS: lambda m: shown.take_source_events(
                convert.source_events_from_msg(m)
            ),
        }
        for topic, on_message in kept.items():
            kind, qos = RESULTS[topic]
            self.create_subscription(kind, topic, on_message, qos)
        self.create_subscription(UInt64MultiArray, topics.FLOW_TRACKED, self._on_counts, FLOW)
        self.create_subscription(DiagnosticArray, topics.DIAGNOSTICS, self._on_health, RESULT)

    def _on_state(self, msg: JointState) -> None:
        state = convert.body_state_from_msg(msg)
        latency_s = None if self._replay else (time.time_ns() - state.stamp_ns) / NS_PER_S
        if latency_s is not None and not 0.0 <= latency_s < _MOST_LATENCY_S:
            latency_s = None
        self._shown.take_state(state, time.monotonic(), latency_s)

    def _on_midline(self, msg: PointCloud2) -> None:
        stamp_ns = convert.stamp_to_ns(msg.header.stamp)
        self._shown.take_midline(stamp_ns, convert.midline_from_msg(msg))
        pose = self._shown.pose(stamp_ns)
        if self._past is not None and pose is not None:
            self._past.remember(self._shown.time_s(stamp_ns), stamp_ns, pose)
        self._show_picture()

    def _on_counts(self, msg: UInt64MultiArray) -> None:
        counts = convert.counts_from_msg(msg)
        if len(counts) != 2:
            raise MalformedMessage(f"{counts} are no frames taken and given")
        self._shown.take_counts(counts[0], time.monotonic())

    def _on_health(self, msg: DiagnosticArray) -> None:
        for status in msg.status:
            values = {item.key: item.value for item in status.values}
            level = int.from_bytes(status.level, "little")
            self._shown.take_health(status.name, level, status.message, values)
            if "head and tail" in status.name and "stamp_ns" in values:
                self._shown.take_remark(f"head and tail {status.message}", int(values["stamp_ns"]))

    def _on_picture(self, kind: type, raw: bytes) -> None:
        now_s = time.monotonic()
        if self._page.wants_picture and self._next_picture.is_wanted(now_s):
            message = deserialize_message(raw, kind)
            stamp_ns = convert.stamp_to_ns(message.header.stamp)
            self._next_picture.offer(Waiting(stamp_ns, message, now_s))
        self._show_picture()

    def _show_picture(self) -> None:
        waiting = self._next_picture.take(time.monotonic(), self._shown.pose)
        if waiting is None:
            return
        try:
            jpeg, scale = as_jpeg(waiting.message)
        except MalformedMessage as error:
            self._shown.take_remark(str(error))
            return
        pose = self._shown.pose(waiting.stamp_ns)
        time_s = rounded(self._shown.time_s(waiting.stamp_ns), 8)
        self._page.show(with_head({"t": time_s, "scale": scale, "pose": pose}, jpeg))

    def _look(self) -> None:
        """Hear pictures while a browser looks, and only then."""
        if self._page.browsers and not self._looking:
            for kind, topic in ((Image, topics.IMAGE), (CompressedImage, topics.IMAGE_COMPRESSED)):
                self._looking.append(
                    self.create_subscription(
                        kind,
                        topic,
                        partial(self._on_picture, kind),
                        IMAGE_LIVE,
                        raw=True,
                    )
                )
        elif not self._page.browsers and self._looking:
            for subscription in self._looking:
                self.destroy_subscription(subscription)
            self._looking.clear()
            self._next_picture.forget()

    def _tell(self, *, ended: bool = False) -> None:
        """Tell browsers what is new, and do what they ask for."""
        if not ended:
            self._look()
        while not self._page.commands.empty():
            self._commands.obey(self._page.commands.get_nowait())
        if not self._page.browsers:
            return
        self._show_picture()
        offers = {} if ended else self._commands.offers()
        self._shown.tell_now(
            time.monotonic(),
            replay=self._replay,
            trial=self.read_parameter("trial"),
            can_look=self._past is not None,
            ended=ended,
            **offers,
        )
        news = json.dumps(self._shown.news(), allow_nan=False)
        everything = None
        if self._page.has_new:
            everything = json.dumps(self._shown.everything(), allow_nan=False)
        self._page.tell(news, everything)


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(_make_node, args, refusals=(BadInput,))


def _make_node() -> MonitorNode:
    node = MonitorNode()
    print(f"Monitor: {node.address}", flush=True)
    return node


if __name__ == "__main__":
    sys.exit(main())
