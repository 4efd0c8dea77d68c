"""The symbols as functions: signs, ranges, and the same for one frame as for many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from walked_tracks import BODY_WIDTH, GEOMETRY, THRESHOLD, R, track_from_polar

from worm_analysis.analysis import Analysis
from worm_analysis.kinematics.angular_speed import AngularSpeed
from worm_analysis.kinematics.observables import (
    body_angle,
    head_angle,
    incidence_angle,
    polar_angle,
    radial_distance,
    wrap_angle,
)
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py import Episode, EpisodeKind

NS = 10**9
angles = st.floats(-50, 50)
metres = st.floats(-0.02, 0.02)


@given(angles)
def test_wrapping_keeps_the_direction_and_the_range(angle):
    wrapped = wrap_angle(angle)
    assert -np.pi < wrapped <= np.pi
    assert np.cos(wrapped - angle) == pytest.approx(1.0)


def test_wrapping_takes_half_a_turn_to_plus_pi():
    assert wrap_angle(np.pi) == wrap_angle(-np.pi) == np.pi
    assert np.isnan(wrap_angle(np.nan))


@given(st.lists(st.tuples(metres, metres, metres, metres, angles), min_size=1, max_size=20))
def test_one_frame_and_many_frames_agree(rows):
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    x, y, other_x, other_y, yaw = columns
    for function, arguments in (
        (radial_distance, (x, y)),
        (polar_angle, (x, y)),
        (body_angle, (x, y, other_x, other_y)),
        (head_angle, (x, y, yaw)),
        (incidence_angle, (other_x, other_y, x, y)),
    ):
        together = function(*arguments)
        apart = [function(*(float(value) for value in row)) for row in zip(*arguments, strict=True)]
        np.testing.assert_allclose(together, apart, atol=1e-12)


@given(st.floats(-np.pi, np.pi), st.floats(-3, 3))
def test_the_angles_do_not_change_when_the_chamber_is_turned(turn, psi):
    head = R * np.exp(1j * turn)
    centroid = head - 2e-3 * np.exp(1j * (turn + psi))
    assert body_angle(head.real, head.imag, centroid.real, centroid.imag) == pytest.approx(psi)
    assert np.cos(head_angle(head.real, head.imag, turn + psi) - psi) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("centroid", "psi"),
    [((0.9 * R, 0.0), 0.0), ((R, -1e-3), np.pi / 2), ((R, 1e-3), -np.pi / 2)],
    ids=["straight out", "counter-clockwise along the wall", "clockwise along the wall"],
)
def test_the_sign_of_psi_b_for_a_head_at_theta_0(centroid, psi):
    assert body_angle(R, 0.0, *centroid) == pytest.approx(psi)


def test_the_speed_at_uneven_times_is_exact_for_a_constant_speed():
    rng = np.random.default_rng(0)
    stamps = np.cumsum(rng.integers(NS // 100, NS // 3, 200))
    speed = AngularSpeed(1.0)
    values = [speed.push(stamp, 0.3 * stamp / NS) for stamp in stamps.tolist()]
    covered = stamps - stamps[0] >= NS
    np.testing.assert_allclose(np.array(values)[covered], 0.3, rtol=1e-9)
    assert np.isnan(np.array(values)[~covered]).all()


def test_the_speed_holds_the_frames_of_its_window_only():
    speed = AngularSpeed(1.0)
    for frame in range(10_000):
        speed.push(frame * NS // 30, 0.0)
    assert len(speed._samples) <= 32


@pytest.mark.parametrize("angle_deg", [-60.0, 0.0, 25.0])
def test_the_incidence_is_that_of_the_way_to_the_wall(angle_deg):
    """The head comes straight to θ = 1 rad at the wall, at an angle to the normal there."""
    contact, direction = R * np.exp(1j * 1.0), np.exp(1j * (1.0 + np.radians(angle_deg)))
    way = contact - direction * 1e-4 * np.arange(20, -1, -1)
    t = np.arange(21) * 0.02
    track = track_from_polar(t, np.abs(way), np.angle(way), np.zeros(21))
    first = int(np.flatnonzero(R - np.abs(way) < THRESHOLD)[0])
    normal = np.angle(way[first])
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    for state in track.states():
        analysis.push(state)
    (contact_episode,) = [
        event
        for event in analysis.finish()
        if isinstance(event, Episode) and event.kind is EpisodeKind.CONTACT
    ]
    expected = 1.0 + np.radians(angle_deg) - normal
    assert contact_episode.incidence_rad == pytest.approx(expected, abs=1e-9)


def test_a_given_body_width_takes_the_place_of_the_measured_one():
    t = np.arange(0, 2, 0.1)
    track = track_from_polar(t, np.full(20, R - 0.5 * THRESHOLD), 0.2 * t + 1, np.zeros(20))
    for width, contact in ((None, True), (BODY_WIDTH / 3, False)):
        analysis = Analysis(AnalysisParameters(body_width_m=width))
        analysis.set_geometry(GEOMETRY)
        assert {analysis.push(state)[0].contact for state in track.states()} == {contact}


def test_contact_cannot_be_told_before_a_width_was_seen():
    t = np.arange(0, 1, 0.1)
    track = track_from_polar(t, np.full(10, R - 0.5 * THRESHOLD), 0.2 * t + 1, np.zeros(10))
    track.width[:4] = np.nan
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    contacts = [analysis.push(state)[0].contact for state in track.states()]
    assert contacts == [None] * 4 + [True] * 6
