"""The tracker as a ROS node: pictures in, `worm/*` and `chamber/*` out, a state for every frame."""

import sys
from datetime import UTC, datetime
from math import isfinite
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.event_handler import SubscriptionEventCallbacks
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import UInt64, UInt64MultiArray
from std_srvs.srv import Trigger

from worm_msgs_py import SourceEvent, SourceEventKind, convert, topics
from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.camera_view import pinhole
from worm_msgs_py.contract.chamber import Geometry
from worm_msgs_py.convert.stamp import header
from worm_msgs_py.declarations import Declaration, declarations
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import CORRECTIONS, corrections_from_json
from worm_msgs_py.ros.counting_publisher import Ledger
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, IMAGE_LIVE, IMAGE_REPLAY, RESULT
from worm_msgs_py.ros.running import run_alone
from worm_msgs_py.ros.stream_end import StreamEnd
from worm_msgs_py.ros.worm_node import WormNode
from worm_msgs_py.units import NS_PER_S
from worm_tracker.head_tail.identity import Exchange, ExchangeKind
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.picture_stream import PictureStream
from worm_tracker.tracker import Tracker

NAME = "tracker"
_POSES = {
    topics.WORM_HEAD: "head",
    topics.WORM_CENTROID: "centroid",
    topics.WORM_TAIL: "tail",
}
_OUT = {
    topics.CHAMBER,
    topics.CHAMBER_GEOMETRY,
    topics.WORM_STATE,
    topics.WORM_MIDLINE,
    topics.SOURCE_EVENTS,
    *_POSES,
}


class TrackerNode(WormNode):
    """Tracks the worm in the pictures of one source.

    Parameters
    ----------
    **node_arguments
        As for `rclpy.node.Node`.

    Notes
    -----
    Each time that head and tail are exchanged, `/diagnostics` says so: a status of its own, with
    the frame and the stamp from which it holds. The service ``~/swap_head`` (std_srvs/Trigger) does
    it by hand, for the frames that are held back and for the rest of the trial; `source/events`
    says so too, and so the results do.

    A picture that cannot be decoded, or is of another size than the first one, is a frame with the
    status ``bad_image``; `source/events` says why. When as many frames
    have been taken as `flow/end` says, those held back are published and the end is announced.

    Raises
    ------
    BadInput
        Where a parameter is out of range, or no chamber is found (out of the executor).
    """

    PARAMETERS = (
        *declarations(TrackerParameters),
        Declaration(
            "live",
            False,
            "Take the latest picture of a driver that is not ours (best effort), and skip others; "
            "otherwise none may be skipped.",
        ),
        CORRECTIONS,
    )
    STATE = (
        "_tracker",
        "_pictures",
        "_announced",
        "_exchanges_told",
        "_end.taken",
        "_given",
        "_first_ns",
        "_last_ns",
        "_next_report_ns",
        "_ledger.sent",
    )

    def __init__(self, **node_arguments: Any):
        super().__init__(NAME, **node_arguments)
        try:
            parameters = self.read_parameters(TrackerParameters)
        except BaseException:
            self.destroy_node()
            raise
        self._live = bool(self.read_parameter("live"))
        corrections = corrections_from_json(self.read_parameter(CORRECTIONS.name))
        self._tracker = Tracker(parameters, corrections=corrections)
        self._pictures = PictureStream(parameters.max_megapixels)
        self._announced = 0
        self._exchanges_told = 0
        self._given = 0
        self._first_ns = self._last_ns = 0
        self._next_report_ns: int | None = None
        self._end = StreamEnd(self._finish, self._has_all)
        self._ledger = Ledger(self)
        self._out = {
            topic: self._ledger.publisher(kind, topic, qos)
            for topic, (kind, qos) in RESULTS.items()
            if topic in _OUT
        }
        self._camera_info = self.create_publisher(CameraInfo, topics.CAMERA_INFO, RESULT)
        self._flow = self.create_publisher(UInt64MultiArray, topics.FLOW_TRACKED, FLOW)
        self._diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, RESULT)
        qos = IMAGE_LIVE if self._live else IMAGE_REPLAY
        for kind, topic in ((Image, topics.IMAGE), (CompressedImage, topics.IMAGE_COMPRESSED)):
            self.create_subscription(
                kind,
                topic,
                self._on_picture,
                qos,
                in_sequence=not self._live,
                event_callbacks=SubscriptionEventCallbacks(),  # a camera of others may not match
            )
        self.create_subscription(UInt64, topics.FLOW_END, self._end.on_end, FLOW)
        self.create_service(Trigger, "~/swap_head", self._on_swap_head)

    @property
    def done(self) -> bool:
        """Whether every frame was taken and given, and the end was announced."""
        return self._end.done

    @property
    def missing(self) -> str:
        """What is still to come, for people."""
        return self._end.missing

    def _on_picture(self, msg: Any) -> None:
        if self._end.done or not self._pictures.is_mine(msg):
            return
        self._last_ns = convert.stamp_to_ns(msg.header.stamp)
        picture, events = self._pictures.read(
            msg, self._end.taken, self._last_ns, self._tracker.shape
        )
        self._tell_events(events)
        if not self._end.taken:
            self._first_ns = self._last_ns
        self._end.taken += 1
        given = self._tracker.push(picture, self._last_ns)
        self._announce_geometry()
        self._publish(given)
        self._end.finish_if_whole()
        self._report()

    def _tell_what_to_try(self) -> None:
        """Tell on `source/events` what to try where most frames have failed for one reason."""
        advice, kind = self._tracker.advice, SourceEventKind.WHAT_TO_TRY
        if advice:
            self._tell_events([SourceEvent(kind, self._end.taken, self._last_ns, advice)])

    def _tell_events(self, events: list[SourceEvent]) -> None:
        for event in events:
            self._out[topics.SOURCE_EVENTS].publish(
                convert.source_events_to_msg([event], event.stamp_ns)
            )

    def _on_swap_head(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        """Exchange head and tail on an operator's word."""
        exchange = None if self._end.done else self._tracker.swap_head()
        answer.success = exchange is not None
        if exchange is not None:
            answer.message = f"head and tail are exchanged from frame {exchange.frame} on"
            self._tell_exchanges()
            at = datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
            why, kind = answer.message, SourceEventKind.HEAD_SWAPPED
            event = SourceEvent(kind, self._end.taken - 1, self._last_ns, why, at=at)
            self._tell_events([event])
        elif self._end.done:
            answer.message = "the trial has ended"
        else:
            answer.message = "no worm has been seen yet"
        return answer

    def _tell_exchanges(self) -> None:
        """Publish each exchange of head and tail once."""
        for exchange in self._tracker.exchanges[self._exchanges_told :]:
            stamp = header(exchange.stamp_ns, "")
            self._diagnostics.publish(DiagnosticArray(header=stamp, status=[_status(exchange)]))
        self._exchanges_told = len(self._tracker.exchanges)

    def _announce_geometry(self) -> None:
        """Publish a new geometry before the first state that rests on it."""
        geometry: Geometry | None = self._tracker.geometry
        if geometry is None or geometry.version == self._announced:
            return
        self._announced = geometry.version
        if self._tracker.changes:
            why = self._tracker.changes[-1].why
            self.get_logger().warning(f"geometry {geometry.version}: {why}")
        self._out[topics.CHAMBER_GEOMETRY].publish(convert.geometry_to_msg(geometry))
        if geometry.chambers:
            self._out[topics.CHAMBER].publish(convert.geometry_to_markers(geometry))

    def _publish(self, given: list[TrackedFrame]) -> None:
        """Publish what is ready, and how much was taken and given."""
        for tracked in given:
            state = tracked.state
            if tracked.geometry is not None:
                camera = pinhole(tracked.geometry)
                self._camera_info.publish(convert.camera_info_to_cdr(camera, state.stamp_ns))
            self._out[topics.WORM_STATE].publish(convert.body_state_to_msg(state))
            # One for every frame, empty where there is none: a viewer must not keep the last one.
            self._out[topics.WORM_MIDLINE].publish(convert.midline_to_msg(tracked.midline, state))
            if isfinite(state.head.x_m):
                for topic, name in _POSES.items():
                    pose = convert.keypoint_to_pose(state, getattr(state, name))
                    self._out[topic].publish(pose)
        self._tell_exchanges()
        self._given += len(given)
        self._flow.publish(convert.counts_to_msg((self._end.taken, self._given)))

    def _has_all(self) -> bool:
        """Whether no picture is to come; of a driver that is not ours some never do."""
        return self._live or self._end.taken == self._end.frames

    def _finish(self) -> None:
        self._publish(self._tracker.finish())
        self._tell_events(self._pictures.end())
        self._tell_what_to_try()
        self._report(ended=True)
        self._ledger.announce()

    def _report(self, *, ended: bool = False) -> None:
        """Publish the counts on `/diagnostics`, once a second of stamps and at the end."""
        due = self._next_report_ns is None or self._last_ns >= self._next_report_ns
        if not due and not ended:
            return
        self._next_report_ns = self._last_ns + NS_PER_S
        span_s = (self._last_ns - self._first_ns) / NS_PER_S
        rate = f"{(self._end.taken - 1) / span_s:.3f}" if span_s else ""
        values: dict[str, object] = {
            "frames in": self._end.taken,
            "frames out": self._given,
            "frames held back": self._tracker.held,
            "frames per second, by stamps": rate,
            "pictures that repeat the one before": self._tracker.repeated,
            "head and tail exchanged": self._tracker.swaps,
            "geometry version": self._announced,
        }
        for change in self._tracker.changes[-1:]:
            values["geometry changed at, s"] = f"{change.geometry.stamp_ns / NS_PER_S:.3f}"
            values["geometry changed because"] = change.why
        for status, count in sorted(self._tracker.statuses.items()):
            values[f"status {status.label}"] = count
        report = DiagnosticStatus(
            level=DiagnosticStatus.OK,
            name=NAME,
            message="ended" if ended else "running",
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        self._diagnostics.publish(
            DiagnosticArray(header=header(self._last_ns, ""), status=[report])
        )


def _status(exchange: Exchange) -> DiagnosticStatus:
    """Return an exchange of head and tail as a diagnostic status."""
    by = "by an operator" if exchange.kind is ExchangeKind.CORRECTION else "by the tracker"
    values = {
        "kind": exchange.kind.value,
        "frame": exchange.frame,
        "stamp_ns": exchange.stamp_ns,
        "head certainty": f"{exchange.head_certainty:.4f}",
    }
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN,
        name=f"{NAME}: head and tail",
        message=f"exchanged {by} from frame {exchange.frame} on",
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(TrackerNode, args, refusals=(BadInput,))


if __name__ == "__main__":
    sys.exit(main())
