"""Skips, success, the failures by cause, and F(x_p): what happens at the exit (Figs 6b, 8, 9)."""

from collections.abc import Iterator
from functools import partial
from math import hypot, isfinite

import numpy as np

from worm_analysis.accumulators.passage_sums import DEPTH_BIN_M
from worm_analysis.events.exit_region import sagitta
from worm_analysis.statistics.estimators import fraction, poisson_rate
from worm_analysis.statistics.penetration_law import Penetration, fit_penetration
from worm_analysis.summary.quantity_table import Evidence, none, tell
from worm_msgs_py import Quantity

TRIAL_S = 1800.0
BINS_A_GROUP = 10
"""Depths are fitted in bins of 0.1 mm."""
FEWEST_FOR_DECAY = 20
"""Fewer failures cannot tell a decay from a constant."""


def skips(evidence: Evidence) -> Quantity:
    """Return n_s, the skips in 30 min in a chamber (Fig. 6b)."""
    if not evidence.exit_width_m > 0:
        return none("n_s", "per 30 min", "no exit in view")
    observed_s = evidence.search.observed_s
    return tell(
        evidence,
        "n_s",
        "per 30 min",
        int(observed_s),
        partial(poisson_rate, evidence.skips, observed_s),
        scale=TRIAL_S,
        items="seconds in a chamber",
        n_shown=evidence.skips,
    )


def attempts(evidence: Evidence) -> Iterator[Quantity]:
    """Yield the success rate (Fig. 8) and the failures by cause."""
    passages = evidence.passages
    counts: tuple[tuple[str, int, int, str], ...] = (
        ("success", passages.successes, passages.attempts, "decided attempts"),
        (
            "failures_without_contact",
            passages.free_failures,
            passages.told_failures,
            "failed attempts in which contact can be told",
        ),
        (
            "failures_in_elongation",
            passages.elongations,
            passages.phases,
            "failed attempts with a known phase of the stroke",
        ),
        (
            "failures_touching_in_elongation",
            passages.touching_elongations,
            passages.causes,
            "failed attempts whose cause can be told",
        ),
        (
            "failures_touching_in_contraction",
            passages.touching_contractions,
            passages.causes,
            "failed attempts whose cause can be told",
        ),
        (
            "failures_of_unknown_phase",
            passages.failures - passages.phases,
            passages.failures,
            "failed attempts",
        ),
    )
    for name, count, n, items in counts:
        yield tell(evidence, name, "1", n, partial(fraction, count, n), items=items)


def decay(evidence: Evidence) -> Iterator[Quantity]:
    """Yield β, α and the constant of F(x_p) (Fig. 9).

    Depths below that of the circle's own bulge over the mouth are not all seen, and left out; the
    range of the constant is the observed one, up to the deepest failure.
    """
    depths = evidence.passages.depths
    least_m = max(sagitta(evidence.radius_m, evidence.exit_width_m), evidence.pixel_m)
    counts, _ = depths.complete_above(least_m)
    n = int(counts.sum())
    found: Penetration | None = None
    if n >= max(FEWEST_FOR_DECAY, evidence.parameters.minimum_n):
        last = int(np.flatnonzero(counts)[-1])
        groups = last // BINS_A_GROUP + 1
        padded = np.zeros(groups * BINS_A_GROUP, dtype=np.int64)
        padded[: last + 1] = counts[: last + 1]
        edges = np.arange(groups + 1, dtype=np.float64) * (BINS_A_GROUP * DEPTH_BIN_M)
        found = fit_penetration(edges, padded.reshape(groups, -1).sum(axis=1))
    for name in ("beta", "alpha", "const"):
        yield tell(
            evidence,
            name,
            "1/mm",
            n,
            partial(getattr, found, name),
            scale=1e-3,
            items="failed attempts",
            fewest=FEWEST_FOR_DECAY,
        )


def effective_width(evidence: Evidence) -> Quantity:
    """Return w_s = √(W² + h²)."""
    w_s = hypot(evidence.exit_width_m, evidence.depth_m)
    if not isfinite(w_s):
        return none("w_s", "mm", "no exit in view")
    return Quantity("w_s", w_s * 1e3, n=1, unit="mm")
