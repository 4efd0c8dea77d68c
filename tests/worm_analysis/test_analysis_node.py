"""The node: one message a state, whatever the order in which states, geometry and end come."""

from dataclasses import replace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import UInt64
from walked_tracks import GEOMETRY, slides_and_hops

from worm_analysis.analysis import Analysis
from worm_analysis.analysis_node import AnalysisNode
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py import convert, topics
from worm_msgs_py.ros.counting_publisher import Announcement, read_announcement
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import ESTIMATES_DEPTH, FLOW, LATCHED_SET_DEPTH
from worm_tracker.parameters import MOST_HOLD_BACK_FRAMES
from worm_tracker.sources.source_node import drain

ANALYSIS = [topic for topic in RESULTS if topic.startswith("analysis/")]


class Surroundings(Node):
    """Stands for tracker, source and recorder: sends states, keeps what the analysis says."""

    def __init__(self, context):
        super().__init__("surroundings", context=context, start_parameter_services=False)
        self.got = {topic: [] for topic in ANALYSIS}
        self.announced = []
        for topic in ANALYSIS:
            kind, qos = RESULTS[topic]
            self.create_subscription(kind, topic, self.got[topic].append, qos)
        self.create_subscription(
            DiagnosticStatus, topics.FLOW_FINISHED, self.announced.append, FLOW
        )
        self._state = self.create_publisher(*self._of(topics.WORM_STATE))
        self._geometry = self.create_publisher(*self._of(topics.CHAMBER_GEOMETRY))
        self._end = self.create_publisher(UInt64, topics.FLOW_END, FLOW)

    def _of(self, topic):
        kind, qos = RESULTS[topic]
        return kind, topic, qos

    def send_state(self, state):
        self._state.publish(convert.body_state_to_msg(state))

    def send_geometry(self):
        self._geometry.publish(convert.geometry_to_msg(GEOMETRY))

    def send_end(self, frames):
        self._end.publish(convert.count_to_msg(frames))


@pytest.fixture
def graph(ros_context):
    """A graph of the node and its surroundings; `settle` runs all that is ready."""
    executor = SingleThreadedExecutor(context=ros_context)
    nodes = Surroundings(ros_context), AnalysisNode(context=ros_context)
    for node in nodes:
        executor.add_node(node)
    yield *nodes, lambda: drain(executor)
    executor.shutdown()
    for node in nodes:
        node.destroy_node()


STATES = slides_and_hops(0, 45.0, 20.0).states()


def core_results():
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    results = [analysis.push(state) for state in STATES]
    events = [event for _, closed in results for event in closed] + analysis.finish()
    return analysis, [observables for observables, _ in results], events


def test_the_node_says_what_the_core_says(graph):
    surroundings, node, settle = graph
    surroundings.send_geometry()
    for state in STATES:
        surroundings.send_state(state)
        settle()
    assert not node.done
    surroundings.send_end(len(STATES))
    settle()
    assert node.done
    assert node.missing == ""
    analysis, observables, events = core_results()
    got = surroundings.got
    rows = [convert.observables_from_msg(msg) for msg in got[topics.ANALYSIS_STATE]]
    assert repr(rows) == repr(observables)
    told = [event for msg in got[topics.ANALYSIS_EVENTS] for event in convert.events_from_msg(msg)]
    assert repr(told) == repr(events)
    summaries = got[topics.ANALYSIS_SUMMARY]
    assert len(summaries) == 5, "every 10 s of stamps, and at the end"
    assert repr(convert.quantities_from_msg(summaries[-1])) == repr(tuple(analysis.summary()))
    last = convert.correlation_from_msg(got[topics.ANALYSIS_CORRELATION][-1])
    assert last.pairs.tolist() == analysis.correlation().pairs.tolist()
    names = [
        convert.distribution_from_msg(msg).name for msg in got[topics.ANALYSIS_DISTRIBUTIONS][-11:]
    ]
    assert names == [item.name for item in analysis.distributions()]


def test_the_estimates_of_all_states_that_wait_fit_into_the_latched_topics(graph):
    """Of a picture in ten seconds, each state by itself would be due to bring estimates."""
    surroundings, node, settle = graph
    held = MOST_HOLD_BACK_FRAMES
    for state in slides_and_hops(0, 51.0, 20.0).states()[:held]:
        surroundings.send_state(replace(state, stamp_ns=state.frame * 10_000_000_000))
    settle()
    surroundings.send_geometry()
    settle()
    surroundings.send_end(held)
    settle()
    assert node.done
    (said,) = (read_announcement(msg) for msg in surroundings.announced)
    distributions = said.sent[topics.ANALYSIS_DISTRIBUTIONS]
    assert 100 < distributions < LATCHED_SET_DEPTH
    assert len(surroundings.got[topics.ANALYSIS_DISTRIBUTIONS]) == distributions
    estimates = said.sent[topics.ANALYSIS_SUMMARY]
    assert 10 < estimates < ESTIMATES_DEPTH
    assert len(surroundings.got[topics.ANALYSIS_SUMMARY]) == estimates


def test_states_wait_for_the_geometry_that_they_rest_on(graph):
    surroundings, node, settle = graph
    surroundings.send_end(len(STATES))
    for state in STATES:
        surroundings.send_state(state)
    settle()
    assert surroundings.got[topics.ANALYSIS_STATE] == []
    assert node.missing == "frame 0 waits for geometry 1"
    surroundings.send_geometry()
    settle()
    _, observables, _ = core_results()
    rows = [convert.observables_from_msg(m) for m in surroundings.got[topics.ANALYSIS_STATE]]
    assert repr(rows) == repr(observables)
    assert node.done


def test_the_announcement_counts_every_message(graph):
    surroundings, _, settle = graph
    surroundings.send_geometry()
    for state in STATES:
        surroundings.send_state(state)
    surroundings.send_end(len(STATES))
    settle()
    (announcement,) = [read_announcement(msg) for msg in surroundings.announced]
    assert announcement == Announcement(
        "analysis", {topic: len(surroundings.got[topic]) for topic in ANALYSIS}, {}
    )


def test_an_empty_trial_ends_too(graph):
    surroundings, node, settle = graph
    surroundings.send_end(0)
    settle()
    assert node.done
    summary = convert.quantities_from_msg(surroundings.got[topics.ANALYSIS_SUMMARY][-1])
    assert all(quantity.value is None and quantity.why for quantity in summary)


def test_parameters_reach_the_core_and_a_bad_one_is_refused(ros_context):
    given = [Parameter("body_width_m", value=3e-4), Parameter("minimum_n", value=5)]
    node = AnalysisNode(context=ros_context, parameter_overrides=given)
    assert node._settings == AnalysisParameters(body_width_m=3e-4, minimum_n=5)
    node.destroy_node()
    bad = [Parameter("max_gap_s", value=-1.0)]
    with pytest.raises(ValueError, match=r"max_gap_s is -1:"):
        AnalysisNode(context=ros_context, parameter_overrides=bad)
