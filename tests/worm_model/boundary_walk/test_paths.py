"""Paths are those of the Monte Carlo: even speed, corners, and the exit at their end."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from worm_model.boundary_walk.monte_carlo import simulate_walks
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.boundary_walk.paths import walk_paths
from worm_model.boundary_walk.state import Direction, Phase, WalkState

PAPER = WalkParameters()


@pytest.mark.parametrize("rule", list(ReversalRule))
@pytest.mark.parametrize("lands", [True, False])
def test_a_path_is_a_walk_of_the_monte_carlo(rule, lands):
    walk = replace(PAPER, rule=rule, hop_may_land=lands)
    paths = walk_paths(walk, 20, seed=1)
    result = simulate_walks(walk, 20, seed=1)
    np.testing.assert_array_equal([path.t_s[-1] for path in paths], result.tau_h_s)
    for path in paths:
        assert path.found
        gone_mm = np.abs(np.diff(path.theta_rad)) * walk.radius_mm
        np.testing.assert_allclose(gone_mm, walk.speed_mm_s * np.diff(path.t_s), atol=1e-9)
        past = (path.theta_rad[-1] + pi) % (2 * pi) - pi
        assert abs(past) * walk.radius_mm <= walk.exit_arc_mm / 2 + 1e-6
        # A slide ends at the exit's edge; only a hop may land within it.
        if abs(past) * walk.radius_mm < walk.exit_arc_mm / 2 - 1e-6:
            assert lands
            assert path.hopping[-1]


def test_a_path_starts_in_its_state_and_can_be_given_up():
    start = WalkState(pi / 2, Direction.CLOCKWISE, Phase.HOP)
    (path,) = walk_paths(PAPER, 1, seed=0, start=start, horizon_s=0.5)
    assert path.theta_rad[0] == pytest.approx(pi / 2)
    assert path.theta_rad[1] < path.theta_rad[0]
    assert path.hopping[0]
    assert not path.found
    with pytest.raises(ValueError, match="at least 1"):
        walk_paths(PAPER, 0, seed=0)
