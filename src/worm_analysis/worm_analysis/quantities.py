"""Every number of a trial, with its interval, its n and the paper's value (docs/science.md)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import degrees, hypot, inf, isfinite, nan

from worm_analysis.body_sums import BodySums
from worm_analysis.distributions import ExcessSums
from worm_analysis.episode_sums import PassageSums
from worm_analysis.frame_sums import RADIUS_EDGES
from worm_analysis.paper_values import paper_value
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.statistics import (
    Estimate,
    decay_over_constant,
    exponential_mean,
    finite_or_none,
    fraction,
    merged_excursion_factor,
    poisson_rate,
    unmerged_means,
)
from worm_analysis.wall_search import WallSearch
from worm_msgs_py import Quantity

TRIAL_S = 1800.0
X_P_BIN_M, X_P_LONGEST_M = 2.5e-4, 3.5e-2


@dataclass(frozen=True, slots=True)
class Evidence:
    """All that the numbers rest on.

    Attributes
    ----------
    parameters : AnalysisParameters
        Settings.
    search : WallSearch
        The search along the wall.
    passages : PassageSums
        Visits and attempts.
    skips : int
        Skips of the whole trial.
    body : BodySums
        Length and width in every frame.
    has_chamber : bool
        Whether there is a chamber at all.
    exit_width_m, depth_m, px_per_m : float
        W, h and the picture's scale; NaN where they are not known.
    """

    parameters: AnalysisParameters
    search: WallSearch
    passages: PassageSums
    skips: int
    body: BodySums
    has_chamber: bool = False
    exit_width_m: float = nan
    depth_m: float = nan
    px_per_m: float = nan


def quantities(evidence: Evidence) -> list[Quantity]:
    """Return all numbers of docs/science.md's table, and what else a model needs of a trial."""
    found = [
        *_positions(evidence),
        *_episodes(evidence),
        *_motion(evidence),
        *_searches(evidence),
        *_attempts(evidence),
        _effective_width(evidence),
    ]
    if not evidence.has_chamber:
        why = "no chamber in the picture"
        found = [Quantity(q.name, None, unit=q.unit, paper=q.paper, why=why) for q in found]
    return [*found, *_body(evidence)]


def _positions(evidence: Evidence) -> list[Quantity]:
    """Return the modes of P(r), the peaks of P(ψ_b) and the time at the wall (Fig. 1d, 1e)."""
    frames, tell = evidence.search.frames, partial(_tell, evidence)
    peaks = [
        tell(
            f"{name}_over_R",
            "1",
            int(frames.histogram(name).sum()),
            partial(frames.radius_peak, name),
            bounds=(0.0, RADIUS_EDGES[-1]),
            items="frames in a chamber",
            why="P(r) has no peak between the centre and 1.2 R",
        )
        for name in ("r_h", "r_c", "r_t")
    ]
    frames_with_body = int(frames.histogram("psi_b").sum())
    peaks += [
        tell(
            name,
            "deg",
            frames_with_body,
            partial(frames.angle_peak, "psi_b", sign),
            bounds=(-180.0, 0.0) if sign < 0 else (0.0, 180.0),
            scale=degrees(1.0),
            items="frames with a body angle",
            why="P(ψ_b) has no peak of its own on this side",
        )
        for name, sign in (("psi_b_negative_peak", -1), ("psi_b_positive_peak", 1))
    ]
    known = int(frames.total("contact_known"))
    touching = partial(frames.ratio, "contact", "contact_known")
    at_wall = tell(
        "contact_fraction", "1", known, touching, bounds=(0.0, 1.0), items="frames in a chamber"
    )
    return [*peaks, at_wall]


def _episodes(evidence: Evidence) -> list[Quantity]:
    """Return the exponential means of Fig. 3, with what frames and pixels hide allowed for.

    Episodes shorter than one and a half of the head's advance a frame (or of a pixel) are cut off,
    and episodes that were taken for one because a short one between them was not seen are corrected
    for; an excursion is deeper than the threshold of contact by definition.
    """
    episodes, tell = evidence.search.episodes, partial(_tell, evidence)
    pixel_m = 1 / evidence.px_per_m if evidence.px_per_m > 0 else 0.0
    limit_m = 1.5 * max(episodes.step_m, pixel_m)
    n_c, excess_c, _ = episodes.d_c.above(limit_m)
    n_nc, excess_nc, _ = episodes.d_nc.above(limit_m)
    scale_c = scale_nc = scale_r = 1.0
    if n_c and n_nc and episodes.step_m > 0:
        seen = (excess_c / n_c, excess_nc / n_nc)
        true = unmerged_means(*seen, episodes.step_m)
        scale_c, scale_nc = true[0] / seen[0], true[1] / seen[1]
        scale_r = 1 / merged_excursion_factor(true[0], episodes.step_m)
    width_m = evidence.parameters.body_width_m or evidence.body.median_width()
    threshold_m = evidence.parameters.contact_factor * width_m
    return [
        _mean(
            tell,
            "d_c",
            episodes.d_c,
            limit_m,
            scale_c,
            "complete contacts above the resolution limit",
        ),
        _mean(
            tell,
            "d_nc",
            episodes.d_nc,
            limit_m,
            scale_nc,
            "complete excursions above the resolution limit",
        ),
        _mean(
            tell,
            "delta_r_h",
            episodes.delta_r_h,
            max(pixel_m, threshold_m if isfinite(threshold_m) else 0.0),
            scale_r,
            "complete excursions above the resolution limit",
        ),
    ]


def _mean(
    tell: Callable[..., Quantity],
    name: str,
    lengths: ExcessSums,
    limit_m: float,
    scale: float,
    items: str,
) -> Quantity:
    n, excess_m, _ = lengths.above(limit_m)
    return tell(
        name, "mm", n, partial(exponential_mean, n, excess_m), scale=1e3 * scale, items=items
    )


def _motion(evidence: Evidence) -> list[Quantity]:
    """Return t_per, the speeds and the reversals (Figs 4c, 7a; docs/science.md)."""
    frames, episodes = evidence.search.frames, evidence.search.episodes
    tell = partial(_tell, evidence)
    moving = int(frames.total("speed_n"))
    directed_s = frames.total("directed_s")
    return [
        evidence.search.correlation.persistence_time(evidence.parameters.minimum_n),
        tell(
            "v_w",
            "mm/s",
            moving,
            partial(frames.ratio, "v_sin", "sin_sin"),
            scale=1e3,
            items="frames with a speed",
        ),
        tell(
            "v_b",
            "mm/s",
            moving,
            partial(frames.ratio, "speed", "speed_n"),
            scale=1e3,
            bounds=(0.0, inf),
            items="frames with a speed",
        ),
        tell(
            "reversal_per_cycle",
            "1",
            episodes.cycles,
            partial(fraction, episodes.reversals, episodes.cycles),
            items="pairs of cycles",
        ),
        tell(
            "reversal_rate",
            "1/s",
            int(directed_s),
            partial(frames.ratio, "turns_back", "directed_s"),
            bounds=(0.0, inf),
            items="seconds with a direction",
        ),
    ]


def _searches(evidence: Evidence) -> list[Quantity]:
    """Return ⟨τ_h⟩ and the skips in 30 min (Figs 5, 6)."""
    passages, tell = evidence.passages, partial(_tell, evidence)
    if not evidence.exit_width_m > 0:
        return [
            _none("tau_h", "s", "no exit in view"),
            _none("n_s", "per 30 min", "no exit in view"),
        ]
    observed_s = evidence.search.observed_s
    return [
        tell(
            "tau_h",
            "s",
            passages.finds,
            partial(exponential_mean, passages.finds, passages.search_s),
            items="findings of the exit after a contact",
        ),
        tell(
            "n_s",
            "per 30 min",
            int(observed_s),
            partial(poisson_rate, evidence.skips, observed_s),
            scale=TRIAL_S,
            items="seconds in a chamber",
            n_shown=evidence.skips,
        ),
    ]


def _attempts(evidence: Evidence) -> list[Quantity]:
    """Return the success rate, the decay of F(x_p) and the failures by cause (Figs 8, 9)."""
    passages, tell = evidence.passages, partial(_tell, evidence)
    x_p = passages.depths.distribution("x_p", X_P_BIN_M, X_P_LONGEST_M)
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
    )
    return [
        *(
            tell(name, "1", n, partial(fraction, count, n), items=items)
            for name, count, n, items in counts
        ),
        tell(
            "beta",
            "1/mm",
            passages.failures,
            partial(decay_over_constant, x_p.edges, x_p.counts),
            scale=1e-3,
            items="failed attempts",
        ),
    ]


def _effective_width(evidence: Evidence) -> Quantity:
    """Return w_s = √(W² + h²)."""
    w_s = hypot(evidence.exit_width_m, evidence.depth_m)
    if not isfinite(w_s):
        return _none("w_s", "mm", "no exit in view")
    return Quantity("w_s", w_s * 1e3, n=1, unit="mm")


def _body(evidence: Evidence) -> list[Quantity]:
    """Return l_w and d_w; both can be had without a chamber where a scale is given."""
    tell = partial(_tell, evidence)
    return [
        tell(
            name,
            "mm",
            n,
            partial(_pair, value, half),
            scale=1e3,
            bounds=(0.0, inf),
            items="frames with a body and a scale",
        )
        for name, (n, value, half) in (
            ("l_w", evidence.body.length()),
            ("d_w", evidence.body.width()),
        )
    ]


def _pair(value: float, half: float | None) -> tuple[float, float | None]:
    return value, half


def _tell(
    evidence: Evidence,
    name: str,
    unit: str,
    n: int,
    estimate: Callable[[], Estimate | tuple[float, float | None]],
    *,
    items: str,
    scale: float = 1.0,
    bounds: tuple[float, float] = (-inf, inf),
    why: str = "the data do not determine it",
    n_shown: int | None = None,
) -> Quantity:
    """Return a quantity, or why there is none.

    Parameters
    ----------
    evidence : Evidence
        For the smallest n that is enough, and for the paper's value.
    name, unit : str
        As in the summary.
    n : int
        Items that there are; `estimate` is called only where they are enough.
    estimate : callable
        Gives value, low and high, or value and half width.
    items : str
        What n counts.
    scale : float
        From the estimate's unit to the summary's.
    bounds : (float, float)
        Values, in the summary's unit, that the interval cannot go beyond.
    why : str
        What a NaN means.
    n_shown : int or None
        Where another number than n says what the estimate rests on.
    """
    minimum = evidence.parameters.minimum_n
    paper = paper_value(name, evidence.exit_width_m)
    shown = n if n_shown is None else n_shown
    if n < minimum:
        reason = f"not enough data: {n} {items}, {minimum} are needed"
        return Quantity(name, None, n=shown, unit=unit, paper=paper, why=reason)
    result = estimate()
    value = result[0]
    if len(result) == 2:
        half = nan if result[1] is None else result[1]
        low, high = value - half, value + half
    else:
        low, high = result[1], result[2]
    if not isfinite(value):
        return Quantity(name, None, n=shown, unit=unit, paper=paper, why=why)
    least, most = bounds
    return Quantity(
        name,
        value * scale,
        finite_or_none(max(least, low * scale) if isfinite(low) else nan),
        finite_or_none(min(most, high * scale) if isfinite(high) else nan),
        shown,
        unit,
        paper,
    )


def _none(name: str, unit: str, why: str) -> Quantity:
    return Quantity(name, None, unit=unit, paper=paper_value(name), why=why)
