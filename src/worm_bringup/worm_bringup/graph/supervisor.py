"""The graph with a process for each node, fed through a window of acknowledged frames."""

import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from worm_bringup.graph.in_process import Beside, Progress, RunResult, no_one_beside
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.ros_environment import free_domain
from worm_msgs_py.errors import BadInput, NodeFailed
from worm_msgs_py.ros.claims import claim, full_name
from worm_msgs_py.ros.network import Reach, dds_settings
from worm_msgs_py.ros.running import TICK_S, stop_on_signals
from worm_msgs_py.ros.watchdog import PATIENCE_S

_END_S = 0.5
"""What a process is given to end by itself, and then again to heed SIGTERM."""
_FINISH_S = 10.0
"""The same where a camera has a record to close."""
_WHOLE_END_S = 30.0
"""The same where the run is complete: files may still be written."""
_SHARED_MEMORY = "/dev/shm/fastrtps_"

Inbox = queue.Queue[tuple["NodeProcess", dict[str, Any] | None]]


class NodeProcess:
    """One child: its process, what it has said, and its shared memory."""

    def __init__(
        self,
        spec: NodeSpec,
        namespace: str,
        environment: dict[str, str],
        inbox: Inbox,
    ) -> None:
        self.name = spec.name
        # -P: what lies in the working directory is not imported.
        command = [sys.executable, "-P", "-m", "worm_bringup.graph.child_process"]
        # A session of its own: Ctrl-C in the terminal reaches the parent alone, which tells it.
        self.process = subprocess.Popen(
            [*command, spec.module, spec.name, namespace],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            start_new_session=True,
            env=environment,
        )
        self.endpoints: dict[str, dict[str, int]] | None = None
        self.finite = True  # says when it is done
        self.endless = False  # a source that a signal ends in good order
        self.matched = False
        self.done = False
        self.late = ""
        self.silent_s = 0.0
        self.hangs = False
        self.segments: set[str] = set()
        self.say(parameters=spec.to_yaml())  # not by a file: an address may hold a password
        self._reader = threading.Thread(target=self._listen, args=(inbox,), daemon=True)
        self._reader.start()

    def _listen(self, inbox: Inbox) -> None:
        if self.process.stdout is not None:
            for line in self.process.stdout:
                inbox.put((self, json.loads(line)))
        inbox.put((self, None))

    def say(self, **message: Any) -> None:
        """Tell the child, if it is still there."""
        with suppress(OSError, ValueError):
            if self.process.stdin is not None:
                print(json.dumps(message), file=self.process.stdin, flush=True)

    def note_shared_memory(self) -> None:
        """Take note of the shared memory that the process uses, in case it cannot tidy up."""
        with suppress(OSError):
            maps = Path(f"/proc/{self.process.pid}/maps").read_text(encoding="utf-8")
            paths = (line.split(maxsplit=5)[-1] for line in maps.splitlines())
            self.segments |= {path for path in paths if path.startswith(_SHARED_MEMORY)}

    def close(self) -> None:
        """Close the pipes of a process that has ended."""
        self._reader.join()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()


def run_in_processes(
    source: NodeSpec,
    nodes: Sequence[NodeSpec],
    progress: Progress | None = None,
    *,
    namespace: str = "",
    patience_s: float = PATIENCE_S,
    beside: Beside = no_one_beside,
) -> RunResult:
    """Run a graph with a process for each node, to the end of its source or to a signal.

    The graph has a ROS domain of its own and does not leave this machine. The first frame goes out
    when each node has found all others; then the source keeps to its window (see `SourceNode`).
    The run is complete when every node that has an attribute `done` says so.

    Parameters
    ----------
    source, nodes, progress, patience_s, beside
        As for `graph.run_in_process`.

    Raises
    ------
    BadInput
        A node refused its input; the others were ended.
    NodeFailed
        A node failed, found no peer or hangs (its traceback is on stderr). The others were ended,
        a camera in good order: its record is whole.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="worm-graph-")))
        domain = stack.enter_context(free_domain())
        names = [full_name(namespace, spec.name) for spec in (source, *nodes)]
        stack.enter_context(claim(domain, names))
        environment = {
            **os.environ,
            "ROS_LOG_DIR": os.environ.get("ROS_LOG_DIR", str(folder)),
            **dds_settings(Reach.MACHINE),
            "ROS_DOMAIN_ID": str(domain),
        }
        stop = stack.enter_context(stop_on_signals())
        stack.enter_context(beside(environment, {}))
        family = Family(stop, progress, patience_s)
        stack.callback(family.end)
        for spec in (source, *nodes):
            child = NodeProcess(spec, namespace, environment, family.inbox)
            family.children.append(child)
        return family.run()


class Family:
    """The parent's view of its children."""

    def __init__(self, stop: threading.Event, progress: Progress | None, patience_s: float) -> None:
        self._patience_s = patience_s
        self.children: list[NodeProcess] = []
        self.inbox: Inbox = queue.Queue()
        self._stop = stop
        self._progress = progress
        self._sent = 0
        self._expected: int | None = None
        self._ended_early = ""
        self._live = False
        self._looked_s = time.monotonic()
        self._ending = False

    def run(self) -> RunResult:
        """See the children through from the first word to the last."""
        began_s = time.perf_counter()
        if self._until(lambda: all(child.endpoints for child in self.children)):
            for child in self.children:
                child.say(peers=self._all_endpoints())
        if self._until(lambda: all(child.matched for child in self.children)):
            for child in self.children:
                child.note_shared_memory()
                child.say(go=True)
            began_s = time.perf_counter()
        whole = self._until(self._all_done)
        elapsed_s = time.perf_counter() - began_s
        self.end(_WHOLE_END_S if whole else None)
        return RunResult(
            frames=self._sent,
            complete=whole,
            interrupted=not whole,
            missing="; ".join(child.late for child in self.children if child.late),
            elapsed_s=elapsed_s,
            ended_early=self._ended_early,
        )

    def _all_done(self) -> bool:
        return all(child.done for child in self.children if child.finite)

    def _all_endpoints(self) -> dict[str, dict[str, int]]:
        return {
            way: dict(
                sum((Counter((child.endpoints or {})[way]) for child in self.children), Counter())
            )
            for way in ("publishes", "subscribes")
        }

    def _until(self, reached: Callable[[], bool]) -> bool:
        """Hear the children until something is reached, or a signal comes; say which."""
        while not reached():
            if self._stop.is_set() and not self._finish_endless():
                return False
            with suppress(queue.Empty):
                self._hear(*self.inbox.get(timeout=TICK_S))
            self._look_for_hanging()
        return True

    def _look_for_hanging(self) -> None:
        """End the run where a child's callback does not come back; it says where it hangs."""
        # Only what this process saw pass: one that was stopped itself has heard nobody meanwhile.
        passed_s = min(time.monotonic() - self._looked_s, 1.0)
        self._looked_s = time.monotonic()
        for child in self.children:
            child.silent_s += passed_s
            if child.endpoints is not None and child.silent_s > self._patience_s:
                child.hangs = True
                child.process.send_signal(signal.SIGUSR1)  # it says where
                child.process.send_signal(signal.SIGCONT)
                with suppress(subprocess.TimeoutExpired):
                    child.process.wait(_END_S)
                child.process.kill()
                raise NodeFailed(
                    f"node {child.name} hangs: it has not answered for {child.silent_s:.0f} s"
                )

    def _finish_endless(self) -> bool:
        """Let an endless source end in good order at the first signal; say whether there is one."""
        endless = [child for child in self.children if child.endless and child.matched]
        for child in endless:
            child.endless = False
            child.say(finish=True)
        if endless:
            self._stop.clear()
        return bool(endless)

    def _hear(self, child: NodeProcess, message: dict[str, Any] | None) -> None:
        child.silent_s = 0.0
        if message is None:
            if not self._ending and not child.hangs:
                status = child.process.wait()
                raise NodeFailed(f"node {child.name} ended with status {status} before the end")
            return
        if "error" in message:
            raise BadInput(message["error"])
        child.endpoints = message.get("ready", child.endpoints)
        child.finite = message.get("finite", child.finite)
        child.endless = message.get("endless", child.endless)
        self._live = self._live or child.endless
        child.matched = child.matched or "matched" in message
        child.done = child.done or "done" in message
        child.late = message.get("late", child.late)
        self._ended_early = message.get("ended_early", self._ended_early)
        if "progress" in message:
            self._sent, self._expected = message["progress"]
            if self._progress is not None:
                self._progress(self._sent, self._expected)

    def end(self, patience_s: float | None = None) -> None:
        """End every child (see `end_processes`), once."""
        if self._ending:
            return
        self._ending = True
        if patience_s is None:
            patience_s = _FINISH_S if self._live else _END_S
        end_processes(self.children, patience_s)
        while not self.inbox.empty():
            with suppress(BadInput):
                self._hear(*self.inbox.get_nowait())


def end_processes(children: Sequence[NodeProcess], patience_s: float) -> None:
    """End every child: by word, by SIGTERM, by SIGKILL; leave nothing in shared memory.

    Parameters
    ----------
    patience_s : float
        What they are given to end by themselves.
    """
    for child in children:
        child.note_shared_memory()
        child.say(end=True)
    for measure in (lambda _: None, subprocess.Popen.terminate, subprocess.Popen.kill):
        alive = [child for child in children if child.process.poll() is None]
        for child in alive:
            measure(child.process)
        deadline_s = time.monotonic() + patience_s
        for child in alive:
            with suppress(subprocess.TimeoutExpired):
                child.process.wait(max(0.0, deadline_s - time.monotonic()))
        patience_s = _END_S
    for child in children:
        child.close()
    _tidy_shared_memory(set().union(*(child.segments for child in children)))


def _tidy_shared_memory(segments: set[str]) -> None:
    """Remove the shared memory, and its locks, that a process which was killed has left.

    Fast DDS shares some of it over all domains, so what another process still maps stays.
    """
    left = {segment for segment in segments if Path(segment).exists()}
    left |= {segment for segment in segments if Path(f"{segment}_el").exists()}
    left |= {segment for segment in segments if _mutex(segment).exists()}
    if not left:
        return
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):
            text = maps.read_text(encoding="utf-8")
            left -= {segment for segment in left if segment in text}
    for segment in left:
        for file in (Path(segment), Path(f"{segment}_el"), _mutex(segment)):
            file.unlink(missing_ok=True)


def _mutex(segment: str) -> Path:
    return Path(segment).with_name(f"sem.{Path(segment).name}_mutex")
