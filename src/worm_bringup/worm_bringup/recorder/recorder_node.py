"""Node `recorder`: takes every result topic and writes the tables, the summary and a bag."""

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from std_msgs.msg import UInt64

from worm_bringup.freed_memory import give_back_freed_memory
from worm_bringup.overlay.frame_join import FrameJoin, JoinedFrame
from worm_bringup.overlay.views import FrameViews
from worm_bringup.recorder.copied_pictures import CopiedPictures
from worm_bringup.recorder.metadata import TrialMetadata
from worm_bringup.recorder.recording import Recording
from worm_bringup.recorder.result_bag import ResultBag
from worm_msgs_py import SourceEvent, SourceEventKind, convert, topics
from worm_msgs_py.contract.source_events import parameter_changed
from worm_msgs_py.declarations import Declaration, declarations
from worm_msgs_py.errors import BadInput, MalformedMessage
from worm_msgs_py.files.corrections import CORRECTIONS, corrections_from_json, requested
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW
from worm_msgs_py.ros.running import run_alone
from worm_msgs_py.ros.stream_end import StreamEnd
from worm_msgs_py.ros.worm_node import WormNode

_TRIM_EVERY_FRAMES = 128
"""How often freed memory is given back: it takes 1 to 4 ms of the second or more in between."""

Journal = list[tuple[str, bytes]]
"""Messages in the order in which they came: the topic, and the message serialised."""


@contextmanager
def _full_disk_in_a_line() -> Iterator[None]:
    """Let a full disk be one line, also from a process of its own."""
    try:
        yield
    except OSError as error:
        why = error.strerror or " ".join(str(error).split())
        raise BadInput(
            f"the results cannot be written ({why}): make room, or choose another --out"
        ) from error


def _no_empty_directory(out: str) -> str:
    """Return what is wrong with a directory to write into."""
    if out and Path(out).is_dir() and not any(Path(out).iterdir()):
        return ""
    return f"is {out or 'no directory'}: give an existing, empty directory"


def _no_json_object(text: str) -> str:
    """Return what is wrong with the provenance."""
    try:
        wrong = not isinstance(json.loads(text), dict)
    except ValueError:
        wrong = True
    return f"is {text!r}: give a JSON object" if wrong else ""


class RecorderNode(WormNode):
    """Writes the results of one trial into a directory.

    Its state is what it was sent: `journal` is a list where the messages are to be kept that have
    come since it was last emptied, and `take_again` takes them anew, to the same files.

    Raises
    ------
    BadInput
        `out` is not an existing, empty directory, or the pictures' bag cannot be read.
    """

    PARAMETERS = (
        Declaration("out", "", "An existing, empty directory.", check=_no_empty_directory),
        Declaration(
            "expect",
            ["image_source", "tracker", "analysis", "model"],
            "Nodes whose announcement of their end is waited for.",
        ),
        Declaration(
            "provenance",
            "{}",
            "JSON object that goes into the summary as it is.",
            check=_no_json_object,
        ),
        Declaration(
            "pictures",
            "{}",
            "JSON object: parameters of the player whose pictures are copied into the bag; empty: "
            "none.",
            check=_no_json_object,
        ),
        CORRECTIONS,
        *declarations(TrialMetadata),
    )

    def __init__(self, **node_arguments: Any):
        super().__init__("recorder", **node_arguments)
        out = Path(self.read_parameter("out"))
        if not self.read_parameter("out"):
            raise BadInput(f"node recorder: out {_no_empty_directory('')}")
        announcers = self.read_parameter("expect")
        self._provenance = json.loads(self.read_parameter("provenance"))
        player = json.loads(self.read_parameter("pictures"))
        self._pictures = CopiedPictures(player) if player else None
        self._bag_dropped = False
        with _full_disk_in_a_line():
            self._recording = Recording(out)
            corrections = corrections_from_json(self.read_parameter(CORRECTIONS.name))
            self._recording.trial.corrections.extend(corrections)
            self._bag = ResultBag(out / "bag", self._pictures)
        self._join, self._views = FrameJoin(), FrameViews()
        self._stamp_ns = 0
        self._received: Counter[str] = Counter()
        self._end = StreamEnd(self._finish, self._has_all, announcers)
        self.journal: Journal | None = None
        for topic, (kind, qos) in RESULTS.items():
            alone = topic != topics.SOURCE_EVENTS  # which the tracker has a part in
            take = partial(self._take, topic, kind)
            self.create_subscription(kind, topic, take, qos, in_sequence=alone, raw=True)
        self.create_subscription(UInt64, topics.FLOW_END, self._end.on_end, FLOW)
        self.create_subscription(
            DiagnosticStatus, topics.FLOW_FINISHED, self._end.on_announcement, FLOW
        )
        self._progress = self.create_publisher(UInt64, topics.FLOW_RECORDED, FLOW)
        self._readers = self._make_readers()

    def why_no_change(self, parameter: Parameter) -> str:
        """Return why what is noted of the trial cannot be changed now; empty where it can."""
        if self._end.done:
            return "the trial has ended"
        if self.journal is not None:  # of messages alone: a run that goes on would not have it
            return "a replay that can be stopped has its notes from the start: give a rig file"
        return ""

    def take_change(self, name: str, before: Any, value: Any) -> None:
        """Tell of a changed note in the summary, which has the last one."""
        event = parameter_changed(
            self.get_name(), name, before, value, self._recording.rows, self._stamp_ns
        )
        self._recording.trial.source_events.append(event)

    @property
    def done(self) -> bool:
        """Whether every message that was announced has come and the files are written."""
        return self._end.done

    @property
    def missing(self) -> str:
        """What is still to come, for people."""
        parts = []
        if self._end.frames is None:
            parts.append("the source has not ended")
        elif self._recording.rows != self._end.frames:
            parts.append(f"{self._recording.rows} of {self._end.frames} frames are recorded")
        parts += [f"{name} has not finished" for name in self._end.silent]
        parts += [
            f"{self._senders(topic)} sent {count} on {topic}, {self._received[topic]} came"
            for topic, count in self._sent().items()
            if self._received[topic] < count
        ]
        return "; ".join(parts)

    def _sent(self) -> Counter[str]:
        """Return how many messages were announced on each topic."""
        sent: Counter[str] = Counter()  # two nodes may tell of the source on one topic
        for said in self._end.announced.values():
            sent.update(said.sent)
        return sent

    def _senders(self, topic: str) -> str:
        announced = self._end.announced.items()
        return " and ".join(name for name, said in announced if topic in said.sent)

    def destroy_node(self) -> None:
        """Close the files, whole or not: without a summary nobody takes them for whole."""
        if not self._end.done:
            with suppress(OSError):  # the disk that was full is still full
                self._recording.close()
            with suppress(OSError):
                self._bag.close()
        if self._pictures is not None:
            self._pictures.close()
        super().destroy_node()

    def take_again(self, journal: Journal) -> None:
        """Take messages of an earlier run, in their order, before those of this one."""
        for topic, data in journal:
            self._take(topic, RESULTS[topic][0], data)

    def _make_readers(self) -> dict[str, Callable[[Any], None]]:
        recording, trial = self._recording, self._recording.trial

        def keep(name: str, read: Callable[[Any], Any]) -> Callable[[Any], None]:
            return lambda msg: setattr(trial, name, read(msg))

        return {
            topics.WORM_STATE: self._on_state,
            topics.WORM_MIDLINE: self._on_midline,
            topics.ANALYSIS_STATE: self._on_observables,
            topics.ANALYSIS_EVENTS: lambda msg: recording.add_events(convert.events_from_msg(msg)),
            topics.CHAMBER_GEOMETRY: self._on_geometry,
            topics.ANALYSIS_SUMMARY: keep("quantities", convert.quantities_from_msg),
            topics.ANALYSIS_SUMS: lambda msg: trial.sums.update([convert.sums_from_msg(msg)]),
            topics.ANALYSIS_CORRELATION: keep("correlation", convert.correlation_from_msg),
            topics.MODEL_COMPARISON: keep("comparison", convert.comparison_from_msg),
            topics.MODEL_CORRELATION: keep("model_correlation", convert.correlation_from_msg),
            topics.SOURCE_EVENTS: self._on_source_events,
        }

    def _take(self, topic: str, kind: type, data: bytes) -> None:
        with _full_disk_in_a_line():
            self._write(topic, kind, data)

    def _write(self, topic: str, kind: type, data: bytes) -> None:
        before = self._recording.rows
        reader = self._readers.get(topic)
        if reader is not None:
            reader(_deserialised(data, kind))
        self._received[topic] += 1
        if self._recording.rows != before:
            self._end.taken = self._recording.rows
            self._progress.publish(convert.count_to_msg(self._end.taken))
            if self._recording.rows % _TRIM_EVERY_FRAMES == 0:  # a message ends one row at most
                give_back_freed_memory()
        self._into_bag(topic, self._stamp_ns, data)
        if reader is not None and self._recording.waiting:
            self._make_room(self._recording.commit)
        if self.journal is not None:
            self.journal.append((topic, data))
        self._end.finish_if_whole()

    def _on_state(self, msg: Any) -> None:
        state = convert.body_state_from_msg(msg)
        self._check_turn(topics.WORM_STATE, state.frame)
        self._stamp_ns = state.stamp_ns
        self._recording.add_state(state)
        self._lay_over(self._join.add_state(state))

    def _on_midline(self, msg: Any) -> None:
        midline = convert.midline_from_msg(msg)
        self._recording.add_midline(midline)
        self._lay_over(self._join.add_midline(midline))

    def _on_geometry(self, msg: Any) -> None:
        geometry = convert.geometry_from_msg(msg)
        self._recording.trial.take_geometry(geometry)
        self._lay_over(self._join.add_geometry(geometry))

    def _on_source_events(self, msg: Any) -> None:
        events = convert.source_events_from_msg(msg)
        trial = self._recording.trial
        asked = [event for event in events if event.kind is SourceEventKind.HEAD_SWAPPED]
        try:
            trial.corrections.extend([requested(event) for event in asked])
        except BadInput as error:
            raise MalformedMessage(f"the correction {error}") from None
        trial.source_events.extend(event for event in events if event not in asked)

    def _lay_over(self, frames: Iterator[JoinedFrame]) -> None:
        """Put frames that are whole into the bag: their picture, and what is laid over it."""
        for frame in frames:
            stamp_ns = frame.state.stamp_ns
            if self._pictures is not None:
                picture = self._pictures.next_picture(stamp_ns)
                self._into_bag(self._pictures.topic, stamp_ns, picture)
            for topic, data in self._views.of(frame):
                self._into_bag(topic, stamp_ns, data)

    def _into_bag(self, topic: str, stamp_ns: int, data: bytes) -> None:
        try:
            self._bag.write(topic, stamp_ns, data)
        except OSError as error:
            self._drop_bag(error)

    def _on_observables(self, msg: Any) -> None:
        observables = convert.observables_from_msg(msg)
        self._check_turn(topics.ANALYSIS_STATE, observables.frame)
        self._recording.add_observables(observables)

    def _check_turn(self, topic: str, frame: int) -> None:
        if frame != self._received[topic]:
            due = self._received[topic]
            raise MalformedMessage(f"frame {frame} comes where frame {due} is due")

    def _has_all(self) -> bool:
        return self._end.frames is not None and not self.missing

    @_full_disk_in_a_line()
    def _finish(self) -> None:
        assert self._end.frames is not None
        self._recording.trial.frames_read = self._end.frames
        self._recording.trial.ignored_messages = self._all_ignored()
        self._lay_over(self._join.finish())
        try:
            self._bag.close()
        except OSError as error:
            self._drop_bag(error)
        if self._end.frames:  # a trial without one frame has no results
            noted = self.read_parameters(TrialMetadata).given()
            provenance = self._provenance | ({"trial": noted} if noted else {})
            finish = partial(self._recording.finish, provenance)
            self._make_room(finish)  # last: where the summary is, all is

    def _all_ignored(self) -> dict[str, int]:
        """Return the messages that were ignored by topic; several nodes may have seen the same."""
        # More than was announced is not ours, whichever of them it is.
        surplus = Counter(self._received)
        surplus.subtract(self._sent())
        ignored_here = self.ignored + surplus  # adding leaves out what is not above zero
        counts = [*(said.ignored for said in self._end.announced.values()), ignored_here]
        names = sorted({topic for ignored in counts for topic in ignored})
        return {name: max(ignored.get(name, 0) for ignored in counts) for name in names}

    def _make_room(self, write: Callable[[], None]) -> None:
        """Write; where the disk is full, once more without the bag."""
        try:
            write()
        except OSError as error:
            if self._bag_dropped:
                raise
            self._drop_bag(error)
            write()

    def _drop_bag(self, error: OSError) -> None:
        """Leave the bag out of the results, and say so in them."""
        self._bag_dropped = True
        self._bag.drop()
        why = f"bag/ is left out of the results: {error.strerror}"
        self._recording.trial.source_events.append(
            SourceEvent(SourceEventKind.RECORD_STOPPED, self._recording.rows, self._stamp_ns, why)
        )


def _deserialised(data: bytes, kind: type) -> Any:
    try:
        return deserialize_message(data, kind)
    except RuntimeError as error:  # rclpy's RMWError
        raise MalformedMessage(str(error)) from None


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(RecorderNode, args)


if __name__ == "__main__":
    sys.exit(main())
