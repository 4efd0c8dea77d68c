"""What the exact walk says on average: τ_h, skips, and the search after a withdrawal."""

from functools import lru_cache

from worm_model.boundary_walk.first_passage import SolvedWalk
from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.state import Direction, WalkState
from worm_msgs_py.paper import TRIAL_S


def mean_tau_h_s(walk: WalkParameters) -> float:
    """Return ⟨τ_h⟩ from a uniform start, s."""
    return _means(walk)[0]


def skips_per_trial(walk: WalkParameters) -> float:
    """Return the skips in 30 min of searching: skips per passage over time per passage."""
    mean_s, skips = _means(walk)
    return TRIAL_S * skips / mean_s


def mean_again_s(walk: WalkParameters) -> float:
    """Return the mean time to the exit of a head that has withdrawn from it, s.

    It slides on from the exit's edge, away from the exit; the two ways are mirror images.
    """
    edge_rad = walk.exit_edge_rad
    start = WalkState(edge_rad, Direction.COUNTER_CLOCKWISE)
    return SolvedWalk(walk).first_passage(start).mean_s


@lru_cache(maxsize=256)
def _means(walk: WalkParameters) -> tuple[float, float]:
    """Return ⟨τ_h⟩ and the skips of a passage: whoever asks for one asks for the other."""
    passage = SolvedWalk(walk).first_passage()
    return passage.mean_s, passage.skips
