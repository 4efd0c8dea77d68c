"""What `worm model compare` says: trials, and pools of them by W, beside the exact walk."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from pathlib import Path

import numpy as np

from worm_analysis.pooling import Pool, trial_sums
from worm_analysis.pooling.estimates import pooled_quantities
from worm_analysis.results import Results, read_results
from worm_model.inference.comparison import ModelParameters, can_compare, compare_with_walk
from worm_model.inference.escape import EscapeTimes
from worm_model.inference.fit import fit_walk
from worm_model.inference.reversal_counts import Reversals
from worm_msgs_py import Attempt, Comparison, Episode, EpisodeKind, Geometry, Quantity, Visit

MM = 1e3
NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Case:
    """One trial, or several of one W, beside the walk.

    Attributes
    ----------
    name : str
        Its directory, or the pool's W.
    trials : int
        How many it rests on.
    comparison : Comparison or None
        None where there is nothing to compare; `why` then says why.
    why : str
        Empty, or why there is no comparison.
    """

    name: str
    trials: int
    comparison: Comparison | None
    why: str = ""


def compare_trials(
    directories: Sequence[Path],
    parameters: ModelParameters,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Case]:
    """Hold trials against the walk, each by itself, then those of one W together.

    Parameters
    ----------
    directories : sequence of Path
        Results directories.
    parameters : ModelParameters
        Which walk.
    progress : callable
        Given the trials that were read, and how many there are.

    Returns
    -------
    list of Case
        The trials in their order, then a pool for each W of which there is more than one trial.

    Raises
    ------
    ReportError
        Where a trial is incomplete or damaged, or is there twice.
    """
    found, sums, parts = [], [], {}
    for number, directory in enumerate(directories):
        results = read_results(directory)
        evidence = _Evidence.of([results])
        quantities = list(results.quantities)
        found.append(_case(str(directory), 1, quantities, results, evidence, parameters))
        if results.chambers:
            sums.append(trial_sums(results, str(directory), str(directory)))
            parts[str(directory)] = results
        progress(number + 1, len(directories))
    for pool in Pool.of(sums).by_width if sums else ():
        if len(pool.trials) < 2:
            continue
        together = [parts[trial.directory] for trial in pool.trials]
        quantities = [pooled.quantity for pooled in pooled_quantities(pool)]
        w_s = hypot(pool.width_mm, _depth_mm(together[0]))
        quantities.append(Quantity("w_s", w_s, n=len(together), unit="mm"))
        name = f"W = {pool.width_mm:g} mm, {len(together)} trials"
        evidence = _Evidence.of(together)
        found.append(_case(name, len(together), quantities, together[0], evidence, parameters))
    return found


@dataclass(frozen=True, slots=True)
class _Evidence:
    """What a comparison needs beyond the numbers of a summary."""

    reversals: Reversals
    escapes: EscapeTimes
    scores: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of(cls, trials: Sequence[Results]) -> "_Evidence":
        """Gather it; the scores of forecasts are those made while the frames came in."""
        reversals, escapes = Reversals(), EscapeTimes()
        for results in trials:
            chamber = results.chambers[0] if results.chambers else None
            if chamber is not None and chamber.px_per_m > 0:
                reversals.resolution_m = max(reversals.resolution_m, 1.0 / chamber.px_per_m)
        for results in trials:
            for episode, turn_rad in _episodes(results):
                reversals.push(episode, turn_rad)
            for event in _passages(results):
                escapes.push(event)
            stamps = results.tracks["stamp_ns"]
            escapes.end_trial(int(stamps[-1]) if len(stamps) else 0)
        only = trials[0].comparison if len(trials) == 1 else None
        return cls(reversals, escapes, only.scores if only is not None else ())


def _case(
    name: str,
    trials: int,
    quantities: list[Quantity],
    results: Results,
    evidence: _Evidence,
    parameters: ModelParameters,
) -> Case:
    if not results.chambers:
        return Case(name, trials, None, "no chamber in the picture")
    if not can_compare(quantities):
        return Case(
            name, trials, None, "no exit in view, or nothing measured of the walk's numbers"
        )
    rig = Geometry(1, 0, 0, 0, results.chambers, depth_m=_depth_mm(results) / MM)
    fit = fit_walk(
        quantities,
        rig,
        evidence.reversals,
        hop_may_land=parameters.hop_may_land,
        effective_width=parameters.effective_width,
    )
    stamps = results.tracks["stamp_ns"]
    comparison, _ = compare_with_walk(
        quantities,
        fit,
        int(stamps[-1]) if len(stamps) else 0,
        parameters,
        escapes=evidence.escapes,
        scores=evidence.scores,
        with_needs=True,
    )
    return Case(name, trials, comparison)


def _depth_mm(results: Results) -> float:
    """Return h; the rig's usual one where the results are of a version that did not tell it."""
    return results.depth_mm if isfinite(results.depth_mm) else Geometry(1, 0, 0, 0).depth_m * MM


def _episodes(results: Results) -> Iterable[tuple[Episode, float]]:
    """Yield each contact and excursion with its Δθ_h, which the tracks give."""
    stamps, theta = results.tracks["stamp_ns"], results.tracks["theta_h_rad"]
    table = results.contacts
    ends = [table["start_ns"].astype(np.int64), table["end_ns"].astype(np.int64)]
    if not len(stamps):
        return
    at = [np.clip(np.searchsorted(stamps, end), 0, len(stamps) - 1) for end in ends]
    turns = theta[at[1]] - theta[at[0]]
    for row, (start_ns, end_ns) in enumerate(zip(*ends, strict=True)):
        yield (
            Episode(
                str(table["chamber"][row]),
                EpisodeKind(table["kind"][row]),
                int(start_ns),
                int(end_ns),
                float(table["distance_mm"][row]) / MM,
                complete=bool(table["complete"][row]),
            ),
            float(turns[row]),
        )


def _passages(results: Results) -> Iterable[Visit | Attempt]:
    """Yield visits and attempts in the order in which they closed."""
    table = results.passages
    for row, record in enumerate(table["record"]):
        common = (
            str(table["chamber"][row]), int(table["start_ns"][row]), int(table["end_ns"][row])
        )  # fmt: skip
        if record == "visit":
            first = table["first_contact_ns"][row]
            first_ns = int(first) if isfinite(first) else None
            tau_s = float(table["tau_h_s"][row])
            complete = bool(table["complete"][row])
            yield Visit(*common, first_ns, tau_h_s=tau_s, complete=complete)
        elif isfinite(table["success"][row]):
            depth_m = float(table["penetration_mm"][row]) / MM
            success, complete = bool(table["success"][row]), bool(table["complete"][row])
            yield Attempt(*common, depth_m, success, complete=complete)
