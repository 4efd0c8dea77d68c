"""What lies ahead of a walk's state, seen along its own direction: mirror images are one."""

from dataclasses import dataclass
from math import pi, remainder

from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.state import Direction, Phase, WalkState


@dataclass(frozen=True, slots=True)
class RelativeState:
    """A state seen along its own direction: mirror images are one.

    Attributes
    ----------
    ahead_mm : float
        Length of wall up to the exit; above the exit, length of the exit's arc still ahead.
    hopping : bool
        Its phase.
    over_exit : bool
        Whether it is above the exit.
    """

    ahead_mm: float
    hopping: bool
    over_exit: bool


def relative_state_of(state: WalkState, parameters: WalkParameters) -> RelativeState:
    """Return what lies ahead of a state.

    Raises
    ------
    ValueError
        Where a slide is said to be in the exit: it has found it.
    """
    ring, arc = parameters.circumference_mm, parameters.exit_arc_mm
    hopping = state.phase is Phase.HOP
    turn = 1.0 if state.direction is Direction.COUNTER_CLOCKWISE else -1.0
    # Distance past the exit's middle, the way it goes: from −πR to πR.
    past = turn * parameters.radius_mm * remainder(state.theta_rad, 2.0 * pi)
    if abs(past) >= arc / 2.0:
        ahead = -past - arc / 2.0 if past < 0.0 else ring - past - arc / 2.0
        return RelativeState(min(max(ahead, 0.0), parameters.wall_mm), hopping, over_exit=False)
    if not hopping:
        raise ValueError(
            f"theta is {state.theta_rad:g} rad, within the exit's arc of ±{arc / ring * pi:.4g} "
            "rad: a head that slides there has found the exit; give another angle, or a hop"
        )
    return RelativeState(arc / 2.0 - past, hopping, over_exit=True)
