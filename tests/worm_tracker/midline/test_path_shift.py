"""A path is moved to its cross-sections' middles as the definition of the cost says."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from worm_tracker.midline.cross_sections import CrossSections
from worm_tracker.midline.path_shift import (
    PathShiftSettings,
    _solve_shifts,
    moved_to_middle,
)


@given(
    seed=st.integers(0, 2**32 - 1),
    nodes=st.integers(5, 80),
    unseen=st.floats(0.01, 2.0),
    turn=st.floats(0.0, 20.0),
    bend=st.floats(0.0, 50.0),
)
def test_no_other_shifts_cost_less(seed, nodes, unseen, turn, bend):
    rng = np.random.default_rng(seed)
    weight = rng.uniform(0.0, 3.0, nodes) * (rng.random(nodes) < 0.7)
    wanted = rng.normal(0.0, 4.0, nodes)
    first = np.diff(np.eye(nodes), axis=0)
    second = np.diff(np.eye(nodes), 2, axis=0)
    cost = np.diag(weight + unseen) + turn * first.T @ first + bend * second.T @ second
    shift = np.empty(nodes)
    _solve_shifts(weight, wanted, unseen, turn, bend, shift)
    assert_allclose(shift, np.linalg.solve(cost, weight * wanted), atol=1e-8)


def test_a_path_beside_an_arc_comes_onto_it():
    angle = np.linspace(0.0, 2.0, 120)
    arc, beside = 80 * np.exp(1j * angle), 77 * np.exp(1j * angle)
    seen = CrossSections(np.full(120, -3.0), np.full(120, 4.0), np.zeros(120, np.float32))
    step = float(np.abs(np.diff(beside)).mean())
    moved = moved_to_middle(beside, step, seen, 16.0, PathShiftSettings())
    assert np.abs(np.abs(moved) - np.abs(arc).mean()).max() < 0.1
    steps = np.abs(np.diff(moved))
    assert_allclose(steps, steps.mean(), rtol=1e-3)
