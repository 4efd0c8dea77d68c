"""Node `image_source`: sends the frames of a camera, one each time that the tracker is free."""

import math
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from worm_msgs_py import SourceEvent, SourceEventKind, convert, topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.camera_driver import hear_driver
from worm_msgs_py.ros.qos import IMAGE_REPLAY
from worm_msgs_py.ros.running import stop_on_signals
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bad_messages import BadMessages
from worm_tracker.sources.bags.serialized_images import empty_picture
from worm_tracker.sources.camera_parameters import CAMERA_PARAMETERS
from worm_tracker.sources.cameras.camera import Camera
from worm_tracker.sources.cameras.camera_address import Kind
from worm_tracker.sources.cameras.camera_settings import CameraSettings, Region
from worm_tracker.sources.cameras.live_record import (
    LiveRecord,
    RecordAs,
    RecordForm,
)
from worm_tracker.sources.cameras.outages import Outage
from worm_tracker.sources.cameras.sampled_pictures import SampledPictures
from worm_tracker.sources.cameras.topic_camera import TopicCamera
from worm_tracker.sources.cameras.waiting_frames import LEAST_WAITING, CapturedFrame
from worm_tracker.sources.image_decoder import IMAGE_TYPE
from worm_tracker.sources.source_node import SourceNode, run_source_alone

_LOST_TOLD_EVERY_NS = 10 * NS_PER_S


class CameraNode(SourceNode):
    """Publishes grey pictures (`mono8`) on `image_raw`, stamped at capture.

    The next picture goes out when the tracker has taken the one before. Pictures wait here for up
    to twenty seconds; where the tracker lags for longer the newest one goes out, and what was
    skipped is counted on `/diagnostics` (see `WaitingFrames`). The first one is captured when the
    graph is ready.

    A driver's topic takes the place of a camera: frames bear the driver's stamps, and those that
    were lost on the way are counted by the numbers that DDS gives them.

    Services
    --------
    `~/new_trial` (`std_srvs/Trigger`) ends the stream in good order; `worm live` then begins the
    next trial.

    An outage is told at once in the log and on `/diagnostics`, and on `source/events` when it is
    over. A camera that is lost for good ends the stream, with an event that says so.

    Raises
    ------
    BadInput
        The camera cannot be opened, or the record cannot be written.
    """

    PARAMETERS = CAMERA_PARAMETERS
    endless = True

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(**node_arguments)
        self.window = 1
        self._outage_said = False
        self._shape: tuple[int, ...] | None = None
        self._last_shape: tuple[int, ...] | None = None
        self._last_ns = 0
        self._bad = BadMessages()
        self._lost_told = self._lost_told_ns = 0
        self._region = Region(
            *(self.read_parameter(f"region_{part}_px") for part in ("u", "v", "width", "height"))
        )
        self._publisher = self.create_publisher(Image, topics.IMAGE, IMAGE_REPLAY)
        self._opened = ExitStack()
        try:
            self._camera = self._open_camera()
            self._record = self._open_record()
            self._sampled = self._sample()
        except BaseException:
            self.destroy_node()
            raise
        if self._camera.kind is Kind.FILE:
            self.get_logger().info(
                f"{self._camera.shown_address}: frames are stamped with the container's own times "
                f"({self._camera.fps:g} frames/s on average), which need not be those of filming"
            )
        self.create_service(Trigger, "~/new_trial", self._on_new_trial)
        self._camera.start()

    def _on_new_trial(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        if not self.sent or self.done or self.next_is_asked:
            answer.message = "the trial is ending" if self.sent else "no frame has come yet"
            return answer
        self.next_is_asked = answer.success = True
        self.end_now()
        answer.message = f"the trial ends with frame {self.sent - 1}, and the next one begins"
        return answer

    def _open_camera(self) -> Camera | TopicCamera:
        parameter = self.read_parameter
        if bool(parameter("camera")) == bool(parameter("topic")):
            raise BadInput("set one of the parameters `camera` and `topic`")
        if bool(self._region.width_px) != bool(self._region.height_px):
            raise BadInput("set both of `region_width_px` and `region_height_px`, or none")
        if parameter("topic"):
            return self._open_topic(self.resolve_topic_name(parameter("topic")))
        wake = self.create_guard_condition(lambda: None)
        with stop_on_signals() as stop:
            camera = Camera(
                parameter("camera"),
                reconnect_s=parameter("reconnect"),
                reconnect_delay_s=parameter("reconnect_delay"),
                stall_s=parameter("stall"),
                on_change=wake.trigger,
                capture=self.capture_instead(),
                keep_on=lambda: not stop.is_set(),
                settings=CameraSettings(
                    parameter("width_px"),
                    parameter("height_px"),
                    parameter("frames_per_s"),
                    parameter("exposure_ms"),
                ),
            )
        self._opened.callback(camera.stop)
        return camera

    def _open_topic(self, topic: str) -> TopicCamera:
        parameter = self.read_parameter
        patience = parameter("reconnect"), parameter("stall")
        camera = TopicCamera(topic, *patience, parameter("max_megapixels"))
        hear_driver(self, topic, camera.take_message, LEAST_WAITING)
        self._opened.callback(camera.stop)
        return camera

    def capture_instead(self) -> Callable[[], Any] | None:
        """Return what opens something that films in place of OpenCV's captures; None: nothing."""
        return None

    def _open_record(self) -> LiveRecord | None:
        parameter = self.read_parameter
        if not parameter("record"):
            return None
        form = RecordForm(
            RecordAs(parameter("record_as")),
            parameter("jpeg_quality"),
            parameter("split_mib"),
            parameter("split_min"),
        )
        record = LiveRecord(Path(parameter("record")), self._publisher.topic_name, form)
        self._opened.callback(record.close)
        return record

    def _sample(self) -> SampledPictures | None:
        directory = self.read_parameter("pictures")
        if not directory:
            return None
        sampled = SampledPictures(Path(directory))
        self._opened.callback(sampled.close)
        return sampled

    @property
    def last_stamp_ns(self) -> int:
        """Stamp of the last frame that was sent."""
        return self._last_ns

    @property
    def is_watched(self) -> bool:
        """Whether somebody subscribes to the pictures."""
        return bool(self._publisher.get_subscription_count() > 0)

    @property
    def window_is_open(self) -> bool:
        """Whether the tracker has taken what was sent; how far the recorder is does not matter."""
        return self.taken_by_tracker

    def begin(self) -> None:
        """Begin to film: all other nodes are ready."""
        self._tell_not_accepted(time.time_ns())
        self._camera.begin()

    def _tell_not_accepted(self, stamp_ns: int) -> None:
        """Tell once what the camera was asked for and did not take."""
        while self._camera.not_accepted:
            why = self._camera.not_accepted.pop(0)
            self.get_logger().warning(f"{self._camera.shown_address}: {why}")
            self._tell(SourceEvent(SourceEventKind.NOT_ACCEPTED, self.sent, stamp_ns, why))

    def why_no_change(self, parameter: Parameter) -> str:
        """Return why the exposure cannot be changed; empty where it can."""
        if self._camera.kind is not Kind.DEVICE:
            return f"the exposure of a {self._camera.kind.value} cannot be set from here"
        if not parameter.value:
            return "exposure_ms is 0: give a time: by itself a camera exposes from its start alone"
        return super().why_no_change(parameter)

    def take_change(self, name: str, before: Any, value: Any) -> None:
        """Ask for another exposure, which frames have within a few of this one."""
        super().take_change(name, before, value)
        if isinstance(self._camera, Camera):
            self._camera.expose(value)

    def wait_s(self) -> float:
        """Return 0 where there is a picture, or the end, to send; infinity otherwise."""
        self._say_outage(self._camera.outage)
        return 0.0 if self.picture_waits or self._camera.ended else math.inf

    @property
    def picture_waits(self) -> bool:
        """Whether a picture is there that was not sent."""
        return bool(self._camera.waiting)

    def publish_next(self) -> bool:
        """Publish the next picture; at the end say so and return False."""
        ended = self._camera.ended  # asked first: a last frame may come between
        frame = self._take()
        for outage in self._camera.take_outages():
            self._tell_outage(outage)
        self._tell_lost(ended and frame is None)
        if frame is None:
            if ended:
                self._end()
            return not ended
        self._tell_not_accepted(frame.stamp_ns)
        raw = self._message(frame)
        if self._record is not None:
            self._record.write(frame, raw)
            self._say_of_record(frame.stamp_ns)
        if self._sampled is not None:
            self._sampled.take(self.sent, frame.picture)
        self.sent += 1
        self._last_ns = frame.stamp_ns
        self._publisher.publish(raw)
        return True

    def _take(self) -> CapturedFrame | None:
        """Return the part that is used of the oldest frame that waits; None where there is none."""
        captured = self._camera.take()
        if captured is None:
            return None
        frame = self._region.of(captured)
        if frame.why_bad and not captured.why_bad and not self.sent:
            raise BadInput(f"{frame.why_bad}: choose another one (--region-px)")
        return frame

    def _message(self, frame: CapturedFrame) -> bytes:
        """Return a frame as a serialised Image, an empty one where it is bad; tell which are."""
        if frame.why_bad:
            events = self._bad.bad(self.sent, frame.stamp_ns, frame.why_bad)
        else:
            events = self._bad.good()
            self._look_at_size(frame)
        for event in events:
            self._tell(event)
        if frame.why_bad:
            return empty_picture(frame.stamp_ns, IMAGE_TYPE)
        return bytes(serialize_message(convert.picture_to_msg(frame.picture, frame.stamp_ns)))

    def end_now(self) -> None:
        """End the stream in good order: what was sent is a whole, if shorter, recording."""
        outage = self._camera.outage
        self._camera.stop()
        if outage is not None and self.sent:
            self._tell_outage(outage, "the trial was ended before it came back")

    def counts(self) -> dict[str, str]:
        """Return what `/diagnostics` shows of this source."""
        counts = asdict(self._camera.counts)
        age_s = counts.pop("age_s")
        shown = {f"frames {name}": str(value) for name, value in counts.items()}
        shown["reconnections"] = shown.pop("frames reconnections")
        if self._record is not None:
            shown |= self._record.counts()
        return {**super().counts(), **shown, "age of last frame (s)": f"{age_s:.3f}"}

    def complaint(self) -> str:
        """Return what is wrong with the camera or its record, empty where nothing is."""
        outage = None if self._camera.ended else self._camera.outage
        if outage is not None:
            return self._lost_line(outage)
        return self._record.complaint if self._record is not None else ""

    def _lost_line(self, outage: Outage) -> str:
        return (
            f"no frame has come from {self._camera.shown_address} for {outage.duration_s:.1f} s; "
            f"it is looked for until {self._camera.reconnect_s:g} s have passed"
        )

    def _say_outage(self, outage: Outage | None) -> None:
        """Say in the log that the camera is lost, once."""
        if outage is not None and not self._outage_said and not self._camera.ended:
            self._outage_said = True
            self.get_logger().warning(self._lost_line(outage))
            self.report(at_once=True)

    def _tell_outage(self, outage: Outage, end: str = "it came back") -> None:
        """Tell of an outage that is over."""
        why = f"no frame from {self._camera.shown_address} for {outage.duration_s:.1f} s; {end}"
        event = SourceEvent(
            SourceEventKind.OUTAGE,
            self.sent,
            outage.since_ns,
            why,
            outage.duration_s,
            outage.reconnections,
        )
        self._outage_said = False
        self.get_logger().warning(f"{why} ({outage.reconnections} attempts to reconnect)")
        self._tell(event)

    def _tell_lost(self, at_the_end: bool) -> None:
        """Tell of frames that never came; those of ten seconds are one event."""
        lost = self._camera.counts.lost - self._lost_told
        due = at_the_end or self._last_ns >= self._lost_told_ns + _LOST_TOLD_EVERY_NS
        if lost and due:
            why = f"{lost} pictures of {self._camera.shown_address} never came"
            self._lost_told += lost
            self._lost_told_ns = self._last_ns
            self.get_logger().warning(why)
            kind = SourceEventKind.LOST_ON_THE_WAY
            self._tell(SourceEvent(kind, self.sent, self._last_ns, why, count=lost))

    def _look_at_size(self, frame: CapturedFrame) -> None:
        """Tell where the camera sends pictures of another size: the tracker cannot use them."""
        shape = frame.picture.shape
        self._shape = self._shape or shape
        if shape not in (self._shape, self._last_shape):
            why = (
                f"from frame {self.sent} on pictures are of {shape[1]} × {shape[0]} pixels; a "
                f"trial has one size, {self._shape[1]} × {self._shape[0]}: the others are bad_image"
            )
            self.get_logger().warning(why)
            self._tell(
                SourceEvent(SourceEventKind.BAD_MESSAGE, self.sent, frame.stamp_ns, why, count=1)
            )
        self._last_shape = shape

    def _say_of_record(self, stamp_ns: int) -> None:
        """Say what the record has to say: a disk that runs full, or its end."""
        assert self._record is not None
        for line in self._record.take_warnings():
            self.get_logger().warning(line)
        stopped, count = self._record.take_stopped(), self._record.count
        if stopped:
            kind = SourceEventKind.RECORD_STOPPED
            self._tell(SourceEvent(kind, self.sent, stamp_ns, stopped, count=count))

    def _end(self) -> None:
        why = self._camera.why_lost
        if self.sent == 0:
            why = f"no frame has come from {self._camera.shown_address}"
        elif why:
            self.get_logger().error(f"the camera is lost: {why}")
        if why and not self._ended:
            self._tell(SourceEvent(SourceEventKind.ENDED_EARLY, self.sent, self._last_ns, why))
        for event in self._bad.end():
            self._tell(event)
        if self._record is not None:
            self._record.close()
            self._say_of_record(self._last_ns)
        self._announce_end()

    def destroy_node(self) -> None:
        """Let go of the camera and close the record."""
        self._opened.close()
        super().destroy_node()


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_source_alone(CameraNode, args)


if __name__ == "__main__":
    sys.exit(main())
