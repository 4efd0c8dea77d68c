"""Distances from the walls are those of the two discs and the passage, drawn point by point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wall_distances import wall_distance_mm

from worm_model.filament.rig import FilamentRig
from worm_model.filament.walls import Walls, push_out

RIG = FilamentRig(exit_width_mm=2.0)


def in_the_water(points, rig):
    x, y = points.T
    in_a = np.hypot(x, y) <= rig.radius_mm
    in_b = np.hypot(x - rig.far_centre_mm, y) <= rig.radius_mm
    between = (np.abs(y) <= rig.exit_width_mm / 2) & (x > 0) & (x < rig.far_centre_mm)
    return in_a | in_b | between


def outline(rig):
    """Return points close together on the whole outline of the water."""
    half = rig.exit_width_mm / 2
    edge = np.arcsin(half / rig.radius_mm)
    theta = np.linspace(edge, 2 * np.pi - edge, 40_000)
    a = rig.radius_mm * np.c_[np.cos(theta), np.sin(theta)]
    mouth = rig.radius_mm * np.cos(edge)
    x = np.linspace(mouth, rig.far_centre_mm - mouth, 40_000)
    b = np.c_[rig.far_centre_mm - a[:, 0], a[:, 1]]
    return np.concatenate([a, b, np.c_[x, 0 * x + half], np.c_[x, 0 * x - half]])


OUTLINE = outline(RIG)


@given(st.floats(-9.9, 64.9), st.floats(-9.9, 9.9))
def test_the_distance_of_a_point_in_the_water_is_that_of_the_nearest_point_of_the_outline(x, y):
    point = np.array([[x, y]])
    if in_the_water(point, RIG)[0]:
        nearest = np.hypot(*(OUTLINE - point).T).min()
        assert wall_distance_mm(point, RIG)[0] == pytest.approx(nearest, abs=2e-3)
    else:
        assert wall_distance_mm(point, RIG)[0] <= 0


@given(st.floats(-10.2, 65.2), st.floats(-10.2, 10.2), st.sampled_from([0.5, 2.0, 5.0]))
def test_a_point_that_is_pushed_out_of_the_wall_is_in_the_water(x, y, exit_width_mm):
    rig = FilamentRig(exit_width_mm=exit_width_mm)
    point = np.array([[x, y]])
    if wall_distance_mm(point, rig)[0] > -0.2:
        push_out(point, np.array([0.1]), Walls.of(rig))
        assert wall_distance_mm(point, rig)[0] >= 0.1 - 1e-9


def test_a_closed_chamber_has_a_round_wall():
    theta = np.linspace(0, 2 * np.pi, 50)
    points = 9.5 * np.c_[np.cos(theta), np.sin(theta)]
    assert wall_distance_mm(points, FilamentRig(exit_width_mm=0.0)) == pytest.approx(0.5)


@pytest.mark.parametrize(
    "wrong", [{"radius_mm": 0.0}, {"exit_width_mm": 20.0}, {"passage_length_mm": -1.0}]
)
def test_a_rig_that_cannot_be_is_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        FilamentRig(**wrong)
