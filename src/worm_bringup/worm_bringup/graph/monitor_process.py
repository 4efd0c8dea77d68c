"""The monitor beside a graph: a process of its own, whose end or silence ends nothing else."""

import queue
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import Inbox, NodeProcess, end_processes
from worm_msgs_py.errors import BadInput, NodeFailed

_START_S = 30.0
_MONITOR_END_S = 2.0


@dataclass(frozen=True)
class Monitor:
    """How a trial is shown.

    Attributes
    ----------
    parameters : mapping
        Of the monitor's node.
    say : callable
        Takes a line for people: the page's address, once it can be looked at.
    place : dict
        Port and token that the page has had: who looks finds the next trial there.
    """

    parameters: Mapping[str, Any]
    say: Callable[[str], None]
    place: dict[str, Any] = field(default_factory=dict)

    @contextmanager
    def beside(
        self, environment: Mapping[str, str], publishes: Mapping[str, int], *, namespace: str
    ) -> Iterator[None]:
        """Show the graph that this environment leads to, for as long as the block runs.

        Parameters
        ----------
        environment : mapping
            Environment variables.
        publishes : mapping
            How often the graph publishes each topic; the first messages wait for these to be heard.
        namespace : str
            Of the graph.

        Raises
        ------
        BadInput
            The page cannot be served as it is asked for.
        NodeFailed
            The process ended before the page could be looked at.
        """
        spec = NodeSpec("worm_monitor.monitor_node", "monitor", {**self.parameters, **self.place})
        inbox: Inbox = queue.Queue()
        child = NodeProcess(spec, namespace, dict(environment), inbox)
        ending = threading.Event()
        try:
            address = _await("ready", inbox, _START_S)["address"]
            at = urlsplit(address)
            self.place.update(port=at.port, token=at.path.strip("/"))
            child.say(peers={"publishes": publishes, "subscribes": {}})
            _await("matched", inbox, _START_S)
            child.note_shared_memory()
            child.say(go=True)
            self.say(f"Monitor: {address}")
            threading.Thread(target=_hear, args=(inbox, ending, self.say), daemon=True).start()
            yield
        finally:
            ending.set()
            end_processes([child], _MONITOR_END_S)


def _await(word: str, inbox: Inbox, patience_s: float) -> dict[str, Any]:
    """Return the first message of the process that has a word."""
    while True:
        try:
            _, message = inbox.get(timeout=patience_s)
        except queue.Empty:
            raise NodeFailed(f"the monitor has not started within {patience_s:.0f} s") from None
        if message is None:
            raise NodeFailed("the monitor ended before it could be looked at")
        if "error" in message:
            raise BadInput(message["error"])
        if word in message:
            return message


def _hear(inbox: Inbox, ending: threading.Event, say: Callable[[str], None]) -> None:
    """Take what the process says until it ends; say so where that was too soon."""
    while inbox.get()[1] is not None:
        pass
    if not ending.is_set():
        say("The monitor has ended; the trial goes on.")
