"""The model node: a comparison for each summary, whatever the order in which things come."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from worm_model.boundary_walk import WalkParameters, simulate
from worm_model.comparison import ModelParameters, can_compare, compare
from worm_model.node import DESCRIPTIONS, ModelNode
from worm_model.rig import Rig
from worm_msgs_py import Quantity, convert, topics
from worm_msgs_py.interfaces import RESULTS
from worm_msgs_py.ledger import read_announcement
from worm_msgs_py.qos import FLOW

GEOMETRY = Rig(exit_width_mm=1.0).geometry()
MODEL = (topics.MODEL_COMPARISON, topics.MODEL_CORRELATION)


def summary(**values):
    units = {"v_b": "mm/s", "reversal_per_cycle": "1", "tau_h": "s", "n_s": "per 30 min"}
    measured = {"w_s": 1.8027756377319946} | values
    return [
        Quantity(name, value, unit=units.get(name, "mm"), why="" if value else "not enough data")
        for name, value in measured.items()
    ]


MEASURED = summary(d_c=3.0, d_nc=1.0, v_b=1.5, reversal_per_cycle=0.1, tau_h=40.0)


def by_name(comparison):
    return {quantity.name: quantity for quantity in comparison.quantities}


def test_the_walk_runs_with_the_trials_own_numbers():
    comparison, _ = compare(MEASURED, GEOMETRY, 7, ModelParameters(walks=500, seed=3))
    walk = WalkParameters(
        mean_slide_mm=3.0, mean_hop_mm=1.0, speed_mm_s=1.5, reversal=0.1, exit_width_mm=1.0
    )
    expected = simulate(walk, 500, 3).mean_tau_h_s()
    tau = by_name(comparison)["tau_h"]
    assert (tau.modelled, tau.modelled_low) == pytest.approx((expected.value, expected.low))
    assert tau.measured == 40.0
    used = dict(comparison.parameters)
    assert used["mean_slide_m"] == pytest.approx(3e-3)
    assert used["W_m"] == pytest.approx(1e-3)
    assert used["exit_arc_m"] == pytest.approx(1.8027756e-3)
    assert {used[f"{n}_is_measured"] for n in ("d_c", "d_nc", "v_b", "reversal_per_cycle")} == {1.0}
    assert comparison.stamp_ns == 7


def test_what_the_trial_does_not_give_is_the_papers_and_said_to_be():
    few = summary(d_c=None, d_nc=1.0, v_b=None, reversal_per_cycle=0.0)
    used = dict(compare(few, GEOMETRY, 0, ModelParameters(walks=50))[0].parameters)
    assert (used["mean_slide_m"], used["d_c_is_measured"]) == (pytest.approx(1.95e-3), 0.0)
    assert (used["v_m_s"], used["v_b_is_measured"]) == (pytest.approx(2.02e-3), 0.0)
    assert (used["mean_hop_m"], used["d_nc_is_measured"]) == (pytest.approx(1e-3), 1.0)
    assert (used["reversal"], used["reversal_per_cycle_is_measured"]) == (0.0, 1.0)


def test_skips_are_told_for_thirty_minutes_as_the_measurement_is():
    n_s = by_name(compare(summary(d_c=1.95), GEOMETRY, 0, ModelParameters())[0])["n_s"]
    assert n_s.unit == "per 30 min"
    assert n_s.modelled == pytest.approx(1800 * 0.151 / 50.88, rel=0.25)
    assert n_s.modelled_low < n_s.modelled < n_s.modelled_high


def test_two_chances_a_cycle_turn_as_often_as_the_measured_one():
    trial = summary(reversal_per_cycle=0.18)
    used = dict(
        compare(trial, GEOMETRY, 0, ModelParameters(walks=9, rule="per_phase"))[0].parameters
    )
    assert used["reversal"] == pytest.approx(0.1)  # 2 · 0.1 · 0.9 = 0.18


def test_without_an_exit_or_anything_measured_there_is_nothing_to_compare():
    assert not can_compare([q for q in MEASURED if q.name != "w_s"])
    assert not can_compare(summary(d_c=None))
    assert not can_compare([])


@pytest.mark.parametrize(
    "wrong", [{"walks": 1}, {"seed": -1}, {"rule": "per_worm"}, {"lag_step_s": 0.0}]
)
def test_parameters_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=r"walks|seed|rule|lag_step_s"):
        ModelParameters(**wrong)


class Surroundings(Node):
    """Stands for tracker, analysis and recorder."""

    def __init__(self, context):
        super().__init__("surroundings", context=context, start_parameter_services=False)
        self.got = {topic: [] for topic in MODEL}
        self.announced = []
        for topic in MODEL:
            kind, qos = RESULTS[topic]
            self.create_subscription(kind, topic, self.got[topic].append, qos)
        self.create_subscription(DiagnosticStatus, topics.FLOW_FINISHED, self._on_finished, FLOW)
        self._geometry, self._summary = (
            self.create_publisher(RESULTS[topic][0], topic, RESULTS[topic][1])
            for topic in (topics.CHAMBER_GEOMETRY, topics.ANALYSIS_SUMMARY)
        )
        self._finished = self.create_publisher(DiagnosticStatus, topics.FLOW_FINISHED, FLOW)

    def _on_finished(self, msg):
        name, counts = read_announcement(msg)
        if name == "model":
            self.announced.append(counts)

    def send_geometry(self):
        self._geometry.publish(convert.geometry_to_msg(GEOMETRY))

    def send_summary(self, quantities, stamp_ns):
        self._summary.publish(convert.quantities_to_msg(quantities, stamp_ns))

    def send_end(self, summaries):
        count = KeyValue(key=topics.ANALYSIS_SUMMARY, value=str(summaries))
        self._finished.publish(
            DiagnosticStatus(level=DiagnosticStatus.OK, name="analysis", values=[count])
        )


def settle(executor):
    for _ in range(50):
        executor.spin_once(timeout_sec=0.0)


@pytest.fixture
def graph(ros_context):
    executor = SingleThreadedExecutor(context=ros_context)
    overrides = [Parameter("walks", value=100)]
    nodes = (
        Surroundings(ros_context),
        ModelNode(context=ros_context, parameter_overrides=overrides),
    )
    for node in nodes:
        executor.add_node(node)
    yield *nodes, lambda: settle(executor)
    executor.shutdown()
    for node in nodes:
        node.destroy_node()


ORDERS = ["geometry 1 2 end", "1 2 geometry end", "end 1 2 geometry", "1 end geometry 2"]


@pytest.mark.parametrize("order", ORDERS)
def test_every_summary_is_compared_once_in_whatever_order_things_come(graph, order):
    surroundings, model, run = graph
    sends = {
        "geometry": surroundings.send_geometry,
        "1": lambda: surroundings.send_summary(MEASURED, 10),
        "2": lambda: surroundings.send_summary(summary(d_c=2.0), 20),
        "end": lambda: surroundings.send_end(2),
    }
    for item in order.split():
        assert not model.done
        sends[item]()
        run()
    assert model.done
    got = [convert.comparison_from_msg(m) for m in surroundings.got[topics.MODEL_COMPARISON]]
    parameters = ModelParameters(walks=100)
    for comparison, quantities in zip(got, (MEASURED, summary(d_c=2.0)), strict=True):
        expected = compare(quantities, GEOMETRY, comparison.stamp_ns, parameters)[0]
        assert comparison.parameters == expected.parameters
        assert by_name(comparison)["tau_h"].modelled == by_name(expected)["tau_h"].modelled
    assert [c.stamp_ns for c in got] == [10, 20]
    assert surroundings.announced == [dict.fromkeys(MODEL, 2)]


def test_the_models_c_theta_is_published_beside_it(graph):
    surroundings, _, run = graph
    surroundings.send_geometry()
    surroundings.send_summary(MEASURED, 10)
    run()
    curve = convert.correlation_from_msg(surroundings.got[topics.MODEL_CORRELATION][0])
    assert curve.c[0] == pytest.approx(1.0)
    assert np.all(np.diff(curve.c) < 0)
    assert curve.lag_s[-1] == pytest.approx(60.0)


def test_a_trial_without_a_chamber_ends_without_a_comparison(graph):
    surroundings, model, run = graph
    surroundings.send_summary([Quantity("d_c", None, why="no chamber in the picture")], 10)
    surroundings.send_end(1)
    run()
    assert model.done
    assert surroundings.announced == [dict.fromkeys(MODEL, 0)]


def test_what_is_missing_is_said(graph):
    surroundings, model, run = graph
    surroundings.send_summary(MEASURED, 10)
    run()
    assert model.missing == "1 summaries wait for a geometry"
    surroundings.send_geometry()
    surroundings.send_end(3)
    run()
    assert model.missing == "1 of 3 summaries have come"


def test_every_parameter_is_described():
    assert set(DESCRIPTIONS) == set(ModelParameters.__dataclass_fields__)
