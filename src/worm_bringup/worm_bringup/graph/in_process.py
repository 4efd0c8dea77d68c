"""The graph in one process: publish a frame, run callbacks until none is ready, and so on."""

import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, field

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from threadpoolctl import threadpool_limits

from worm_bringup.checkpoints import Checkpoints
from worm_bringup.freed_memory import keep_freed_memory, lasting_objects_left_alone
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.ros_environment import alone_on_their_names, own_context
from worm_msgs_py.ros.network import Reach
from worm_msgs_py.ros.running import stop_on_signals
from worm_msgs_py.ros.watchdog import PATIENCE_S, Watch, watchdog
from worm_tracker.sources.source_node import SourceNode, drain, spin_source, until_stopped

Progress = Callable[[int, int | None], None]
"""Called with the number of frames that were sent, and of those to come in all where known."""

Beside = Callable[[Mapping[str, str], Mapping[str, int]], AbstractContextManager[None]]
"""Starts what runs beside a graph: called with the environment that leads to it, and how often it
publishes each topic."""


def no_one_beside(
    environment: Mapping[str, str], publishes: Mapping[str, int]
) -> AbstractContextManager[None]:
    """Start nothing."""
    return nullcontext()


@dataclass(frozen=True, slots=True)
class RunResult:
    """How a run of the graph ended.

    Attributes
    ----------
    frames : int
        Frames that the source sent.
    complete : bool
        Whether the source came to its end and every node finished.
    interrupted : bool
        Whether a signal ended it.
    missing : str
        What is not complete, for people; empty where nothing is missing.
    ended_early : str
        Why the source ended before its time; empty where it did not. The results are whole up to
        there.
    earlier : int
        Of these frames, those that an earlier run had sent which this one went on with.
    next_is_asked : bool
        Whether an operator ended the trial to begin the next one.
    no_picture : str
        Why the report opens without a picture of the trial; empty where it has one.
    elapsed_s : float
        From the first frame to the last result.
    spent_s : dict
        Seconds spent in the callbacks of each node; what the source spends on reading and
        publishing is under its own name. Empty where every node has a process of its own.
    counts : dict
        What the source counted, such as frames that were skipped; empty as above.
    """

    frames: int
    complete: bool
    interrupted: bool
    missing: str
    elapsed_s: float
    spent_s: dict[str, float] = field(default_factory=dict)
    counts: dict[str, str] = field(default_factory=dict)
    ended_early: str = ""
    earlier: int = 0
    no_picture: str = ""
    next_is_asked: bool = False


def run_in_process(
    source: NodeSpec,
    nodes: Sequence[NodeSpec],
    progress: Progress | None = None,
    *,
    reach: Reach = Reach.OWN,
    namespace: str = "",
    checkpoints: Checkpoints | None = None,
    patience_s: float = PATIENCE_S,
    beside: Beside = no_one_beside,
) -> RunResult:
    """Run a graph in this process, to the end of its source or to SIGINT or SIGTERM.

    A signal ends an endless source in good order (the result is whole), any other run at once. No
    frame can be lost, however slow the nodes: the next one waits for all that the last one causes.

    Parameters
    ----------
    source : NodeSpec
        Its node is a `SourceNode`; it is made first, so that bad input leaves no output.
    nodes : sequence of NodeSpec
        The others; one with an attribute `done` must be done at the end (`missing` says why not).
    reach : Reach
        Who can see the graph (see `ros_environment.own_context`).
    checkpoints : Checkpoints, optional
        Go on from one, and make them while it runs.
    patience_s : float
        Seconds that a node may take over one message; longer, and it hangs (see `watchdog`).
    progress, beside : callable, optional
        Called after every frame; starts what runs beside the nodes that are made.

    Raises
    ------
    BadInput
        From a node, when it is made or in a callback; or another graph has the names of this one.
    NodeFailed
        A callback did not come back, and was interrupted.
    """
    keep_freed_memory()
    with (
        own_context(reach) as context,
        threadpool_limits(1),  # BLAS threads wait for each other longer than our products take
        ExitStack() as stack,
        stop_on_signals() as stop,
    ):
        executor, made = stack.enter_context(_made((source, *nodes), context, reach, namespace))
        stack.enter_context(beside(os.environ, _published(made)))
        stack.enter_context(lasting_objects_left_alone())
        watch = stack.enter_context(watchdog(patience_s))
        return _run_to_end(executor, made, progress, stop, checkpoints, watch)


def _published(nodes: Sequence[Node]) -> Mapping[str, int]:
    """Return how often nodes publish each topic."""
    return Counter(publisher.topic_name for node in nodes for publisher in node.publishers)


@contextmanager
def _made(
    specs: Sequence[NodeSpec], context: Context, reach: Reach, namespace: str
) -> Iterator[tuple[SingleThreadedExecutor, list[Node]]]:
    with ExitStack() as stack:
        names = [spec.name for spec in specs]
        stack.enter_context(alone_on_their_names(context, reach, namespace, names))
        executor = SingleThreadedExecutor(context=context)
        stack.callback(executor.shutdown)
        nodes: list[Node] = []
        for spec in specs:
            served = reach is not Reach.OWN
            nodes.append(spec.make(context=context, namespace=namespace, served=served))
            stack.callback(nodes[-1].destroy_node)
            executor.add_node(nodes[-1])
        yield executor, nodes


def _run_to_end(
    executor: SingleThreadedExecutor,
    nodes: list[Node],
    progress: Progress | None,
    stop: threading.Event,
    checkpoints: Checkpoints | None,
    watch: Watch,
) -> RunResult:
    source = nodes[0]
    if not isinstance(source, SourceNode):
        raise TypeError(f"{source.get_name()} is not a source of pictures")

    goes_on = until_stopped(source, stop)
    spent_s = {node.get_name(): 0.0 for node in nodes}

    def keep_on() -> bool:
        if progress is not None:
            progress(source.sent, source.expected)
        if checkpoints is not None:
            checkpoints.between_frames()
        return goes_on()

    drain(executor, spent_s, watch)  # what nodes have published as they were made
    if checkpoints is not None:
        checkpoints.begin(nodes, goes_on)
    earlier = source.sent
    began_s = time.perf_counter()
    ended = spin_source(executor, source, keep_on, heed_window=False, spent_s=spent_s, watch=watch)
    drain(executor, spent_s, watch)
    if checkpoints is not None and not ended:
        checkpoints.save()
    keep_on()
    elapsed_s = time.perf_counter() - began_s
    late = [node for node in nodes if not getattr(node, "done", True)]
    missing = "; ".join(
        getattr(node, "missing", f"{node.get_name()} has not ended") for node in late
    )
    return RunResult(
        frames=source.sent,
        earlier=earlier,
        complete=ended and not late,
        interrupted=not ended,
        missing=missing,
        elapsed_s=elapsed_s,
        spent_s=spent_s,
        counts=source.counts(),
        ended_early=source.ended_early,
        next_is_asked=source.next_is_asked and not source.ended_early,
    )
