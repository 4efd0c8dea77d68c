"""The model node: the same messages, whatever the order in which those of the analysis come."""

import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from walked_tracks import GEOMETRY, slides_and_hops

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_model.inference.comparison import ModelParameters
from worm_model.inference.trial_model import TrialModel
from worm_model.model_node import ANALYSIS_NODE, HEARD, ModelNode
from worm_msgs_py import Observables, Quantity, convert, topics
from worm_msgs_py.ros.counting_publisher import read_announcement
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import FLOW
from worm_tracker.sources.source_node import drain

MODEL = (topics.MODEL_FORECAST, topics.MODEL_COMPARISON, topics.MODEL_CORRELATION)
EVERY = 100
"""Frames between two summaries."""
INTERVAL_S = 1.0
"""Between two forecasts."""


def said():
    """Return what an analysis says of a simulated worm: (topic, message) in its order."""
    analysis = Analysis(AnalysisParameters(minimum_n=5))
    analysis.set_geometry(GEOMETRY)
    found, sent, stamp_ns = [], dict.fromkeys(HEARD, 0), 0

    def say(topic, msg):
        found.append((topic, msg))
        sent[topic] += 1

    def estimate():
        msg = convert.quantities_to_msg(analysis.summary(), stamp_ns)
        say(topics.ANALYSIS_SUMMARY, msg)

    for number, state in enumerate(slides_and_hops(0, 45.0, 10.0).states()):
        observables, events = analysis.push(state)
        stamp_ns = state.stamp_ns
        before = (sent[topics.ANALYSIS_EVENTS], sent[topics.ANALYSIS_SUMMARY])
        say(topics.ANALYSIS_STATE, convert.observables_to_msg(observables, before))
        if events:
            say(topics.ANALYSIS_EVENTS, convert.events_to_msg(events, stamp_ns))
        if number % EVERY == EVERY - 1:
            estimate()
    events = analysis.finish()
    if events:
        say(topics.ANALYSIS_EVENTS, convert.events_to_msg(events, stamp_ns))
    estimate()
    return found, sent


SAID, SENT = said()


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
        self._to = {
            topic: self.create_publisher(RESULTS[topic][0], topic, RESULTS[topic][1])
            for topic in (topics.CHAMBER_GEOMETRY, *HEARD)
        }
        self._finished = self.create_publisher(DiagnosticStatus, topics.FLOW_FINISHED, FLOW)

    def _on_finished(self, msg):
        said = read_announcement(msg)
        name, counts = said.name, said.sent
        if name == "model":
            self.announced.append(counts)

    def send(self, topic, msg):
        self._to[topic].publish(msg)

    def send_geometry(self):
        self.send(topics.CHAMBER_GEOMETRY, convert.geometry_to_msg(GEOMETRY))

    def send_end(self, sent=SENT):
        values = [KeyValue(key=topic, value=str(count)) for topic, count in sent.items()]
        self._finished.publish(
            DiagnosticStatus(name=ANALYSIS_NODE, message="finished", values=values)
        )

    def content(self):
        return {topic: [repr(msg) for msg in got] for topic, got in self.got.items()}


@pytest.fixture
def graph(ros_context):
    executor = SingleThreadedExecutor(context=ros_context)
    overrides = [Parameter("forecast_interval_s", value=INTERVAL_S)]
    model = ModelNode(context=ros_context, parameter_overrides=overrides)
    nodes = Surroundings(ros_context), model
    for node in nodes:
        executor.add_node(node)
    yield *nodes, lambda: drain(executor)
    executor.shutdown()
    for node in nodes:
        node.destroy_node()


@pytest.fixture(scope="module")
def expected():
    """What the core says when it is given everything in the analysis' own order."""
    model = TrialModel(ModelParameters(forecast_interval_s=INTERVAL_S))
    model.set_geometry(GEOMETRY)
    found = {topic: [] for topic in MODEL}

    def keep(results):
        if results is not None:
            comparison, correlation = results
            found[topics.MODEL_COMPARISON].append(convert.comparison_to_msg(comparison))
            msg = convert.correlation_to_msg(correlation, comparison.stamp_ns)
            found[topics.MODEL_CORRELATION].append(msg)

    for topic, msg in SAID:
        if topic == topics.ANALYSIS_EVENTS:
            for event in convert.events_from_msg(msg):
                model.take_event(event)
        elif topic == topics.ANALYSIS_SUMMARY:
            stamp_ns = convert.stamp_to_ns(msg.header.stamp)
            keep(model.take_summary(convert.quantities_from_msg(msg), stamp_ns))
        else:
            forecast = model.take_state(convert.observables_from_msg(msg))
            if forecast is not None:
                found[topics.MODEL_FORECAST].append(convert.forecast_to_msg(forecast))
    keep(model.finish())
    return found


def by_topic(order):
    return [(t, m) for topic in order for t, m in SAID if t == topic]


STATE, EVENTS, SUMMARY = HEARD
ORDERS = {
    "as it was said": SAID,
    "states first": by_topic([STATE, EVENTS, SUMMARY]),
    "summaries first": by_topic([SUMMARY, EVENTS, STATE]),
    "events last": by_topic([SUMMARY, STATE, EVENTS]),
}


@pytest.mark.parametrize(
    ("order", "first"),
    [
        ("as it was said", "geometry"),
        ("as it was said", "neither"),
        ("states first", "geometry"),
        ("states first", "end"),
        ("summaries first", "neither"),
        ("events last", "end"),
    ],
)
def test_the_same_messages_whatever_the_order_of_arrival(graph, expected, order, first):
    surroundings, model, run = graph
    if first == "geometry":
        surroundings.send_geometry()
    elif first == "end":
        surroundings.send_end()
    run()
    for topic, msg in ORDERS[order]:
        assert not model.done
        surroundings.send(topic, msg)
        run()
    if first != "geometry":
        assert not model.done
        surroundings.send_geometry()
        run()
    if first != "end":
        assert not model.done
        surroundings.send_end()
        run()
    assert model.done
    assert model.missing == ""
    told = {topic: [repr(msg) for msg in msgs] for topic, msgs in expected.items()}
    assert surroundings.content() == told
    assert surroundings.announced == [{topic: len(sent) for topic, sent in expected.items()}]


def test_the_trial_is_compared_at_each_summary_and_asked_the_joint_question_at_the_end(expected):
    comparisons = [convert.comparison_from_msg(msg) for msg in expected[topics.MODEL_COMPARISON]]
    assert len(comparisons) == SENT[SUMMARY] + 1
    assert [bool(c.needs) for c in comparisons] == [False] * SENT[SUMMARY] + [True]
    assert repr(comparisons[-1].quantities) == repr(comparisons[-2].quantities)
    assert comparisons[-1].parameters == comparisons[-2].parameters
    forecasts = [convert.forecast_from_msg(msg) for msg in expected[topics.MODEL_FORECAST]]
    assert len(forecasts) == 35, "one a second from the first summary on"
    assert [f.frame for f in forecasts[:3]] == [100, 110, 120]
    assert any(f.median_s > 0 for f in forecasts)


def test_a_trial_without_a_chamber_ends_without_a_comparison(graph):
    surroundings, model, run = graph
    nothing = [Quantity("d_c", None, why="no chamber in the picture")]
    surroundings.send(STATE, convert.observables_to_msg(Observables(0, 5)))
    surroundings.send(SUMMARY, convert.quantities_to_msg(nothing, 10))
    surroundings.send_end({STATE: 1, EVENTS: 0, SUMMARY: 1})
    run()
    assert model.done
    assert surroundings.announced == [dict.fromkeys(MODEL, 0)]


def test_what_is_missing_is_said(graph):
    surroundings, model, run = graph
    surroundings.send(*next(item for item in SAID if item[0] == SUMMARY))
    run()
    assert model.missing == "1 summaries wait for a geometry"
    surroundings.send_geometry()
    surroundings.send_end()
    run()
    assert model.missing.split("; ") == [
        f"0 of {SENT[STATE]} messages have come on {STATE}",
        f"0 of {SENT[EVENTS]} messages have come on {EVENTS}",
        f"1 of {SENT[SUMMARY]} messages have come on {SUMMARY}",
    ]


def test_a_bad_parameter_is_refused(ros_context):
    with pytest.raises(ValueError, match="rule is 'per_worm'"):
        ModelNode(context=ros_context, parameter_overrides=[Parameter("rule", value="per_worm")])
