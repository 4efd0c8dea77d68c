"""The boundary walk's parameters, with the paper's values (section "Boundary search model")."""

from dataclasses import dataclass
from enum import StrEnum
from math import hypot, inf, pi

from worm_msgs_py import paper


class ReversalRule(StrEnum):
    """What a reversal's probability counts; the paper does not say."""

    PER_CYCLE = "per_cycle"
    """Once per slide + hop, after the hop."""
    PER_PHASE = "per_phase"
    """After each slide and after each hop."""
    RATE = "rate"
    """At any time, in either phase; `reversal` is a rate, 1/s."""


@dataclass(frozen=True, slots=True)
class WalkParameters:
    """The walk's parameters; the defaults are the paper's.

    Attributes
    ----------
    radius_mm, exit_width_mm, depth_mm : float
        R, W and h.
    speed_mm_s : float
        v, along the wall, in both phases.
    mean_slide_mm, mean_hop_mm : float
        Means of the exponential laws of the distance in and out of contact, ⟨d_c⟩ and ⟨d_nc⟩.
    reversal : float
        Probability of turning around (`per_cycle`, `per_phase`), or its rate in 1/s (`rate`).
    rule : ReversalRule
        What `reversal` counts.
    hop_may_land : bool
        Whether a hop that ends above the exit finds it. Else it flies on to the exit's far edge.
    effective_width : bool
        Whether the exit is w_s = √(W² + h²) wide, as in the paper, or W.

    Raises
    ------
    ValueError
        Where a number makes no sense.
    """

    radius_mm: float = paper.RADIUS_MM
    exit_width_mm: float = 1.0
    depth_mm: float = paper.DEPTH_MM
    speed_mm_s: float = paper.SPEED_MM_S
    mean_slide_mm: float = paper.SLIDE_MM
    mean_hop_mm: float = paper.HOP_MM
    reversal: float = paper.REVERSAL[0]
    rule: ReversalRule = ReversalRule.PER_CYCLE
    hop_may_land: bool = True
    effective_width: bool = True

    def __post_init__(self) -> None:
        for name in ("radius_mm", "speed_mm_s", "mean_slide_mm", "mean_hop_mm"):
            if not 0.0 < getattr(self, name) < inf:
                raise ValueError(f"{name} is {getattr(self, name)}; it must be above 0")
        highest = inf if self.rule is ReversalRule.RATE else 1.0
        if not 0.0 <= self.reversal <= highest:
            raise ValueError(f"reversal is {self.reversal}; {self.rule} allows 0 to {highest:g}")
        if not (self.exit_width_mm >= 0.0 and self.depth_mm >= 0.0):
            raise ValueError("exit_width_mm and depth_mm must not be below 0")
        if not 0.0 < self.exit_arc_mm < self.circumference_mm:
            raise ValueError(
                f"the exit's arc of {self.exit_arc_mm:g} mm must be above 0 and shorter than the "
                f"wall's {self.circumference_mm:g} mm"
            )

    @property
    def exit_arc_mm(self) -> float:
        """Width of the exit's arc: w_s, or W."""
        if self.effective_width:
            return hypot(self.exit_width_mm, self.depth_mm)
        return self.exit_width_mm

    @property
    def exit_edge_rad(self) -> float:
        """θ where the wall begins again: a hair beyond the exit's edge, so that it is wall."""
        return 0.5 * self.exit_arc_mm / self.radius_mm * (1.0 + 1e-9)

    @property
    def circumference_mm(self) -> float:
        """2πR, the exit's arc included."""
        return 2.0 * pi * self.radius_mm

    @property
    def wall_mm(self) -> float:
        """Length of the wall outside the exit's arc."""
        return self.circumference_mm - self.exit_arc_mm

    @property
    def flip_after_slide(self) -> float:
        """Probability of turning around at the end of a slide."""
        return self.reversal if self.rule is ReversalRule.PER_PHASE else 0.0

    @property
    def flip_after_hop(self) -> float:
        """Probability of turning around at the end of a hop."""
        return 0.0 if self.rule is ReversalRule.RATE else self.reversal

    @property
    def flip_rate_s(self) -> float:
        """Rate of turning around at any time, 1/s."""
        return self.reversal if self.rule is ReversalRule.RATE else 0.0
