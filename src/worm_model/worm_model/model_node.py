"""Node `model`: fits the boundary walk to the trial, forecasts with it and compares it."""

import sys
from collections import deque
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import JointState

from worm_model.inference.comparison import ModelParameters
from worm_model.inference.trial_model import TrialModel
from worm_msgs_py import Comparison, Correlation, Event, Observables, Quantity, convert, topics
from worm_msgs_py.declarations import declarations
from worm_msgs_py.errors import MalformedMessage
from worm_msgs_py.ros.counting_publisher import Ledger, read_announcement
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW
from worm_msgs_py.ros.running import run_alone
from worm_msgs_py.ros.stream_end import StreamEnd
from worm_msgs_py.ros.worm_node import WormNode

NAME = "model"
ANALYSIS_NODE = "analysis"
HEARD = (topics.ANALYSIS_STATE, topics.ANALYSIS_EVENTS, topics.ANALYSIS_SUMMARY)


class ModelNode(WormNode):
    """Runs a `TrialModel` on the graph.

    States, events and summaries of the analysis come on topics of their own, in any order. Each
    state says how many of the others were sent before it, and waits for these: so the model takes
    everything in the order in which the analysis said it. A summary with an exit waits for a
    geometry. When all has come that the analysis announced, the last comparison is published again
    with the joint question's answer, and the end is announced.

    Raises
    ------
    BadInput
        Where a parameter is out of range.
    """

    PARAMETERS = declarations(ModelParameters)
    STATE = ("_model", "_states", "_events", "_summaries", "_taken", "_ledger.sent")

    def __init__(self, **node_arguments: Any):
        super().__init__(NAME, **node_arguments)
        try:
            self._model = TrialModel(self.read_parameters(ModelParameters))
        except BaseException:
            self.destroy_node()
            raise
        self._states: deque[tuple[Observables, tuple[int, int]]] = deque()
        self._events: deque[tuple[Event, ...]] = deque()
        self._summaries: deque[tuple[tuple[Quantity, ...], int]] = deque()
        self._taken = dict.fromkeys(HEARD, 0)
        self._end = StreamEnd(self._finish, self._has_all, announcers=(ANALYSIS_NODE,))
        ledger = self._ledger = Ledger(self)
        self._forecast, self._comparison, self._correlation = (
            ledger.publisher(RESULTS[topic][0], topic, RESULTS[topic][1])
            for topic in (topics.MODEL_FORECAST, topics.MODEL_COMPARISON, topics.MODEL_CORRELATION)
        )
        for topic, on_message in (
            (topics.CHAMBER_GEOMETRY, self._on_geometry),
            (topics.ANALYSIS_STATE, self._on_state),
            (topics.ANALYSIS_EVENTS, self._on_events),
            (topics.ANALYSIS_SUMMARY, self._on_summary),
        ):
            kind, qos = RESULTS[topic]
            self.create_subscription(kind, topic, on_message, qos, in_sequence=True)
        self.create_subscription(
            DiagnosticStatus, topics.FLOW_FINISHED, self._on_announcement, FLOW
        )

    @property
    def done(self) -> bool:
        """Whether everything was taken and the end was announced."""
        return self._end.done

    @property
    def missing(self) -> str:
        """What is still to come, for people."""
        if self._end.done:
            return ""
        if self._summaries and self._model.needs_geometry(self._summaries[0][0]):
            return f"{len(self._summaries)} summaries wait for a geometry"
        waiting = (len(self._states), len(self._events), len(self._summaries))
        parts = []
        for topic, queue in zip(HEARD, waiting, strict=True):
            come = self._taken[topic] + queue
            announced = self._announced[topic] if self._announced else "?"
            if come != announced:
                parts.append(f"{come} of {announced} messages have come on {topic}")
        return "; ".join(parts)

    def _on_geometry(self, msg: JointState) -> None:
        geometry = convert.geometry_from_msg(msg)
        if geometry.chambers:
            self._model.set_geometry(geometry)
            self._take_waiting()

    def _on_state(self, msg: JointState) -> None:
        observables, before = convert.observables_from_msg(msg), convert.before_from_msg(msg)
        due = self._taken[topics.ANALYSIS_STATE] + len(self._states)
        if observables.frame != due:
            raise MalformedMessage(f"frame {observables.frame} comes where frame {due} is due")
        self._states.append((observables, before))
        self._take_waiting()

    def _on_events(self, msg: DiagnosticArray) -> None:
        self._events.append(convert.events_from_msg(msg))
        self._take_waiting()

    def _on_summary(self, msg: DiagnosticArray) -> None:
        stamp_ns = convert.stamp_to_ns(msg.header.stamp)
        self._summaries.append((convert.quantities_from_msg(msg), stamp_ns))
        self._take_waiting()

    @property
    def _announced(self) -> dict[str, int] | None:
        """How many messages the analysis has sent on each topic, once it has said so."""
        said = self._end.announced.get(ANALYSIS_NODE)
        return None if said is None else said.sent

    def _on_announcement(self, msg: DiagnosticStatus) -> None:
        said = read_announcement(msg)
        if said.name != ANALYSIS_NODE:
            return
        if not said.sent.keys() >= set(HEARD):
            raise MalformedMessage("the analysis announces all that it sent")
        self._end.on_announcement(msg)

    def _take_waiting(self) -> None:
        while self._states and self._catch_up(*self._states[0][1]):
            observables, _ = self._states.popleft()
            self._taken[topics.ANALYSIS_STATE] += 1
            forecast = self._model.take_state(observables)
            if forecast is not None:
                self._forecast.publish(convert.forecast_to_msg(forecast))
        self._end.finish_if_whole()

    def _catch_up(self, events: int, summaries: int) -> bool:
        """Take the events and summaries that come next; return whether there are so many yet.

        Between two states the analysis sends its events before its summary.
        """
        while self._taken[topics.ANALYSIS_EVENTS] < events:
            if not self._events:
                return False
            self._taken[topics.ANALYSIS_EVENTS] += 1
            for event in self._events.popleft():
                self._model.take_event(event)
        while self._taken[topics.ANALYSIS_SUMMARY] < summaries:
            if not self._summaries or self._model.needs_geometry(self._summaries[0][0]):
                return False
            self._taken[topics.ANALYSIS_SUMMARY] += 1
            self._publish(self._model.take_summary(*self._summaries.popleft()))
        return True

    def _publish(self, results: tuple[Comparison, Correlation] | None) -> None:
        if results is None:
            return
        comparison, correlation = results
        self._comparison.publish(convert.comparison_to_msg(comparison))
        stamp_ns = comparison.stamp_ns
        self._correlation.publish(convert.correlation_to_msg(correlation, stamp_ns))

    def _has_all(self) -> bool:
        """Take what follows the last state; return whether all has come that was announced."""
        announced = self._announced
        if (
            announced is None
            or self._taken[topics.ANALYSIS_STATE] != announced[topics.ANALYSIS_STATE]
        ):
            return False
        return self._catch_up(*(announced[topic] for topic in HEARD[1:]))

    def _finish(self) -> None:
        self._publish(self._model.finish())
        self._ledger.announce()


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(ModelNode, args)


if __name__ == "__main__":
    sys.exit(main())
