"""Node `model`: runs the boundary walk on each summary of the analysis."""

import sys
from collections import deque
from dataclasses import fields
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import JointState

from worm_model.comparison import ModelParameters, can_compare, compare
from worm_msgs_py import Geometry, Quantity, convert, topics
from worm_msgs_py.interfaces import RESULTS
from worm_msgs_py.ledger import Ledger, read_announcement
from worm_msgs_py.qos import FLOW
from worm_msgs_py.running import run_alone
from worm_msgs_py.worm_node import WormNode

NAME = "model"
ANALYSIS = "analysis"
DESCRIPTIONS = {
    "walks": "number of walks of the Monte Carlo",
    "seed": "seed of the Monte Carlo",
    "rule": "what a reversal counts: per_cycle, per_phase or rate",
    "hop_may_land": "whether a hop that ends above the exit finds it",
    "effective_width": "whether the exit is sqrt(W^2 + h^2) wide",
    "longest_lag_s": "longest lag of the model's C_theta",
    "lag_step_s": "step of its lags",
}
"""Of the node's parameters, which are the fields of `ModelParameters`, one for one."""


class ModelNode(WormNode):
    """Holds the boundary walk against the trial, anew with each summary.

    Parameters (read once)
    ----------------------
    Those of `ModelParameters`.

    A summary that can be compared is held back until a geometry has come: R and h are those of the
    rig and the same in each version. Summaries without an exit, or with nothing measured yet, give
    no message. When as many summaries have come as the analysis announced, the end is announced.

    Raises
    ------
    ValueError
        Where a parameter is out of range.
    """

    def __init__(self, **node_arguments: Any):
        super().__init__(NAME, **node_arguments)
        try:
            self._settings = self._read_parameters()
        except BaseException:
            self.destroy_node()
            raise
        self._geometry: Geometry | None = None
        self._waiting: deque[tuple[tuple[Quantity, ...], int]] = deque()
        self._received = 0
        self._announced: int | None = None
        self._done = False
        ledger = self._ledger = Ledger(self)
        self._comparison, self._correlation = (
            ledger.publisher(RESULTS[topic][0], topic, RESULTS[topic][1])
            for topic in (topics.MODEL_COMPARISON, topics.MODEL_CORRELATION)
        )
        for topic, on_message in (
            (topics.CHAMBER_GEOMETRY, self._on_geometry),
            (topics.ANALYSIS_SUMMARY, self._on_summary),
        ):
            kind, qos = RESULTS[topic]
            self.create_subscription(kind, topic, on_message, qos)
        self.create_subscription(
            DiagnosticStatus, topics.FLOW_FINISHED, self._on_announcement, FLOW
        )

    @property
    def done(self) -> bool:
        """Whether every summary was taken and the end was announced."""
        return self._done

    @property
    def missing(self) -> str:
        """What is still to come, for people."""
        if self._done:
            return ""
        if self._waiting:
            return f"{len(self._waiting)} summaries wait for a geometry"
        announced = "?" if self._announced is None else self._announced
        return f"{self._received} of {announced} summaries have come"

    def _read_parameters(self) -> ModelParameters:
        values = {}
        for field in fields(ModelParameters):
            values[field.name] = self.read_parameter(
                field.name, field.default, DESCRIPTIONS[field.name]
            )
        return ModelParameters(**values)

    def _on_geometry(self, msg: JointState) -> None:
        geometry = convert.geometry_from_msg(msg)
        if geometry.chambers:
            self._geometry = geometry
            self._take_waiting()

    def _on_summary(self, msg: DiagnosticArray) -> None:
        self._received += 1
        quantities = convert.quantities_from_msg(msg)
        if can_compare(quantities):
            self._waiting.append((quantities, convert.stamp_to_ns(msg.header.stamp)))
        self._take_waiting()

    def _on_announcement(self, msg: DiagnosticStatus) -> None:
        name, sent = read_announcement(msg)
        if name == ANALYSIS:
            self._announced = sent[topics.ANALYSIS_SUMMARY]
            self._finish_if_whole()

    def _take_waiting(self) -> None:
        while self._waiting and self._geometry is not None:
            quantities, stamp_ns = self._waiting.popleft()
            comparison, correlation = compare(quantities, self._geometry, stamp_ns, self._settings)
            self._comparison.publish(convert.comparison_to_msg(comparison))
            self._correlation.publish(convert.correlation_to_msg(correlation, stamp_ns))
        self._finish_if_whole()

    def _finish_if_whole(self) -> None:
        if self._done or self._waiting or self._received != self._announced:
            return
        self._done = True
        self._ledger.announce()


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_alone(ModelNode, args)


if __name__ == "__main__":
    sys.exit(main())
