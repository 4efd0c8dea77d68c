"""One boundary walk in numbers, with the parameters and the conventions that they rest on."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import degrees, isnan
from typing import Any

from worm_model.boundary_walk.direction_correlation import persistence_time_s
from worm_model.boundary_walk.first_passage import SolvedWalk
from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.state import WalkState

LEVELS = 0.05, 0.5, 0.95
CONVENTIONS = {
    "theta": "from the middle of the exit, counter-clockwise positive as seen in the picture",
    "tau_h": "from the start until the head is in the exit's arc, sliding or landed from a hop",
    "skips": "times that a hop leaves the exit's arc again, by either edge",
    "start": "uniform: anywhere on the wall, sliding, in either direction",
    "t_per": "time in which C_theta falls to 1/e",
}
NO_FALL = "C_theta never falls to 1/e with this reversal"


@dataclass(frozen=True, slots=True)
class WalkSummary:
    """What the exact solution says of one walk.

    Attributes
    ----------
    parameters : WalkParameters
        The walk.
    start : WalkState or None
        Its state at time 0; None: uniform.
    mean_s, sd_s : float
        Of τ_h.
    quantiles_s : tuple of float
        τ_h at the `LEVELS`: median and 90 % interval.
    skips : float
        Mean number of skips before the exit is found.
    at_s, survival : tuple of float
        Times, and the probabilities that the exit was not found by then.
    t_per_s : float
        NaN where there is none.
    """

    parameters: WalkParameters
    start: WalkState | None
    mean_s: float
    sd_s: float
    quantiles_s: tuple[float, ...]
    skips: float
    at_s: tuple[float, ...]
    survival: tuple[float, ...]
    t_per_s: float

    def document(self) -> dict[str, Any]:
        """Return the same for JSON."""
        start: str | dict[str, Any] = "uniform"
        if self.start is not None:
            start = {
                "theta_deg": degrees(self.start.theta_rad),
                "direction": self.start.direction.value,
                "phase": self.start.phase.value,
            }
        low_s, median_s, high_s = self.quantiles_s
        t_per: dict[str, Any] = {"t_per_s": self.t_per_s}
        if isnan(self.t_per_s):
            t_per = {"t_per_s": None, "t_per_why": NO_FALL}
        return {
            "mean_s": self.mean_s,
            "sd_s": self.sd_s,
            "median_s": median_s,
            "interval_90_s": [low_s, high_s],
            "skips": self.skips,
            "at_s": list(self.at_s),
            "survival": list(self.survival),
            **t_per,
            "start": start,
            "parameters": asdict(self.parameters) | {"exit_arc_mm": self.parameters.exit_arc_mm},
            "conventions": CONVENTIONS,
        }


def summarise(
    parameters: WalkParameters, start: WalkState | None = None, at_s: Sequence[float] = ()
) -> WalkSummary:
    """Solve a walk.

    Parameters
    ----------
    parameters : WalkParameters
        The walk.
    start : WalkState, optional
        Its state at time 0; uniform where there is none.
    at_s : sequence of float
        Times of the survival function.

    Raises
    ------
    ValueError
        Where the state is a slide within the exit, or a time is below 0 or not finite.
    """
    law = SolvedWalk(parameters).first_passage(start)
    return WalkSummary(
        parameters=parameters,
        start=start,
        mean_s=law.mean_s,
        sd_s=law.sd_s,
        quantiles_s=tuple(law.quantile(level) for level in LEVELS),
        skips=law.skips,
        at_s=tuple(at_s),
        survival=tuple(float(p) for p in law.survival(list(at_s))),
        t_per_s=persistence_time_s(parameters),
    )
