"""Node `image_source`: sends the latest frame of a camera each time the tracker is free for it."""

import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

from worm_msgs_py import convert, topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_msgs_py.qos import IMAGE_REPLAY
from worm_tracker.camera import Camera, Kind
from worm_tracker.picture_recorder import PictureRecorder
from worm_tracker.pictures import IMAGE_TYPE
from worm_tracker.source_node import SourceNode, run_alone

RECONNECTIONS = Limit(0, 1_000_000)
SECONDS = Limit(1e-3, 3600.0, "s")


class CameraNode(SourceNode):
    """Publishes grey pictures (`mono8`) on `image_raw`, stamped at capture.

    The tracker never queues: the next picture goes out when it has taken the one before, and it is
    the newest one. What was captured in between is skipped, and counted on `/diagnostics`.

    Parameters (read once)
    ----------------------
    camera : str
        A V4L2 device, an HTTP (MJPEG) or RTSP address, or a video file (see `Camera`).
    record : str
        Directory into which every picture that is sent is recorded; empty: none. Its replay gives
        the same frames with the same stamps, and so the same results.
    reconnections : int
        How many times in a row a stream that has stopped is opened anew.
    reconnect_delay, stall : float
        Seconds before each of them, and without a frame until a stream has stopped.

    Raises
    ------
    BadInput
        The camera cannot be opened, or the record cannot be written.
    """

    endless = True

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(**node_arguments)
        self._camera: Camera | None = None
        self._recorder: PictureRecorder | None = None
        try:
            self._declare()
        except BaseException:
            self.destroy_node()
            raise

    def _declare(self) -> None:
        parameter = self.read_parameter
        address = parameter("camera", Parameter.Type.STRING, "device, address or video file")
        record = parameter("record", "", "directory for what is sent; empty: none")
        reconnections = parameter("reconnections", 5, "attempts in a row", RECONNECTIONS)
        delay_s = parameter("reconnect_delay", 1.0, "seconds before each attempt", SECONDS)
        self._stall_s = parameter(
            "stall", 5.0, "seconds without a frame: the stream has stopped", SECONDS
        )
        if not address:
            raise BadInput("no camera was given; set the parameter `camera`")
        self.window = 1
        self._publisher = self.create_publisher(Image, topics.IMAGE, IMAGE_REPLAY)
        wake = self.create_guard_condition(lambda: None)
        camera = self._camera = Camera(
            address,
            reconnections=reconnections,
            reconnect_delay_s=delay_s,
            stall_s=self._stall_s,
            on_change=wake.trigger,
        )
        if record:
            self._recorder = PictureRecorder(Path(record), self._publisher.topic_name, IMAGE_TYPE)
        if camera.kind is Kind.FILE:
            self.get_logger().info(
                f"{address}: played at the container's {camera.fps:g} frames/s, "
                "which need not be the rate at which it was filmed"
            )
        camera.start()

    @property
    def is_watched(self) -> bool:
        """Whether somebody subscribes to the pictures."""
        return bool(self._publisher.get_subscription_count() > 0)

    @property
    def window_is_open(self) -> bool:
        """Whether the tracker has taken what was sent; how far the recorder is does not matter."""
        return self.taken_by_tracker

    def wait_s(self) -> float:
        """Return 0 where there is a picture, or the end, to send; infinity otherwise."""
        assert self._camera is not None
        return 0.0 if self._camera.waiting or self._camera.ended else math.inf

    def publish_next(self) -> bool:
        """Publish the newest picture; at the end say so and return False."""
        assert self._camera is not None
        ended = self._camera.ended  # asked first: a last frame may come between
        frame = self._camera.take()
        if frame is None:
            if ended:
                self._close_record()
                self._announce_end()
            return not ended
        raw = serialize_message(convert.picture_to_msg(frame.picture, frame.stamp_ns))
        if self._recorder is not None:
            self._recorder.write(frame.stamp_ns, raw)
        self.sent += 1
        self._publisher.publish(raw)
        return True

    def end_now(self) -> None:
        """End the stream in good order: what was sent is a whole, if shorter, recording."""
        assert self._camera is not None
        self._camera.stop()

    def counts(self) -> dict[str, str]:
        """Return what `/diagnostics` shows of this source."""
        assert self._camera is not None
        counts = asdict(self._camera.counts)
        age_s = counts.pop("age_s")
        shown = {f"frames {name}": str(value) for name, value in counts.items()}
        shown["reconnections"] = shown.pop("frames reconnections")
        return {**super().counts(), **shown, "age of last frame (s)": f"{age_s:.3f}"}

    def complaint(self) -> str:
        """Return what is wrong with the camera, empty where nothing is."""
        assert self._camera is not None
        if self._camera.ended or self._camera.counts.age_s <= self._stall_s:
            return ""
        if self._camera.counts.captured == 0:
            return f"no frame has come from {self._camera.shown_address} yet"
        return f"no frame has come from {self._camera.shown_address} for {self._stall_s:g} s"

    def _close_record(self) -> None:
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            recorder.close()

    def destroy_node(self) -> None:
        """Let go of the camera and close the record."""
        if self._camera is not None:
            self._camera.stop()
        self._close_record()
        super().destroy_node()


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(CameraNode, args)


if __name__ == "__main__":
    sys.exit(main())
