"""The boundary walk for a pool of trials: with their own parameters, and with the paper's."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from worm_analysis.pooling import Pool, WalkPrediction
from worm_model.boundary_walk.direction_correlation import direction_correlation
from worm_model.boundary_walk.first_passage import SolvedWalk
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_msgs_py.paper import (
    DEPTH_MM,
    REVERSAL_OF_FIG_6,
    TRIAL_S,
    WALK_HOP_MM,
    WALK_SLIDE_MM,
)

_LONGEST_IN_MEANS, _DENSITY_BINS = 6.0, 48
CURVE_MM = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0)
LAG_S = np.arange(0.0, 60.01, 0.5)


def pooled_walks(pool: Pool) -> tuple[WalkPrediction, ...]:
    """Return what the walk predicts: with the pool's parameters if it has all, and the paper's.

    Parameters
    ----------
    pool : Pool
        Trials of at least one known W; without any there is nothing to predict.

    Returns
    -------
    tuple of WalkPrediction
        The pool's own first.
    """
    widths = sorted({part.width_mm for part in pool.by_width} | set(CURVE_MM))
    if not pool.by_width:
        return ()
    depths = [trial.depth_mm for trial in pool.trials if isfinite(trial.depth_mm)]
    depth_mm = float(np.mean(depths)) if depths else DEPTH_MM
    rig = WalkParameters(radius_mm=pool.radius_mm, depth_mm=depth_mm)
    found = []
    own = _own(pool, rig)
    shown = [part.width_mm for part in pool.by_width]
    if own is not None:
        found.append(_predict(own, (own.reversal,), widths, shown, is_own=True))
    paper = replace(
        rig,
        mean_slide_mm=WALK_SLIDE_MM,
        mean_hop_mm=WALK_HOP_MM,
        reversal=REVERSAL_OF_FIG_6[0],
        rule=ReversalRule.PER_CYCLE,
    )
    found.append(_predict(paper, sorted(REVERSAL_OF_FIG_6), widths, shown, is_own=False))
    return tuple(found)


def _own(pool: Pool, rig: WalkParameters) -> WalkParameters | None:
    """Return the walk of the pool's own numbers; None where one of them cannot be had."""
    names = ("d_c", "d_nc", "v_b", "reversal_per_cycle")
    values = [pool.numbers[name].quantity.value for name in names]
    if any(value is None for value in values):
        return None
    slide, hop, speed, reversal = (float(value) for value in values if value is not None)
    if min(slide, hop, speed) <= 0:
        return None
    return replace(rig, mean_slide_mm=slide, mean_hop_mm=hop, speed_mm_s=speed, reversal=reversal)


def _predict(
    walk: WalkParameters,
    reversals: Sequence[float],
    widths: Sequence[float],
    shown: Sequence[float],
    *,
    is_own: bool,
) -> WalkPrediction:
    tau, skips = np.empty((2, len(reversals), len(widths)))
    edges, density = {}, {}
    for row, reversal in enumerate(reversals):
        for column, width in enumerate(widths):
            law = SolvedWalk(replace(walk, exit_width_mm=width, reversal=reversal)).first_passage()
            tau[row, column] = law.mean_s
            skips[row, column] = TRIAL_S * law.skips / law.mean_s
            if reversal == walk.reversal and width in shown:
                edges[width] = np.linspace(0.0, _LONGEST_IN_MEANS * law.mean_s, _DENSITY_BINS + 1)
                density[width] = np.diff(law.within(edges[width])) / np.diff(edges[width])
    middle = reversals.index(walk.reversal)
    several = len(reversals) > 1
    none = np.full(len(widths), np.nan)
    return WalkPrediction(
        is_own=is_own,
        parameters=_walk_parameters(walk),
        width_mm=np.array(widths),
        tau_h_s=tau[middle],
        n_s=skips[middle],
        tau_low_s=tau.min(axis=0) if several else none,
        tau_high_s=tau.max(axis=0) if several else none,
        n_s_low=skips.min(axis=0) if several else none,
        n_s_high=skips.max(axis=0) if several else none,
        edges_s=edges,
        density=density,
        lag_s=LAG_S,
        c=direction_correlation(walk, LAG_S),
    )


def _walk_parameters(walk: WalkParameters) -> dict[str, float | str]:
    return {
        "radius_mm": walk.radius_mm,
        "depth_mm": walk.depth_mm,
        "speed_mm_s": walk.speed_mm_s,
        "mean_slide_mm": walk.mean_slide_mm,
        "mean_hop_mm": walk.mean_hop_mm,
        "reversal": walk.reversal,
        "reversal_counted": str(walk.rule),
        "hop_may_land": "yes" if walk.hop_may_land else "no",
        "exit_arc": "w_s" if walk.effective_width else "W",
    }
