"""One trial from pictures to a report: which nodes, with which parameters, into which directory."""

import json
import signal
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from worm_analysis.parameters import AnalysisParameters
from worm_analysis.report import write_report
from worm_bringup.checkpoints import Checkpoints
from worm_bringup.graph.in_process import Progress, RunResult, run_in_process
from worm_bringup.graph.monitor_process import Monitor
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.ros_environment import free_domain
from worm_bringup.graph.supervisor import run_in_processes
from worm_bringup.outputs.earlier_result import TRIAL
from worm_bringup.outputs.results_directory import (
    report_afterwards,
    results_directory,
    without_report,
)
from worm_bringup.provenance import fingerprint, provenance
from worm_bringup.trial_picture import keep_picture
from worm_model.inference.comparison import ModelParameters
from worm_msgs_py.files.corrections import CORRECTIONS, Correction, corrections_to_json
from worm_msgs_py.ros.network import Reach, environment
from worm_msgs_py.ros.running import Stop, finish_despite_signals, stop_on_signals
from worm_msgs_py.ros.watchdog import PATIENCE_S
from worm_tracker.parameters import TrackerParameters

REPORT_S = 1.0
"""What a report that is being drawn is given after a signal; the results are whole without it."""
_CHANGES_NO_RESULT = ("bag", "rate", "seek_to", "start_paused", "window")
"""Parameters of the player; the bag's content stands in the origin."""


class Incomplete(RuntimeError):  # noqa: N818 (it is what the result is)
    """A run ended before its results were whole; nothing was left behind."""

    def __init__(self, result: RunResult):
        why = result.missing or result.ended_early
        super().__init__(why or "the run did not come to its end")
        self.result = result


class EndedEarly(RuntimeError):  # noqa: N818
    """The source ended before its time; the results are whole up to there, and kept."""


class WithoutPose(RuntimeError):  # noqa: N818
    """Not one frame has a pose; the results, which say why, are kept."""


@dataclass(frozen=True)
class Trial:
    """What is to be run.

    Attributes
    ----------
    source : NodeSpec
        The node that sends the pictures.
    origin : mapping
        What the pictures come from, for the results (name, hash).
    tracker, analysis, model : mapping
        Parameters that differ from their defaults.
    metadata : mapping
        What the lab has noted of the trial, as parameters of the recorder.
    namespace : str
        ROS namespace of all nodes, such as ``/rig1``.
    with_pictures : bool
        Whether the results' bag holds the pictures of the bag that is played, too.
    viewers : tuple of NodeSpec
        Nodes that only look.
    corrections : tuple of Correction
        Where people have set right which end is the head.
    """

    source: NodeSpec
    origin: Mapping[str, Any]
    tracker: Mapping[str, Any] = field(default_factory=dict)
    analysis: Mapping[str, Any] = field(default_factory=dict)
    model: Mapping[str, Any] = field(default_factory=dict)
    metadata: Mapping[str, Any] = field(default_factory=dict)
    namespace: str = ""
    with_pictures: bool = False
    viewers: tuple[NodeSpec, ...] = ()
    corrections: tuple[Correction, ...] = ()

    def nodes(self, out: Path | None) -> list[NodeSpec]:
        """Return all nodes but the source; the recorder where there is something to write to."""
        told = {CORRECTIONS.name: self._corrections} if self.corrections else {}
        nodes = [
            NodeSpec("worm_tracker.tracker_node", "tracker", {**self.tracker, **told}),
            NodeSpec("worm_analysis.analysis_node", "analysis", self.analysis),
            NodeSpec("worm_model.model_node", "model", self.model),
            *self.viewers,
        ]
        if out is not None:
            provenance = json.dumps(self._provenance())
            parameters = {**self.metadata, **told, "out": str(out), "provenance": provenance}
            if self.with_pictures:
                parameters["pictures"] = json.dumps(self.source.parameters)
            nodes.append(NodeSpec("worm_bringup.recorder.recorder_node", "recorder", parameters))
        return nodes

    @property
    def fingerprint(self) -> Any:
        """All that the bytes of the results depend on."""
        player = {k: v for k, v in self.source.parameters.items() if k not in _CHANGES_NO_RESULT}
        return fingerprint(
            self.origin,
            self.parameters
            | {"player": player, "trial": dict(self.metadata)}
            | ({CORRECTIONS.name: {"text": self._corrections}} if self.corrections else {}),
        )

    @property
    def _corrections(self) -> str:
        return corrections_to_json(self.corrections)

    def _provenance(self) -> Any:
        return provenance(self.origin, self.parameters)

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """Every parameter of tracker, analysis and model, by node."""
        return {
            "tracker": asdict(TrackerParameters(**self.tracker)),
            "analysis": asdict(AnalysisParameters(**self.analysis)),
            "model": asdict(ModelParameters(**self.model)),
        }


def run_graph(
    trial: Trial,
    out: Path | None,
    progress: Progress | None = None,
    *,
    processes: bool = False,
    reach: Reach = Reach.OWN,
    checkpoints: Checkpoints | None = None,
    patience_s: float = PATIENCE_S,
    monitor: Monitor | None = None,
) -> RunResult:
    """Run a trial's graph, recording into the empty directory `out` where there is one.

    Parameters
    ----------
    processes : bool
        Give each node a process of its own; such a graph keeps to itself.
    reach : Reach
        Who can see the graph.
    checkpoints : Checkpoints, optional
        Go on from one, and make them while the graph runs; not with `processes`.
    patience_s : float
        Seconds that a node may take over one message; longer, and it hangs: the run ends.
    monitor : Monitor, optional
        The page that shows the trial; a graph that keeps to itself gets a domain of its own.

    Raises
    ------
    BadInput
        The input cannot be used.
    """
    nodes = trial.nodes(out)
    how: dict[str, Any] = {"namespace": trial.namespace, "patience_s": patience_s}
    with ExitStack() as stack:
        if monitor is not None:
            how["beside"] = partial(monitor.beside, namespace=trial.namespace)
        if processes:
            return run_in_processes(trial.source, nodes, progress, **how)
        if monitor is not None and reach is Reach.OWN:  # it hears the graph from outside
            domain = stack.enter_context(free_domain())
            stack.enter_context(environment(ROS_DOMAIN_ID=str(domain)))
            reach = Reach.MACHINE
        return run_in_process(
            trial.source, nodes, progress, reach=reach, checkpoints=checkpoints, **how
        )


def next_trial(first: Trial, out: Path | None) -> tuple[Trial, Path | None]:
    """Return the next of a row of live trials, and where its results go: nothing is written over.

    Parameters
    ----------
    first : Trial
        The first of them; results and record of the others have a number that neither has yet.
    out : Path, optional
        Its results: the next are OUT-2.
    """
    record = first.source.parameters.get("record")
    kept = [Path(path) for path in (out, record) if path]
    number = next(k for k in count(2) if not any(_numbered(path, k).exists() for path in kept))
    source = first.source
    if record:
        into = str(_numbered(Path(record), number))
        source = replace(source, parameters={**source.parameters, "record": into})
    return replace(first, source=source), None if out is None else _numbered(out, number)


def _numbered(path: Path, number: int) -> Path:
    return path.with_name(f"{path.name}-{number}")


def _with_pictures(trial: Trial, directory: Path) -> Trial:
    """Return a live trial that keeps some of its pictures for the report, if it records none."""
    source = trial.source
    if source.parameters.get("record"):
        return trial
    parameters = {**source.parameters, "pictures": str(directory)}
    return replace(trial, source=replace(source, parameters=parameters))


def _report_afterwards(out: Path, stop: Stop) -> Path:
    """Write the report of results in place; not for a machine's signal, which waits for nobody."""
    if stop.number != signal.SIGINT:
        raise without_report(out, KeyboardInterrupt())
    with report_afterwards(out) as place, finish_despite_signals(told=True):
        return write_report(place)


def run_trial(
    trial: Trial,
    out: Path,
    progress: Progress | None = None,
    *,
    live: bool = False,
    checkpoints: Checkpoints | None = None,
    **how: Any,
) -> tuple[RunResult, Path]:
    """Run a trial and write its results, whole or not at all.

    Parameters
    ----------
    out : Path
        The results directory to make; an earlier result there is replaced.
    live : bool
        Whether the pictures cannot be had a second time.
    progress, checkpoints, **how
        As for `run_graph`.

    Returns
    -------
    RunResult, Path
        How the run went, and the report.

    Raises
    ------
    Incomplete
        A signal ended the run, a node did not finish, or not one frame has come.
    Kept
        The results are whole, but not in `out` or without a report.
    """
    kind = replace(TRIAL, corrections=trial.corrections)
    with stop_on_signals() as stop:
        with results_directory(out, kind, live=live) as partial:
            kept = _with_pictures(trial, partial) if live else trial
            result = run_graph(kept, partial, progress, checkpoints=checkpoints, **how)
            if not result.complete or result.frames == 0:
                raise Incomplete(result)
            told = stop.number is not None
            with finish_despite_signals(REPORT_S, told=told):
                why = keep_picture(partial, trial.source.parameters)
                if not told:
                    report = write_report(partial)
        if told:
            report = _report_afterwards(out, stop)
    if checkpoints is not None:
        checkpoints.remove()
    goes_on = result.next_is_asked and stop.number is None
    return replace(result, no_picture=why, next_is_asked=goes_on), out / report.name
