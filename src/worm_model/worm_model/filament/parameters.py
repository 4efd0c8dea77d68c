"""Every number of the filament: its unit, what it means and where it comes from."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from math import inf, isfinite
from typing import Any

from worm_msgs_py import paper


@dataclass(frozen=True, slots=True)
class FilamentSettings:
    """How the filament is solved for, and what of its body `FilamentParameters` does not say.

    Attributes
    ----------
    steps_per_s : int
        A step is 2.5 ms: the head moves by 5 µm in it, a fortieth of the body's width.
    settle_s : int
        Time before the first frame, in which the body finds its shape.
    start_radius_radii : float
        Where the body lies before that, in units of R: an arc around the centre that winds inwards.
    start_pitch : float
        How much nearer to the centre it gets for each mm, in mm, so that its ends lie apart.
    head_end_widths, tail_end_widths : float
        Length over which the body's round ends grow to its width, in the films, too.
    tip_clearance_mm : float
        How near the tips come to a wall: less than a pixel.
    squeezed_width : float
        A body that is wider than the passage is squeezed to this part of it.
    withdrawing_part : float
        Part of the body that shortens in a withdrawal, most of all at the head.
    most_of_front : float
        That front does not shorten by more than this part of it.
    wall_per_s : float
        The walls' stiffness: under the push of the whole body (40 mm²/s) a point gives by 0.04 µm.
    apart_widths : float
        Points nearer along the body than this do not push each other apart.
    overlap_part : float
        Part of an overlap of two strands by which each gives way in a step; half would overshoot.
    """

    steps_per_s: int = 400
    settle_s: int = 10
    start_radius_radii: float = 0.55
    start_pitch: float = 0.02
    head_end_widths: float = 1.5
    tail_end_widths: float = 2.5
    tip_clearance_mm: float = 0.02
    squeezed_width: float = 0.9
    withdrawing_part: float = 0.5
    most_of_front: float = 0.45
    wall_per_s: float = 1e6
    apart_widths: float = 4.0
    overlap_part: float = 0.3


FILAMENT = FilamentSettings()
LEAST_EXIT_WIDTHS = 0.5
"""Exit, in widths of the body, that it can be squeezed through."""
LEAST_LENGTH_WIDTHS = 4.0
"""A line with a width describes no body that is stouter."""
FITTED = "fitted"
"""How the source of a number begins that was chosen so that the paper's observations emerge."""


def _positive(default: float, unit: str, meaning: str, source: str, low: float = 0.0) -> Any:
    told = {"unit": unit, "meaning": meaning, "source": source, "low": low}
    return field(default=default, metadata=told)


@dataclass(frozen=True, slots=True)
class FilamentParameters:
    """The worm as an active, elastic, overdamped filament.

    All forces are over the drag along the body for each mm of it (ξ∥), which only times would
    depend on: so forces for each mm are in mm/s. `parameter_table` has meaning, unit and source of
    every number; those whose source begins with "fitted" were chosen so that what the paper
    observes emerges (docs/filament_worm.md), all others were not touched.

    Raises
    ------
    ValueError
        Where a number makes no sense.
    """

    length_mm: float = _positive(paper.LENGTH_MM, "mm", "mean length l_w", "paper: 20 ± 5 mm")
    width_mm: float = _positive(
        0.4, "mm", "width d_w", "photographs: 0.36 to 0.50 mm (the paper says 0.1 mm)"
    )
    segments: int = _positive(50, "1", "segments between points", "numerical", 8)
    crawl_speed_mm_s: float = _positive(
        1.25, "mm/s", "speed of a straight free worm: propulsion over ξ∥", FITTED
    )
    drag_ratio: float = _positive(
        2.0, "1", "drag across over drag along the body, ξ⊥/ξ∥", "slender-body limit"
    )
    bending_mm4_s: float = _positive(200.0, "mm⁴/s", "bending stiffness B/ξ∥", FITTED)
    stretching_mm2_s: float = _positive(
        8000.0, "mm²/s", "stretching stiffness EA/ξ∥", "numerical: gives by 0.5 % at most"
    )
    peristalsis_mm: float = _positive(
        1.0, "mm", "longest less shortest length, A_L", "paper, read as the whole change"
    )
    peristalsis_s: float = _positive(paper.PERISTALSIS_S, "s", "period T_L", "paper")
    undulation_mm: float = _positive(
        1.4,
        "mm",
        "amplitude A_T of a free worm's transverse wave",
        "paper, read as half its height",
    )
    undulation_s: float = _positive(paper.UNDULATION_S, "s", "period T_T", "paper")
    undulation_length_mm: float = _positive(
        24.0, "mm", "length of the wave", "v_w T_T of the paper: a wave that does not slip"
    )
    head_mm: float = _positive(3.0, "mm", "length of the head that bends to search", "assumed")
    head_bend_per_mm: float = _positive(
        0.38, "1/mm", "standard deviation of the head's curvature at rest", FITTED
    )
    head_turns_per_s: float = _positive(
        0.6, "1/s", "rate at which the head takes another one while it touches a wall", FITTED
    )
    lost_turns_per_s: float = _positive(
        1.5, "1/s", "the same while it touches none: it searches", FITTED
    )
    head_turn_s: float = _positive(0.15, "s", "time in which it bends there", "T_L/4")
    withdrawal_per_s: float = _positive(
        0.5, "1/s", "rate at which a head that touches a wall is withdrawn", FITTED
    )
    withdrawal_mm: float = _positive(
        4.5,
        "mm",
        "by how much its front half shortens then: mean of the exponential law, cut at 4.5 mm",
        FITTED,
    )
    withdrawal_s: float = _positive(0.3, "s", "time for which it does", "T_L/2")
    self_contact: bool = field(
        default=True,
        metadata={
            "unit": "yes/no",
            "meaning": "strands of the body lie beside each other; else they may overlap",
            "source": "the sheet is h = 1.5 mm high, both occur",
        },
    )

    def __post_init__(self) -> None:
        for item in fields(self):
            value, low = getattr(self, item.name), item.metadata.get("low", -inf)
            if not (isfinite(value) and value >= low):
                raise ValueError(f"{item.name} is {value}; it must be {low:g} or more")
        for name in ("length_mm", "width_mm", "head_turn_s", "peristalsis_s", "undulation_s"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0")
        if not (self.drag_ratio > 0.0 and self.undulation_length_mm > 0.0):
            raise ValueError("drag_ratio and undulation_length_mm must be above 0")
        if not self.peristalsis_mm < self.length_mm:
            raise ValueError(f"peristalsis_mm must be below length_mm = {self.length_mm:g}")
        if self.head_mm > self.length_mm or LEAST_LENGTH_WIDTHS * self.width_mm > self.length_mm:
            raise ValueError(
                f"length_mm is {self.length_mm:g}; it must be at least head_mm = {self.head_mm:g} "
                f"and {LEAST_LENGTH_WIDTHS:g} times width_mm = {self.width_mm:g}"
            )


def parameter_table(
    parameters: FilamentParameters,
) -> Iterator[tuple[str, float | bool, str, str, str]]:
    """Yield name, value, unit, meaning and source of every parameter."""
    for item in fields(parameters):
        told = item.metadata
        value = getattr(parameters, item.name)
        yield item.name, value, told["unit"], told["meaning"], told["source"]
