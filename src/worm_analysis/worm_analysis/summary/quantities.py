"""Every number of a trial, with its interval, its n and the paper's value (docs/science.md)."""

from functools import partial
from math import degrees, inf

from worm_analysis.accumulators.exclusions import UNCERTAIN, UNTRACKED
from worm_analysis.accumulators.frame_sums import RADIUS_EDGES
from worm_analysis.statistics.estimators import Estimate, fraction, per_true_cycle
from worm_analysis.summary import episode_quantities, passage_quantities
from worm_analysis.summary import quantity_table as telling
from worm_analysis.summary.quantity_table import Evidence
from worm_msgs_py import Quantity


def quantities(evidence: Evidence) -> list[Quantity]:
    """Return all numbers of docs/science.md's table, and what else a model needs of a trial."""
    found = [
        *_positions(evidence),
        *episode_quantities.episode_quantities(evidence),
        *_motion(evidence),
        *episode_quantities.search_time(evidence),
        passage_quantities.skips(evidence),
        *passage_quantities.attempts(evidence),
        *passage_quantities.decay(evidence),
        passage_quantities.effective_width(evidence),
        *episode_quantities.sensitivities(evidence),
    ]
    if not evidence.has_chamber:
        why = "no chamber in the picture"
        found = [Quantity(q.name, None, unit=q.unit, paper=q.paper, why=why) for q in found]
    return [*found, *_body(evidence), *_left_out(evidence)]


def _positions(evidence: Evidence) -> list[Quantity]:
    """Return the modes of P(r), the peaks of P(ψ_b) and the time at the wall (Fig. 1d, 1e)."""
    frames, tell = evidence.search.frames, partial(telling.tell, evidence)
    peaks = [
        tell(
            f"{name}_over_R",
            "1",
            int(frames.histogram(name).sum()),
            partial(_pair, *estimate),
            bounds=(0.0, RADIUS_EDGES[-1]),
            items="frames in a chamber",
            why="P(r) has no peak between the centre and 1.2 R",
        )
        for name, estimate in zip(("r_h", "r_c", "r_t"), frames.radius_peaks(), strict=True)
    ]
    frames_with_body = int(frames.histogram("psi_b").sum())
    sides = (("negative", (-180.0, 0.0)), ("positive", (0.0, 180.0)))
    peaks += [
        tell(
            f"psi_b_{side}_peak",
            "deg",
            frames_with_body,
            partial(_pair, *estimate),
            bounds=bounds,
            scale=degrees(1.0),
            items="frames with a body angle",
            why="P(ψ_b) has no peak of its own on this side",
        )
        for (side, bounds), estimate in zip(sides, frames.angle_peaks(), strict=True)
    ]
    known = int(frames.total("contact_known"))
    touching = partial(frames.ratio, "contact", "contact_known")
    at_wall = tell(
        "contact_fraction", "1", known, touching, bounds=(0.0, 1.0), items="frames in a chamber"
    )
    return [*peaks, at_wall]


def _motion(evidence: Evidence) -> list[Quantity]:
    """Return t_per, the speeds, what they go with, and the reversals (Figs 4, 7a)."""
    search = evidence.search
    frames, episodes = search.frames, search.episodes
    tell = partial(telling.tell, evidence)
    moving = int(frames.total("speed_n"))
    directed_s = frames.total("directed_s")
    return [
        search.correlation.persistence_time(evidence.parameters.minimum_n),
        tell(
            "v_w",
            "mm/s",
            search.speed_law.windows,
            search.speed_law.speed,
            scale=1e3,
            items="windows of time with a speed and a body angle",
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
            "v_b_mean",
            "mm/s",
            moving,
            partial(frames.ratio, "velocity", "speed_n"),
            scale=1e3,
            items="frames with a speed",
        ),
        tell(
            "psi_b_mean",
            "deg",
            int(frames.histogram("psi_b").sum()),
            frames.mean_body_angle,
            scale=degrees(1.0),
            items="frames with a body angle",
        ),
        tell(
            "theta_dot_psi_b_correlation",
            "1",
            int(frames.total("pairs")),
            frames.correlation,
            items="frames with a speed and a body angle",
            why="the speed or the body angle does not vary",
        ),
        tell(
            "theta_dot_incidence_correlation",
            "1",
            search.collisions.n,
            search.collisions.correlation,
            items="contacts with an incidence and a speed after it",
            why="the speed or the incidence does not vary",
        ),
        tell(
            "reversal_per_cycle",
            "1",
            episodes.cycles,
            partial(_reversals, evidence),
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


def _reversals(evidence: Evidence) -> Estimate:
    episodes = evidence.search.episodes
    cycles = episode_quantities.cycles_in_one(episodes.lengths, evidence.pixel_m)
    value, low, high = fraction(episodes.reversals, episodes.cycles)
    return (
        per_true_cycle(value, cycles),
        per_true_cycle(low, cycles),
        per_true_cycle(high, cycles),
    )


def _body(evidence: Evidence) -> list[Quantity]:
    """Return l_w and d_w; both can be had without a chamber where a scale is given."""
    tell = partial(telling.tell, evidence)
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


def _left_out(evidence: Evidence) -> list[Quantity]:
    """Return which part of the frames counts for no estimate, and why; exact, so no interval."""
    frames = evidence.left_out.frames
    return [
        Quantity(f"frames_{reason}", evidence.left_out.by_reason[reason] / frames, n=frames)
        if frames
        else Quantity(f"frames_{reason}", None, why="not a frame was read")
        for reason in (UNTRACKED, UNCERTAIN)
    ]
