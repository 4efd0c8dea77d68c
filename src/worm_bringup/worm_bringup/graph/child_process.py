"""One node of the graph in a process of its own, led by the process that started it.

The two talk in lines of JSON over the child's standard input and output:

from the child
    ``{"ready": {"publishes": {topic: n}, "subscribes": {topic: n}}, "finite": bool,
    "endless": bool, "address": "where its page is, if it has one"}``,
    ``{"matched": true}``, ``{"progress": [sent, expected]}``, ``{"done": true}``,
    ``{"late": "what is missing"}``, ``{"ended_early": "why"}``, ``{"error": line}``,
    ``{"alive": true}`` (once a second, or it hangs)
from the parent
    ``{"parameters": "YAML of a ROS parameter file"}`` (the first line),
    ``{"peers": {"publishes": ..., "subscribes": ...}}``, ``{"go": true}``,
    ``{"finish": true}`` (an endless source), ``{"end": true}``

An end of file from the parent ends the child, so nothing outlives a parent that was killed.
"""

import faulthandler
import json
import os
import signal
import sys
import threading
import time
from collections import Counter
from typing import Any, TextIO

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from threadpoolctl import threadpool_limits

from worm_bringup.freed_memory import keep_freed_memory, lasting_objects_left_alone
from worm_bringup.graph.node_spec import NodeSpec
from worm_msgs_py.errors import BAD_INPUT, BadInput
from worm_msgs_py.ros.running import TICK_S
from worm_tracker.sources.source_node import SourceNode, drain, spin_source, until_stopped

MATCH_TIMEOUT_S = 20.0
_HOUSEKEEPING = ("/rosout", "/parameter_events", "/diagnostics")
_PROGRESS_EVERY_S = 0.1
_ALIVE_EVERY_S = 1.0


class ParentPipes:
    """The child's end of the two pipes."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self.peers: dict[str, dict[str, int]] | None = None
        self.may_go = False
        self.must_finish = threading.Event()
        self.must_end = threading.Event()
        self._alive_s = -float("inf")

    def say(self, **message: Any) -> None:
        """Tell the parent; where it is gone, end."""
        try:
            print(json.dumps(message), file=self._out, flush=True)
        except OSError:
            self.must_end.set()

    def beat(self) -> None:
        """Tell the parent, once a second, that callbacks come back."""
        now_s = time.monotonic()
        if now_s - self._alive_s > _ALIVE_EVERY_S:
            self._alive_s = now_s
            self.say(alive=True)

    def listen(self, wake: Any) -> None:
        """Take in what the parent says until it hangs up (in a thread of its own)."""
        for line in sys.stdin:
            message = json.loads(line)
            self.peers = message.get("peers", self.peers)
            self.may_go = self.may_go or "go" in message
            if "finish" in message:
                self.must_finish.set()
            if "end" in message:
                break
            wake()
        self.must_end.set()
        wake()


def endpoints(node: Node) -> dict[str, dict[str, int]]:
    """Return how often a node publishes and subscribes each topic of the graph."""
    return {
        "publishes": _count(publisher.topic_name for publisher in node.publishers),
        "subscribes": _count(subscription.topic_name for subscription in node.subscriptions),
    }


def _count(names: Any) -> dict[str, int]:
    return dict(Counter(name for name in names if name not in _HOUSEKEEPING))


def unmatched(node: Node, peers: dict[str, dict[str, int]]) -> list[str]:
    """Return the topics on which the node does not yet see every peer."""
    waiting = [
        publisher.topic_name
        for publisher in node.publishers
        if publisher.get_subscription_count() < peers["subscribes"].get(publisher.topic_name, 0)
    ]
    waiting += [
        subscription.topic_name
        for subscription in node.subscriptions
        if subscription.get_publisher_count() < peers["publishes"].get(subscription.topic_name, 0)
    ]
    return sorted(set(waiting))


def _meet(executor: SingleThreadedExecutor, node: Node, parent: ParentPipes) -> None:
    """Wait until every peer is connected, so that not even the first frame is lost."""
    parent.say(
        ready=endpoints(node),
        finite=hasattr(node, "done"),
        endless=getattr(node, "endless", False),
        address=getattr(node, "address", ""),
    )
    deadline_s = time.monotonic() + MATCH_TIMEOUT_S
    said = False
    while not parent.may_go and not parent.must_end.is_set():
        executor.spin_once(timeout_sec=TICK_S / 10)
        parent.beat()
        if parent.peers is None or said:
            continue
        waiting = unmatched(node, parent.peers)
        if not waiting:
            parent.say(matched=True)
            said = True
        elif time.monotonic() > deadline_s:
            raise RuntimeError(
                f"node {node.get_name()} found no peer on {', '.join(waiting)} within "
                f"{MATCH_TIMEOUT_S:.0f} s; do their qualities of service agree?"
            )


def _work(executor: SingleThreadedExecutor, node: Node, parent: ParentPipes) -> None:
    """Run the node until the parent says that all is done."""
    said_s = 0.0
    goes_on = until_stopped(node, parent.must_finish) if isinstance(node, SourceNode) else None

    def keep_on() -> bool:
        nonlocal said_s
        parent.beat()
        if goes_on is not None:
            goes_on()
        if time.monotonic() - said_s > _PROGRESS_EVERY_S:
            said_s = time.monotonic()
            parent.say(progress=[node.sent, node.expected])
        return not parent.must_end.is_set()

    if isinstance(node, SourceNode):
        spin_source(executor, node, keep_on, heed_window=True)
        parent.say(progress=[node.sent, node.expected], ended_early=node.ended_early)
    done, pause_s = False, getattr(node, "pause_s", 0.0)
    while not parent.must_end.is_set():
        parent.beat()
        if not done and getattr(node, "done", False):
            parent.say(done=True)
            done = True
        if pause_s:
            parent.must_end.wait(pause_s)
            drain(executor)
        else:
            executor.spin_once(timeout_sec=TICK_S)
    if not getattr(node, "done", True):
        parent.say(late=getattr(node, "missing", "") or f"{node.get_name()} has not ended")


def run(spec: NodeSpec, namespace: str, parent: ParentPipes) -> int:
    """Make the node, meet the others, work, end; return the exit status."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = spec.make(namespace=namespace)
        try:
            executor = SingleThreadedExecutor()
            executor.add_node(node)
            threading.Thread(target=parent.listen, args=(executor.wake,), daemon=True).start()
            _meet(executor, node, parent)
            with lasting_objects_left_alone():
                _work(executor, node, parent)
        finally:
            node.destroy_node()
    except BadInput as error:
        parent.say(error=str(error))
        return BAD_INPUT
    finally:
        rclpy.try_shutdown()
    return 0


def main() -> int:
    """Run ``python -m worm_bringup.graph.child_process MODULE NAME NAMESPACE``."""
    module, name, namespace = sys.argv[1:]
    # Standard output belongs to the parent: what a library prints goes to standard error.
    parent = ParentPipes(os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8"))
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    faulthandler.register(signal.SIGUSR1)  # a hanging node says where it hangs
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: parent.must_end.set())
    keep_freed_memory()
    threadpool_limits(1)  # as in one process: see graph.run_in_process
    first = sys.stdin.readline()
    if not first:  # the parent is gone
        return 1
    return run(NodeSpec.from_yaml(module, name, json.loads(first)["parameters"]), namespace, parent)


if __name__ == "__main__":
    sys.exit(main())
