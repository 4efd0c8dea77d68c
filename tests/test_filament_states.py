"""The states of a simulated filament say in metres and in pixels the same places."""

import numpy as np
import pytest
from benchmarks.filament_states import centroids, geometry_of, lengths_mm, states_of_filament

from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import FilamentTrial
from worm_msgs_py import Where

RIG = FilamentRig(exit_width_mm=2.0)


def lying(*heads_mm):
    """Return a trial of a straight worm along x, its tail towards chamber A."""
    s = np.linspace(0.0, 20.0, 51)
    midline = np.stack([np.stack([x - s, y + 0.0 * s], axis=1) for x, y in heads_mm])
    n = len(midline)
    worm = FilamentParameters()
    return FilamentTrial(np.arange(n) / 30, midline, np.zeros(n, dtype=bool), RIG, worm, 0)


def test_metres_in_the_frame_of_a_chamber_are_those_of_the_pixels():
    trial = lying((9.0, 0.5), (20.0, 0.2), (50.0, -0.8), (60.0, 3.0))
    geometry = geometry_of(trial)
    for state in states_of_filament(trial):
        chamber = geometry.chamber(state.frame_id)
        for point in (state.head, state.centroid, state.tail):
            assert chamber.to_metres(point.u_px, point.v_px) == pytest.approx(
                (point.x_m, point.y_m), abs=1e-12
            )


def test_the_head_is_where_it_is():
    states = list(states_of_filament(lying((9.0, 0.5), (20.0, 0.2), (44.0, 0.0), (60.0, 3.0))))
    expected = [Where.CHAMBER_A, Where.PASSAGE, Where.PASSAGE, Where.CHAMBER_B]
    assert [state.where for state in states] == expected
    assert states[3].head.x_m == pytest.approx(-0.005)
    assert states[3].head.y_m == pytest.approx(-0.003)


def test_headings_lead_to_the_head_in_either_frame():
    to_exit, from_exit = states_of_filament(lying((9.0, 0.5), (60.0, 3.0)))
    for point in (to_exit.head, to_exit.centroid, to_exit.tail):
        assert point.yaw_rad == pytest.approx(0.0, abs=1e-12)
    for point in (from_exit.head, from_exit.centroid, from_exit.tail):
        assert abs(point.yaw_rad) == pytest.approx(np.pi)


def test_the_centroid_weighs_each_part_by_its_length():
    corner = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 3.0]]])
    assert centroids(corner)[0] == pytest.approx([(0.5 + 3.0) / 4.0, 4.5 / 4.0])
    assert lengths_mm(corner) == pytest.approx(4.0)
