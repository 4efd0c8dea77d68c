"""Makes checkpoints of a replay while it runs in one process, and sets the graph up from one.

Between two frames the graph is at rest (`graph`): no message is on its way, so the states of the
nodes together are the state of the run. The recorder's is what it was sent: its tables and its bag
are written anew from that, and so need not be mended.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node

from worm_bringup.checkpoints.folder import CheckpointFolder, Manifest
from worm_bringup.freed_memory import give_back_freed_memory
from worm_bringup.recorder.recorder_node import RecorderNode
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.worm_node import WormNode
from worm_tracker.sources.source_node import SourceNode

INTERVAL_S = 10.0
"""Wall-clock time between two checkpoints: what a run that is killed loses at most."""


@dataclass(frozen=True)
class _Graph:
    source: SourceNode
    recorder: RecorderNode
    others: tuple[WormNode, ...]  # all that have a state: the source, and not the recorder


class Checkpoints:
    """The checkpoints of one replay.

    Parameters
    ----------
    folder : CheckpointFolder
        Where they lie.
    fingerprint : mapping
        All that the results depend on (`provenance.fingerprint`); a checkpoint of another run is
        never gone on from.
    resume : bool
        Go on from the checkpoint that is there.
    say : callable
        Takes a line for people.
    interval_s : float
        Wall-clock time between two checkpoints.

    Attributes
    ----------
    saved : Manifest or None
        The last checkpoint that was made or gone on from.
    """

    def __init__(
        self,
        folder: CheckpointFolder,
        fingerprint: Mapping[str, Any],
        *,
        resume: bool = False,
        say: Callable[[str], None] = lambda line: None,
        interval_s: float = INTERVAL_S,
    ):
        self._folder = folder
        self._fingerprint = fingerprint
        self._resume = resume
        self._say = say
        self._interval_s = interval_s
        self._graph: _Graph | None = None
        self._next_s = 0.0
        self.saved: Manifest | None = None

    def begin(self, nodes: Sequence[Node], keep_on: Callable[[], bool]) -> None:
        """Take the nodes of a graph that is at rest, and set them up where that was asked for.

        Parameters
        ----------
        keep_on : callable
            Asked again and again; where it says False the graph is left half set up, which the
            checkpoint outlives.

        Raises
        ------
        BadInput
            The checkpoint is of another run, or cannot be used.
        """
        graph = _graph(nodes)
        if self._resume:
            if not self._restore(graph, keep_on):
                return
        else:
            self._tell_of_another()
        graph.recorder.journal = []
        self._graph = graph
        self._next_s = time.monotonic() + self._interval_s

    def between_frames(self) -> None:
        """Make a checkpoint if it is time; the graph is at rest."""
        if time.monotonic() >= self._next_s:
            self.save()
            self._next_s = time.monotonic() + self._interval_s

    def save(self) -> None:
        """Make a checkpoint now; the graph is at rest.

        Where it cannot be written, that is said and no other is made: the run goes on.
        """
        graph = self._graph
        if graph is None or graph.source.done or not graph.source.sent:
            return
        try:
            self.saved = self._folder.save(
                self._fingerprint,
                frames=graph.source.sent,
                expected=graph.source.expected,
                states={node.get_name(): node.checkpoint() for node in graph.others},
                messages=graph.recorder.journal,
                before=() if self.saved is None else self.saved.messages,
            )
        except (OSError, BadInput) as error:
            self._say(f"no checkpoint can be made any more, the replay goes on: {error}")
            self._graph = graph.recorder.journal = None
            with suppress(OSError, BadInput):
                self._folder.tidy()
        else:
            graph.recorder.journal = []
            give_back_freed_memory()  # what the messages took, and the same packed

    def remove(self) -> None:
        """Remove the checkpoint of this replay, which has come to its end; never one of another."""
        with suppress(OSError, BadInput):
            there = self._folder.manifest()
            if there is None or there.fingerprint == self._fingerprint:
                self._folder.remove()

    def _restore(self, graph: _Graph, keep_on: Callable[[], bool]) -> bool:
        manifest = self._folder.manifest()
        if manifest is None:
            self._say("there is no checkpoint to go on from: the replay starts at the beginning")
            return True
        changed = _difference(manifest.fingerprint, self._fingerprint)
        if changed:
            raise BadInput(
                f"{self._folder.path}: is the checkpoint of another replay ({changed}): give the "
                "bag and the options that it was begun with, or leave out --resume to begin anew"
            )
        self.saved = manifest
        self._say(f"going on after {_so_many(manifest)} frames")
        states = self._folder.states(manifest)
        for journal in self._folder.messages(manifest):
            if not keep_on():
                return False
            graph.recorder.take_again(journal)
        for node in graph.others:
            node.restore(states[node.get_name()])
        return True

    def _tell_of_another(self) -> None:
        there = None
        with suppress(BadInput):  # what cannot be used is told where it is asked for
            there = self._folder.manifest()
        if there is not None:
            self._say(
                f"a replay into this directory was stopped after {_so_many(there)} frames; "
                f"--resume would go on with it, this one begins anew ({self._folder.path})"
            )


def progress_of(manifest: Manifest) -> str:
    """Return how far a stopped replay has come, for people."""
    return f"stopped after {_so_many(manifest)} frames"


def _so_many(manifest: Manifest) -> str:
    whole = "" if manifest.expected is None else f" of {manifest.expected}"
    return f"{manifest.frames}{whole}"


def _graph(nodes: Sequence[Node]) -> _Graph:
    source, *others = nodes
    (recorder,) = [node for node in others if isinstance(node, RecorderNode)]
    if not isinstance(source, SourceNode):
        raise TypeError(f"{source.get_name()} is not a source of pictures")
    states = [node for node in nodes if isinstance(node, WormNode) and node.STATE]
    return _Graph(source, recorder, tuple(states))


def _difference(before: Any, now: Any, name: str = "") -> str:
    """Return the first thing that differs between two fingerprints, empty where nothing does."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        for key in sorted({*before, *now}):
            inner = _difference(before.get(key), now.get(key), f"{name}.{key}".lstrip("."))
            if inner:
                return inner
        return ""
    return "" if before == now else f"{name} was {before}, and is {now}"
