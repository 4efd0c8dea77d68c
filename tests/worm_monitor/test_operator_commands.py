"""What an operator asks for on the page is done by the nodes, and what became of it is told."""

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

from worm_monitor.operator_commands import LONGEST_NOTE, OperatorCommands
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.ros.worm_node import WormNode


class Recorder(WormNode):
    PARAMETERS = (Declaration("notes", "", "Anything.", changes=True),)
    refuses = ""

    def why_no_change(self, _):
        return self.refuses


class Source(WormNode):
    PARAMETERS = (
        Declaration("rate", 0.0, "Anything.", changes=True),
        Declaration("seek_to", -1.0, "Anything.", changes=True),
    )

    def why_no_change(self, parameter):
        return "it goes forward" if parameter.value < self.read_parameter(parameter.name) else ""


class Graph:
    """The nodes that answer, and an operator before them."""

    def __init__(self, context, *, replay):
        make = {"context": context}
        self.recorder = Recorder("recorder", **make)
        self.tracker, self.source = Node("tracker", **make), Source("image_source", **make)
        self.paused, self.going, self.swaps, self.remarks = False, "playing", 0, []
        self.tracker.create_service(Trigger, "~/swap_head", self._swap)
        for name, paused in (("pause", True), ("resume", False), ("is_paused", None)):
            self.source.create_service(Trigger, f"~/{name}", self._player(paused))
        self.page = Node("monitor", **make)
        self.commands = OperatorCommands(self.page, self.remarks.append, replay=replay)
        self.executor = SingleThreadedExecutor(context=context)
        self.nodes = (self.recorder, self.tracker, self.source, self.page)
        for node in self.nodes:
            self.executor.add_node(node)

    def _swap(self, _, answer):
        self.swaps += 1
        answer.success, answer.message = self.swaps == 1, "no worm has been seen yet"
        return answer

    def _player(self, pauses):
        def answer(_, response):
            self.paused = self.paused if pauses is None else pauses
            response.success = self.paused if pauses is None else True
            response.message = "paused" if self.paused else self.going
            return response

        return answer

    def until(self, true):
        for _ in range(500):
            if true():
                return
            self.executor.spin_once(timeout_sec=0.02)
        raise AssertionError(self.remarks)

    def ask(self, what, value=None):
        self.commands.obey({"do": what, "value": value})

    @property
    def notes(self):
        return self.recorder.read_parameter("notes")


@pytest.fixture
def graph(ros_context):
    yield from running(ros_context, replay=False)


@pytest.fixture
def replayed(ros_context):
    yield from running(ros_context, replay=True)


def running(context, *, replay):
    made = Graph(context, replay=replay)
    made.until(lambda: made.commands.offers()["can_swap"])
    yield made
    made.executor.shutdown()
    for node in made.nodes:
        node.destroy_node()


def test_notes_are_added_to_those_there_are(graph):
    assert graph.commands.offers()["can_note"]
    graph.ask("note", "  1.0 s:\n light  on ")
    graph.until(lambda: graph.notes)
    graph.ask("note", "2.0 s: light off" + LONGEST_NOTE * "!")
    graph.until(lambda: "off" in graph.notes)
    first, second = graph.notes.splitlines()
    assert first == "1.0 s: light on"
    assert len(second) == LONGEST_NOTE
    graph.until(lambda: len(graph.remarks) == 2)
    assert graph.remarks[0] == "noted: 1.0 s: light on"


def test_a_note_that_is_refused_is_not_said_to_be_noted(graph):
    graph.recorder.refuses = "the trial has ended"
    graph.ask("note", "too late")
    graph.until(lambda: graph.remarks)
    assert graph.remarks == ["refused: the trial has ended"]
    assert graph.notes == ""


def test_head_and_tail_are_swapped_and_a_refusal_is_told(graph):
    graph.ask("swap_head")
    graph.until(lambda: graph.swaps == 1)
    graph.ask("swap_head")
    graph.until(lambda: graph.remarks)
    assert graph.remarks == ["swap head: no worm has been seen yet"]


def test_a_player_is_paused_and_the_page_knows(replayed):
    replayed.until(lambda: replayed.commands.offers()["paused"] is False)
    assert not replayed.commands.offers()["can_note"]
    replayed.ask("pause")
    replayed.until(lambda: replayed.commands.offers()["paused"])
    replayed.ask("resume")
    replayed.until(lambda: not replayed.commands.offers()["paused"])


def test_a_seek_is_asked_for_and_followed_until_the_player_pauses(replayed):
    replayed.going = "seeking"
    replayed.ask("seek", 30)
    replayed.until(lambda: replayed.commands.offers()["seeking"])
    assert replayed.source.read_parameter("seek_to") == 30.0
    replayed.paused = True  # it is there
    replayed.until(lambda: replayed.commands.offers()["paused"])
    assert not replayed.commands.offers()["seeking"]
    assert replayed.remarks == []
    replayed.ask("seek", 20)
    replayed.until(lambda: replayed.remarks)
    assert replayed.remarks == ["refused: it goes forward"]
    assert not replayed.commands.offers()["seeking"]


@pytest.mark.parametrize(
    "asked",
    [{}, {"do": "rm"}, {"do": ["pause"]}, {"do": "rate", "value": "x"}, {"do": "rate", "value": -1},
     {"do": "rate", "value": 1e9}, {"do": "seek", "value": "x"}, {"do": "seek", "value": -1},
     {"do": "note"}, {"do": "note", "value": " "},
     {"do": "note", "value": 3}],
    ids=str,
)  # fmt: skip
def test_what_makes_no_sense_is_passed_over(graph, asked):
    graph.commands.obey(asked)
    assert graph.remarks == []


def test_where_nobody_answers_it_is_said(graph):
    graph.ask("play_next")
    assert graph.remarks == ["play next: nobody answers"]
