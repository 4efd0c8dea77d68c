"""What `worm model compare` says: trials, and pools of them by W, beside the exact walk."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from math import isfinite
from pathlib import Path

import numpy as np

from worm_analysis.pooling import Pool, pooled_trial
from worm_analysis.results import Results, read_results
from worm_analysis.results.contacts import read_episodes
from worm_analysis.results.passages import read_passages
from worm_model.inference.comparison import ModelParameters, can_compare, compare_with_walk
from worm_model.inference.escape import EscapeTimes
from worm_model.inference.fit import fit_walk
from worm_model.inference.reversal_counts import Reversals
from worm_msgs_py import Comparison, Episode, Geometry, Quantity
from worm_msgs_py.paper import DEPTH_MM
from worm_msgs_py.units import MM_PER_M


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
        observed = _Observed.of([results], _pixel_m(results))
        quantities = list(results.quantities)
        found.append(_case(str(directory), 1, quantities, results, observed, parameters))
        if results.chambers:
            sums.append(pooled_trial(results, str(directory), str(directory)))
            parts[str(directory)] = results
        progress(number + 1, len(directories))
    for pool in Pool.of(sums).by_width if sums else ():
        if len(pool.trials) < 2:
            continue
        together = [parts[trial.directory] for trial in pool.trials]
        quantities = [pooled.quantity for pooled in pool.numbers.values()]
        name = f"W = {pool.width_mm:g} mm, {len(together)} trials"
        observed = _Observed.of(together, max(map(_pixel_m, together)))
        found.append(_case(name, len(together), quantities, together[0], observed, parameters))
    return found


def compare_pool(pool: Pool, directories: Sequence[Path]) -> dict[float, Comparison]:
    """Hold the trials of each W of a pool against the walk; one trial at a time is read.

    Parameters
    ----------
    pool : Pool
        The trials.
    directories : sequence of Path
        Their results directories, in the same order.

    Returns
    -------
    dict of float to Comparison
        By W; without those that cannot be compared.
    """
    places = dict(zip(map(id, pool.trials), directories, strict=True))
    found = {}
    for part in pool.by_width:
        read = (read_results(places[id(trial)]) for trial in part.trials)
        first = next(read)
        observed = _Observed.of(chain([first], read), _coarsest_pixel_m(part))
        quantities = [pooled.quantity for pooled in part.numbers.values()]
        case = _case("", len(part.trials), quantities, first, observed, ModelParameters())
        if case.comparison is not None:
            found[part.width_mm] = case.comparison
    return found


def _coarsest_pixel_m(pool: Pool) -> float:
    totals = [trial.sums["pixel"].sum(axis=0) for trial in pool.trials if "pixel" in trial.sums]
    return max((float(size_m / n) for n, size_m in totals if n), default=0.0)


@dataclass(frozen=True, slots=True)
class _Observed:
    """What a comparison needs beyond the numbers of a summary."""

    reversals: Reversals
    escapes: EscapeTimes
    scores: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of(cls, trials: Iterable[Results], pixel_m: float) -> "_Observed":
        """Gather it, one trial at a time; scores of forecasts are those of a trial alone.

        They were made while its frames came in. `pixel_m` is the coarsest of the trials' pixels.
        """
        reversals, escapes = Reversals(resolution_m=pixel_m), EscapeTimes()
        scores: list[tuple[tuple[str, float], ...]] = []
        for results in trials:
            for episode, turn_rad in _episodes(results):
                reversals.push(episode, turn_rad)
            for event in read_passages(results.passages):
                escapes.push(event)
            stamps = results.tracks["stamp_ns"]
            escapes.end_trial(int(stamps[-1]) if len(stamps) else 0)
            scores.append(() if results.comparison is None else results.comparison.scores)
        return cls(reversals, escapes, scores[0] if len(scores) == 1 else ())


def _pixel_m(results: Results) -> float:
    chamber = results.chambers[0] if results.chambers else None
    return 1.0 / chamber.px_per_m if chamber is not None and chamber.px_per_m > 0 else 0.0


def _case(
    name: str,
    trials: int,
    quantities: list[Quantity],
    results: Results,
    observed: _Observed,
    parameters: ModelParameters,
) -> Case:
    if not results.chambers:
        return Case(name, trials, None, "no chamber in the picture")
    if not can_compare(quantities):
        return Case(
            name, trials, None, "no exit in view, or nothing measured of the walk's numbers"
        )
    rig = Geometry(1, 0, 0, 0, results.chambers, depth_m=_depth_mm(results) / MM_PER_M)
    fit = fit_walk(
        quantities,
        rig,
        observed.reversals,
        hop_may_land=parameters.hop_may_land,
        effective_width=parameters.effective_width,
    )
    stamps = results.tracks["stamp_ns"]
    comparison, _ = compare_with_walk(
        quantities,
        fit,
        int(stamps[-1]) if len(stamps) else 0,
        parameters,
        escapes=observed.escapes,
        scores=observed.scores,
        with_needs=True,
    )
    return Case(name, trials, comparison)


def _depth_mm(results: Results) -> float:
    """Return h; the rig's usual one where the results are of a version that did not tell it."""
    return results.depth_mm if isfinite(results.depth_mm) else DEPTH_MM


def _episodes(results: Results) -> Iterator[tuple[Episode, float]]:
    """Yield each contact and excursion with its Δθ_h, which the tracks give."""
    stamps, theta = results.tracks["stamp_ns"], results.tracks["theta_h_rad"]
    if not len(stamps):
        return
    for episode in read_episodes(results.contacts):
        ends = np.searchsorted(stamps, (episode.start_ns, episode.end_ns))
        start, end = np.minimum(ends, len(stamps) - 1)
        yield episode, float(theta[end] - theta[start])
