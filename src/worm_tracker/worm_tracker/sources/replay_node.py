"""Node `image_source`: plays a bag's pictures, every one, as fast as the graph can take them."""

import math
import sys
import time
from pathlib import Path
from typing import Any

from rclpy.parameter import Parameter
from sensor_msgs.msg import CompressedImage, Image
from std_srvs.srv import Trigger

from worm_msgs_py import topics
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_msgs_py.ros.qos import IMAGE_REPLAY
from worm_tracker.sources.bags.bad_messages import BadMessages
from worm_tracker.sources.bags.bag_cursor import BagCursor
from worm_tracker.sources.bags.bag_reader import BagPicture, BagPictures
from worm_tracker.sources.bags.scan.decompression import CHUNK_MIB, MAX_CHUNK_MIB
from worm_tracker.sources.image_decoder import IMAGE_TYPE, MAX_MEGAPIXELS, MEGAPIXELS
from worm_tracker.sources.playback import (
    NO_SEEK,
    PLAYBACK,
    RATE,
    SEEK,
    START_OFFSET,
    Playback,
    in_a_loop,
)
from worm_tracker.sources.source_node import SourceNode, run_source_alone


class ReplayNode(SourceNode):
    """Plays the pictures of a bag on `image_raw`, or `image_raw/compressed`, byte for byte.

    The words are those of the rosbag2 player.

    Services
    --------
    `~/pause`, `~/resume`, `~/toggle_paused`, `~/is_paused` (its `success` is the answer),
    `~/play_next`. They are named as rosbag2's, and are `std_srvs/Trigger`: `rosbag2_interfaces`
    has no wheel. What are its `~/set_rate` and `~/seek` are here the parameters `rate` and
    `seek_to`, which may change while the recording plays. A seek leaves no picture out, as results
    rest on all before them: it plays as fast as the graph can take it, and pauses there. A part of
    a recording is chosen by `start_offset` and `playback_duration`.

    Raises
    ------
    BadInput
        As `BagPictures`, before anything is published.
    """

    PARAMETERS = (
        Declaration("bag", "", "A rosbag2 directory, an .mcap file or a .db3 file."),
        Declaration("topic", "", "The bag's topic of pictures; empty: the only one."),
        Declaration(
            "rate",
            0.0,
            "1.0 is real time, 0.0 as fast as the graph can take it.",
            RATE,
            changes=True,
        ),
        Declaration(
            "seek_to",
            NO_SEEK,
            "Play as fast as the graph can take it to this time after the first picture, and pause "
            "there; no picture is left out. Later than what has been played.",
            SEEK,
            or_else=NO_SEEK,
            means="play at `rate`",
            changes=True,
        ),
        Declaration("loop", False, "Begin again at the end, until a signal; stamps go on growing."),
        Declaration("start_offset", 0.0, "Time of the recording to leave out.", START_OFFSET),
        Declaration(
            "playback_duration",
            -1.0,
            "Time of the recording to play.",
            PLAYBACK,
            or_else=-1.0,
            means="to the end",
        ),
        Declaration("start_paused", False, "Wait for ~/resume or ~/play_next."),
        Declaration(
            "salvage",
            False,
            "Go over what is damaged in the bag and say what was lost, instead of refusing it.",
        ),
        Declaration(
            "max_chunk_mib",
            MAX_CHUNK_MIB,
            "Largest piece of the bag, decompressed, that is read.",
            CHUNK_MIB,
        ),
        Declaration("max_megapixels", MAX_MEGAPIXELS, "Larger pictures are bad ones.", MEGAPIXELS),
        Declaration(
            "window",
            8,
            "Frames in flight between processes; 0: wait for nobody (a graph without a tracker).",
            Limit(0, 1000, "frames"),
        ),
    )
    STATE = (*SourceNode.STATE, "_bad", "_cursor.last_ns", "_cursor.losses_told")

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(**node_arguments)
        self._bad = BadMessages()
        try:
            self._playback = Playback(
                self.read_parameter("rate"), paused=self.read_parameter("start_paused")
            )
            self._seek(self.read_parameter("seek_to"))
            self.endless = self.read_parameter("loop")
            self.window = self.read_parameter("window")
            self._bag = bag = self._open_bag()
            self._cursor = BagCursor(in_a_loop(bag) if self.endless else bag, bag.losses)
            self._create_services()
        except BaseException:
            self.destroy_node()
            raise
        self.expected = None if self.endless else bag.expected
        kind, out = (
            (Image, topics.IMAGE)
            if bag.message_type == IMAGE_TYPE
            else (CompressedImage, topics.IMAGE_COMPRESSED)
        )
        self._publisher = self.create_publisher(kind, out, IMAGE_REPLAY)

    def _open_bag(self) -> BagPictures:
        parameter = self.read_parameter
        if not parameter("bag"):
            raise BadInput("no bag was given; set the parameter `bag`")
        duration_s = parameter("playback_duration")
        return BagPictures(
            Path(parameter("bag")),
            parameter("topic") or None,
            start_offset_s=parameter("start_offset"),
            playback_duration_s=duration_s if duration_s >= 0.0 else None,
            salvage=parameter("salvage"),
            max_chunk_mib=parameter("max_chunk_mib"),
            max_megapixels=parameter("max_megapixels"),
        )

    @property
    def last_stamp_ns(self) -> int:
        """Stamp of the last frame that was sent."""
        return self._cursor.last_ns

    @property
    def is_watched(self) -> bool:
        """Whether somebody subscribes to the pictures."""
        return bool(self._publisher.get_subscription_count() > 0)

    def wait_s(self) -> float:
        """Return the seconds until the next picture, or the end, is due (`SourceNode.wait_s`)."""
        if self._cursor.picture is None:
            return math.inf if self.paused else 0.0
        return self._playback.wait_s(self._cursor.picture.stamp_ns, time.monotonic())

    def publish_next(self) -> bool:
        """Publish the next picture whether due or not; at the end say so and return False."""
        picture = self._cursor.picture
        for event in self._cursor.take_losses(self.sent):
            self._tell(event)
        if picture is None:
            for event in self._bad.end():
                self._tell(event)
            self._announce_end()
            return False
        self._tell_whether_bad(picture)
        self.sent += 1
        self._publisher.publish(picture.raw)
        self._playback.played(picture.stamp_ns, time.monotonic())
        self._cursor.advance()
        if self._cursor.picture is None and self._playback.seeks:
            self._playback.stop_seeking(time.monotonic())
        return True

    def restore(self, state: dict[str, Any]) -> None:
        """Go on with the picture after those that were sent."""
        super().restore(state)
        self._cursor.go_on_after(self.sent)

    def _tell_whether_bad(self, picture: BagPicture) -> None:
        """Tell which messages cannot be read."""
        if picture.why_bad:
            events = self._bad.bad(self.sent, picture.stamp_ns, picture.why_bad)
        else:
            events = self._bad.good()
        for event in events:
            self._tell(event)

    def counts(self) -> dict[str, str]:
        """Return what `/diagnostics` shows: how long there is to play, for one."""
        return {**super().counts(), "to play (s)": f"{self._bag.playback_s:.3f}"}

    def end_now(self) -> None:
        """End a loop where it is."""
        self._cursor.end()

    def take_change(self, name: str, before: Any, value: Any) -> None:
        """Play at another rate from here on, or to another place; a seek changes no result."""
        if name == "seek_to":
            self._seek(value)
            return
        super().take_change(name, before, value)
        self._playback.set_rate(value, time.monotonic())

    def why_no_change(self, parameter: Parameter) -> str:
        """Return that a picture has been played, where it is sought: results go forward alone."""
        played_s = self._playback.played_s
        back = parameter.name == "seek_to" and NO_SEEK < parameter.value <= (played_s or -1.0)
        if back:
            return f"{played_s:.3f} s have been played: seek_to goes forward, as results do"
        return super().why_no_change(parameter)

    def _seek(self, position_s: float) -> None:
        if position_s != NO_SEEK:
            self._playback.seek(position_s)
        else:
            self._playback.stop_seeking(time.monotonic())

    def pause(self) -> None:
        """Stop playing."""
        self._playback.pause(time.monotonic())

    def resume(self) -> None:
        """Go on playing."""
        self._playback.resume(time.monotonic())

    @property
    def paused(self) -> bool:
        """Whether the player waits for `resume` or `play_next`."""
        return self._playback.paused

    def play_next(self) -> bool:
        """Let one picture through while paused; return whether there was one to let through."""
        return self._cursor.picture is not None and self._playback.play_next()

    def destroy_node(self) -> None:
        """Close the bag."""
        if hasattr(self, "_bag"):
            self._bag.close()
        super().destroy_node()

    def _create_services(self) -> None:
        def serve(name: str, answer: Any) -> None:
            def on_request(request: Trigger.Request, response: Trigger.Response) -> Any:
                response.success, response.message = answer()
                return response

            self.create_service(Trigger, f"~/{name}", on_request)

        def state() -> str:
            going = "seeking" if self._playback.seeks else "playing"
            return "paused" if self.paused else going

        def pause() -> tuple[bool, str]:
            self.pause()
            return True, state()

        def resume() -> tuple[bool, str]:
            self.resume()
            return True, state()

        def play_next() -> tuple[bool, str]:
            let_through = self.play_next()
            return let_through, "played" if let_through else f"nothing to step: {state()}"

        serve("pause", pause)
        serve("resume", resume)
        serve("toggle_paused", lambda: resume() if self.paused else pause())
        serve("is_paused", lambda: (self.paused, state()))
        serve("play_next", play_next)


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_source_alone(ReplayNode, args)


if __name__ == "__main__":
    sys.exit(main())
