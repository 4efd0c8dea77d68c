"""What both sources of pictures share: counting, back-pressure, the end, how they are driven."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import Executor, SingleThreadedExecutor, TimeoutException
from rclpy.parameter import Parameter
from std_msgs.msg import UInt64, UInt64MultiArray

from worm_msgs_py import SourceEvent, SourceEventKind, convert, topics
from worm_msgs_py.contract.source_events import parameter_changed
from worm_msgs_py.convert.stamp import header
from worm_msgs_py.errors import BadInput, MalformedMessage
from worm_msgs_py.ros.counting_publisher import Ledger
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, RESULT
from worm_msgs_py.ros.running import TICK_S, run_alone
from worm_msgs_py.ros.watchdog import Watch
from worm_msgs_py.ros.worm_node import WormNode

NAME = "image_source"
_REPORT_EVERY_S = 1.0
_SERVE_EVERY_S = 0.02
"""How long services and timers may wait between pictures: to look for them takes 0.5 ms."""


class SourceNode(WormNode):
    """A node that sends pictures when it is told to, and counts them.

    Sources have no timer and no thread that publishes: whoever drives one asks `wait_s`, whether
    the `window_is_open`, and calls `publish_next`. So the in-process graph can step it frame by
    frame, and a process of its own can feel the back-pressure of the others:

        in flight = (sent - taken) + max(0, given - recorded)  <=  window

    The counters come from different processes: the recorder may report a burst of states before
    the tracker's own report of them is here. Such a lead must not be counted against frames that
    still wait before the tracker, or the window lets through more than its queue can hold.
    Frames that the tracker has taken and holds back are not in flight. Without a recorder in the
    graph nothing is ever recorded, and the last two terms are left out.

    Attributes
    ----------
    sent : int
        Frames that were published.
    expected : int or None
        Frames that will have been published at the end, where that is known.
    window : int
        Greatest number of frames in flight; 0 where nobody is waited for.
    endless : bool
        Whether the stream has no end of its own (a camera, a loop), so that a signal ends it in
        good order (`end_now`). A recording that is not played to its end is incomplete instead.
    ended_early : str
        Why the source ended before its time; empty where it did not.
    next_is_asked : bool
        Whether an operator ended the stream to begin the next trial.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "sent",
        "ended_early",
        "_taken",
        "_given",
        "_recorded",
        "_ledger.sent",
    )
    endless = False
    next_is_asked = False

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(NAME, **node_arguments)
        self.sent = 0
        self.expected: int | None = None
        self.window = 0
        self.ended_early = ""
        self._taken = self._given = self._recorded = 0
        self._ended = False
        self._reported_s = -float("inf")
        self._ledger = Ledger(self)
        kind, qos = RESULTS[topics.SOURCE_EVENTS]
        self._events = self._ledger.publisher(kind, topics.SOURCE_EVENTS, qos)
        self._end_publisher = self.create_publisher(UInt64, topics.FLOW_END, FLOW)
        self._diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, RESULT)
        self.create_subscription(UInt64MultiArray, topics.FLOW_TRACKED, self._on_tracked, FLOW)
        self.create_subscription(UInt64, topics.FLOW_RECORDED, self._on_recorded, FLOW)

    def _on_tracked(self, msg: UInt64MultiArray) -> None:
        counts = convert.counts_from_msg(msg)
        # Of a burst of counters the last ones come, so their DDS numbers may have gaps.
        if len(counts) != 2 or not self.sent >= counts[0] >= counts[1]:
            raise MalformedMessage(f"{counts} are no frames taken and given of {self.sent}")
        self._taken, self._given = max(self._taken, counts[0]), max(self._given, counts[1])

    def _on_recorded(self, msg: UInt64) -> None:
        recorded = convert.count_from_msg(msg)
        if recorded > self.sent:
            raise MalformedMessage(f"{recorded} frames of {self.sent} are recorded")
        self._recorded = max(self._recorded, recorded)  # it counts again after a checkpoint

    @property
    def in_flight(self) -> int:
        """Frames between this node and the recorder, those that the tracker holds left out."""
        to_tracker = self.sent - self._taken
        if self.count_publishers(topics.FLOW_RECORDED) == 0:
            return to_tracker
        return to_tracker + max(0, self._given - self._recorded)

    @property
    def window_is_open(self) -> bool:
        """Whether one frame more may be sent."""
        return self.window == 0 or self.in_flight < self.window

    @property
    def taken_by_tracker(self) -> bool:
        """Whether the tracker has taken all that was sent (or there is no tracker)."""
        return self._taken >= self.sent or self.count_publishers(topics.FLOW_TRACKED) == 0

    @property
    def done(self) -> bool:
        """Whether the end was announced."""
        return self._ended

    @property
    def last_stamp_ns(self) -> int:
        """Stamp of the last frame that was sent; 0 before the first."""
        raise NotImplementedError

    @property
    def picture_waits(self) -> bool:
        """Whether one is late already: what follows from earlier ones may be done after it."""
        return False

    @property
    def is_watched(self) -> bool:
        """Whether somebody subscribes to the pictures."""
        raise NotImplementedError

    def begin(self) -> None:
        """Take note that all other nodes are ready: pictures may come."""

    def wait_s(self) -> float:
        """Return the seconds until the next picture is due; 0 where it is, infinity if unknown."""
        raise NotImplementedError

    def publish_next(self) -> bool:
        """Publish the next picture; at the end announce the end instead, and return False."""
        raise NotImplementedError

    def end_now(self) -> None:
        """End an endless stream: nothing comes after the frames that are waiting."""
        raise NotImplementedError

    def counts(self) -> dict[str, str]:
        """Return what `/diagnostics` shows of this source."""
        return {"frames sent": str(self.sent), "frames taken": str(self._taken)}

    def complaint(self) -> str:
        """Return what is wrong with the source, empty where nothing is."""
        return ""

    def report(self, *, at_once: bool = False) -> None:
        """Publish the counts on `/diagnostics` if a second has passed since the last time."""
        now_s = time.monotonic()
        if not at_once and now_s - self._reported_s < _REPORT_EVERY_S:
            return
        self._reported_s = now_s
        complaint = self.complaint()
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if complaint else DiagnosticStatus.OK,
            name=NAME,
            message=complaint or ("ended" if self._ended else "running"),
            values=[KeyValue(key=key, value=value) for key, value in self.counts().items()],
        )
        self._diagnostics.publish(
            DiagnosticArray(header=header(time.time_ns(), ""), status=[status])
        )

    def _tell(self, event: SourceEvent) -> None:
        """Publish what happened to the pictures; it goes into the results."""
        if event.kind is SourceEventKind.ENDED_EARLY:
            self.ended_early = event.why
        self._events.publish(convert.source_events_to_msg([event], event.stamp_ns))

    def why_no_change(self, parameter: Parameter) -> str:
        """Return that the trial has ended, where it has: its results are told already."""
        return "the trial has ended" if self._ended else ""

    def take_change(self, name: str, before: Any, value: Any) -> None:
        """Tell of a changed parameter; it goes into the results."""
        self._tell(parameter_changed(NAME, name, before, value, self.sent, self.last_stamp_ns))

    def _announce_end(self) -> None:
        if not self._ended:
            self._ended = True
            self._ledger.announce()
            self._end_publisher.publish(convert.count_to_msg(self.sent))


def drain(
    executor: Executor,
    spent_s: dict[str, float] | None = None,
    watch: Watch | None = None,
    enough: Callable[[], bool] = lambda: False,
) -> None:
    """Run callbacks until a *whole pass* over all nodes finds none ready, or it is enough.

    Delivery within a process is synchronous with `publish`, so afterwards everything that follows
    from what was published has happened. (Stopping at the first time that nothing is ready leaves
    a chain of nodes a frame or two behind.)

    Parameters
    ----------
    executor : rclpy.executors.Executor
        Whatever a callback raises comes out here.
    spent_s : dict, optional
        Seconds spent in the callbacks of each node, by name; added to.
    watch : Watch, optional
        Told of every callback.
    enough : callable, optional
        Asked after every pass, which takes a message of each topic; what is left waits.
    """
    idle = False
    while not idle:
        idle = True
        try:
            while True:
                handler, _, node = executor.wait_for_ready_callbacks(timeout_sec=0)
                idle = False
                name = "" if node is None else node.get_name()
                with _at_work(name, spent_s, watch):
                    handler()
                if handler.exception() is not None:
                    raise handler.exception()
        except TimeoutException:  # a pass has ended; one that is left within hides what comes next
            if enough():
                return


def take_messages(
    executor: Executor,
    spent_s: dict[str, float] | None = None,
    watch: Watch | None = None,
    enough: Callable[[], bool] = lambda: False,
) -> None:
    """Let nodes take messages until there is none, one of each topic at a time; as `drain`.

    It is asked whether that is enough after every second round, so that a topic of one message a
    picture does not fall behind where it always is.
    """
    nodes = [node for node in executor.get_nodes() if isinstance(node, WormNode)]
    for rounds in count(1):
        any_taken = False
        for node in nodes:
            with _at_work(node.get_name(), spent_s, watch):
                any_taken |= node.take_messages()
        if not any_taken or (rounds % 2 == 0 and enough()):
            return


@contextmanager
def _at_work(name: str, spent_s: dict[str, float] | None, watch: Watch | None) -> Iterator[None]:
    """Note that a node is at work, and how long it has been."""
    began_s = time.perf_counter()
    if watch is not None:
        watch.enter(name)
    try:
        yield
    finally:
        if watch is not None:
            watch.leave()
        if spent_s is not None and name:
            spent_s[name] = spent_s.get(name, 0.0) + time.perf_counter() - began_s


def spin_source(
    executor: Executor,
    source: SourceNode,
    keep_on: Callable[[], bool],
    *,
    heed_window: bool,
    spent_s: dict[str, float] | None = None,
    watch: Watch | None = None,
) -> bool:
    """Publish every picture as it falls due and may be sent; between them run the callbacks.

    A camera's picture does not wait for all that follows from earlier ones: where the tracker gives
    hundreds of states at once, which it held back, they are analysed and recorded as time allows.

    Parameters
    ----------
    keep_on : callable
        Asked before each step; False ends it.
    heed_window : bool
        Send only while the window is open. In one process draining is the stronger promise.
    spent_s, watch
        As for `drain`. Of an endless source messages are taken past the executor each time,
        and services and timers served at times.

    Returns
    -------
    bool
        Whether the source came to its end.
    """
    source.begin()
    serve = _between_pictures(executor, source, spent_s, watch)
    while keep_on():
        source.report()
        wait_s = source.wait_s()
        if wait_s <= 0.0 and heed_window and not source.window_is_open:
            wait_s = TICK_S  # a counter that comes in ends the wait
        if wait_s > 0.0:
            with _at_work("", None, watch):  # whichever is called; the traceback says
                executor.spin_once(timeout_sec=min(wait_s, TICK_S))
        else:
            with _at_work(NAME, spent_s, watch):
                more = source.publish_next()
            if not more:
                return True
        serve()
    return False


def _between_pictures(
    executor: Executor, source: SourceNode, spent_s: dict[str, float] | None, watch: Watch | None
) -> Callable[[], None]:
    """Return what lets all nodes go on after a picture, or after a wait.

    A replay's bag keeps the order that it had, and others' nodes get messages by an executor alone:
    there all is done each time.
    """
    ours_alone = all(isinstance(node, WormNode) for node in executor.get_nodes())
    if not (ours_alone and source.endless):
        return lambda: drain(executor, spent_s, watch)
    served_s = -float("inf")

    def picture_waits() -> bool:
        return source.picture_waits

    def serve() -> None:
        nonlocal served_s
        if time.monotonic() - served_s >= _SERVE_EVERY_S:
            drain(executor, spent_s, watch, picture_waits)
            served_s = time.monotonic()
        take_messages(executor, spent_s, watch, picture_waits)

    return serve


def until_stopped(source: SourceNode, stop: threading.Event) -> Callable[[], bool]:
    """Return what to ask before each step: the first stop ends an endless source, then all."""
    asked_to_end = False

    def keep_on() -> bool:
        nonlocal asked_to_end
        if stop.is_set() and source.endless and not asked_to_end:
            asked_to_end = True
            stop.clear()
            source.end_now()
        return not stop.is_set()

    return keep_on


def run_source_alone(make: Callable[[], SourceNode], args: list[str] | None = None) -> int:
    """Run one source as a process: wait for someone to look, send everything, end.

    Returns
    -------
    int
        The process's exit status: 0 whole, 1 interrupted, 2 bad input (one line on stderr).
    """
    return run_alone(make, args, refusals=(BadInput,), drive=_send_everything)


def _send_everything(
    source: SourceNode, executor: SingleThreadedExecutor, stop: threading.Event
) -> int:
    while not stop.is_set() and not source.is_watched:
        executor.spin_once(timeout_sec=TICK_S)
    keep_on = until_stopped(source, stop)
    ended = spin_source(executor, source, keep_on, heed_window=True)
    while not stop.is_set() and source.window > 0 and source.in_flight > 0:
        executor.spin_once(timeout_sec=TICK_S)  # the latched end must be there to be read
    return 0 if ended else 1
