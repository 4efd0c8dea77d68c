"""Node `analysis`: takes every state of the worm, publishes observables, events and estimates."""

import sys
from collections import deque
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt64

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py import BodyState, convert, topics
from worm_msgs_py.convert.stamp import header
from worm_msgs_py.declarations import declarations
from worm_msgs_py.errors import MalformedMessage
from worm_msgs_py.ros.counting_publisher import Ledger
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW, RESULT
from worm_msgs_py.ros.running import run_alone
from worm_msgs_py.ros.stream_end import StreamEnd
from worm_msgs_py.ros.worm_node import WormNode
from worm_msgs_py.units import NS_PER_S

NAME = "analysis"
_OUT = (
    topics.ANALYSIS_STATE,
    topics.ANALYSIS_EVENTS,
    topics.ANALYSIS_CORRELATION,
    topics.ANALYSIS_DISTRIBUTIONS,
    topics.ANALYSIS_SUMMARY,
    topics.ANALYSIS_SUMS,
)

FRAMES_BETWEEN_ESTIMATES = 64
"""At least so many: of a film of a picture in ten seconds each frame would bring estimates, and the
frames that the tracker has held back more at once than latched topics hold."""


class AnalysisNode(WormNode):
    """Runs an `Analysis` on the graph.

    A state that rests on a geometry which has not come yet is held back, with all that follow it.
    When as many states have been taken as `flow/end` says, what is open is closed, the estimates
    are published a last time and the end is announced.

    Raises
    ------
    BadInput
        Where a parameter is out of range.
    """

    PARAMETERS = declarations(AnalysisParameters)
    STATE = (
        "_analysis",
        "_waiting",
        "_end.taken",
        "_events",
        "_last_ns",
        "_next_summary_ns",
        "_next_summary_frame",
        "_ledger.sent",
    )

    def __init__(self, **node_arguments: Any):
        super().__init__(NAME, **node_arguments)
        try:
            self._settings = self.read_parameters(AnalysisParameters)
        except BaseException:
            self.destroy_node()
            raise
        self._analysis = Analysis(self._settings)
        self._waiting: deque[BodyState] = deque()
        self._events = 0
        self._last_ns = 0
        self._next_summary_ns: int | None = None
        self._next_summary_frame = 0
        self._end = StreamEnd(self._finish)
        self._ledger = Ledger(self)
        self._out = {
            topic: self._ledger.publisher(kind, topic, qos)
            for topic, (kind, qos) in RESULTS.items()
            if topic in _OUT
        }
        self._diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, RESULT)
        for topic, on_message in (
            (topics.CHAMBER_GEOMETRY, self._on_geometry),
            (topics.WORM_STATE, self._on_state),
        ):
            kind, qos = RESULTS[topic]
            self.create_subscription(kind, topic, on_message, qos, in_sequence=True)
        self.create_subscription(UInt64, topics.FLOW_END, self._end.on_end, FLOW)

    @property
    def done(self) -> bool:
        """Whether every state was taken and the end was announced."""
        return self._end.done

    @property
    def missing(self) -> str:
        """What is still to come, for people."""
        if self._waiting and not self.done:
            state = self._waiting[0]
            return f"frame {state.frame} waits for geometry {state.geometry}"
        return self._end.missing

    def _on_geometry(self, msg: JointState) -> None:
        self._analysis.set_geometry(convert.geometry_from_msg(msg))
        self._take_waiting()

    def _on_state(self, msg: JointState) -> None:
        state = convert.body_state_from_msg(msg)
        due = self._end.taken + len(self._waiting)
        if state.frame != due:
            raise MalformedMessage(f"frame {state.frame} comes where frame {due} is due")
        self._waiting.append(state)
        self._take_waiting()

    def _take_waiting(self) -> None:
        while self._waiting and self._analysis.knows(self._waiting[0].geometry):
            self._take(self._waiting.popleft())
        self._end.finish_if_whole()

    def _take(self, state: BodyState) -> None:
        observables, events = self._analysis.push(state)
        self._end.taken += 1
        self._last_ns = state.stamp_ns
        before = (self._out[topics.ANALYSIS_EVENTS].sent, self._out[topics.ANALYSIS_SUMMARY].sent)
        self._out[topics.ANALYSIS_STATE].publish(convert.observables_to_msg(observables, before))
        self._publish_events(events)
        if self._next_summary_ns is None:
            self._postpone_estimates(state)
        elif state.stamp_ns >= self._next_summary_ns and self._end.taken > self._next_summary_frame:
            self._postpone_estimates(state)
            self._publish_estimates()

    def _postpone_estimates(self, state: BodyState) -> None:
        self._next_summary_ns = state.stamp_ns + round(self._settings.summary_interval_s * NS_PER_S)
        self._next_summary_frame = state.frame + FRAMES_BETWEEN_ESTIMATES

    def _publish_events(self, events: list[Any]) -> None:
        if events:
            self._events += len(events)
            self._out[topics.ANALYSIS_EVENTS].publish(convert.events_to_msg(events, self._last_ns))

    def _publish_estimates(self) -> None:
        correlation = convert.correlation_to_msg(self._analysis.correlation(), self._last_ns)
        self._out[topics.ANALYSIS_CORRELATION].publish(correlation)
        for distribution in self._analysis.distributions():
            self._out[topics.ANALYSIS_DISTRIBUTIONS].publish(
                convert.distribution_to_msg(distribution)
            )
        summary = convert.quantities_to_msg(self._analysis.summary(), self._last_ns)
        self._out[topics.ANALYSIS_SUMMARY].publish(summary)
        self._diagnostics.publish(self._health())

    def _health(self) -> DiagnosticArray:
        values = {
            "states taken": self._end.taken,
            "states waiting for a geometry": len(self._waiting),
            "events": self._events,
        }
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if self._waiting else DiagnosticStatus.OK,
            name=NAME,
            message="ended" if self._end.taken == self._end.frames else "running",
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        return DiagnosticArray(header=header(self._last_ns, ""), status=[status])

    def _finish(self) -> None:
        self._publish_events(self._analysis.finish())
        self._publish_estimates()
        for name, sums in self._analysis.sums().items():
            self._out[topics.ANALYSIS_SUMS].publish(convert.sums_to_msg(name, sums))
        self._ledger.announce()


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(AnalysisNode, args)


if __name__ == "__main__":
    sys.exit(main())
