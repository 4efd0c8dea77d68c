"""The filament keeps the laws of an overdamped elastic line: closed forms, symmetry, steps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solveh_banded
from wall_distances import wall_distance_mm

from worm_model.filament.mechanics import BAND_DIAGONALS, solve_band
from worm_model.filament.motion import FilamentMotion, clearance_mm
from worm_model.filament.parameters import FilamentParameters, FilamentSettings
from worm_model.filament.rig import FilamentRig
from worm_model.filament.strokes import (
    BEND_NOISE,
    HEAD_AIM,
    HEAD_BEND,
    LENGTH_NOISE,
    NOISE_SIZE,
    ONSET_NOISE,
    STATE_SIZE,
    TURN_NOISE,
    UNDULATION_RAD,
)

OPEN = FilamentRig(radius_mm=1e6, exit_width_mm=0.0)
PASSIVE = FilamentParameters(
    crawl_speed_mm_s=0.0,
    peristalsis_mm=0.0,
    undulation_mm=0.0,
    head_bend_per_mm=0.0,
    withdrawal_per_s=0.0,
)
STEP_S = 0.0025
AT_EXIT = np.array([10.4, 0.0])
"""Of the head of a worm that lies along the x axis: its tail is inside of the wall, too."""


def straight(parameters):
    s = np.linspace(0.0, parameters.length_mm, parameters.segments + 1)
    return np.c_[-s, 0.0 * s]


def moved(parameters, points, duration_s, rig=OPEN, step_s=STEP_S, activity=None, noise=None):
    state = np.zeros(STATE_SIZE) if activity is None else activity
    motion = FilamentMotion(parameters, rig, points, state, step_s)
    if noise is None:
        noise = np.zeros((round(duration_s / step_s), NOISE_SIZE))
    return motion.advance(noise)


def length_mm(points):
    return np.hypot(*np.diff(points, axis=-2).T).sum(axis=0)


def random_noise(steps, seed):
    draw = np.random.default_rng(seed)
    noise = np.empty((steps, NOISE_SIZE))
    noise[:, BEND_NOISE] = draw.standard_normal(steps)
    noise[:, [TURN_NOISE, ONSET_NOISE]] = draw.random((steps, 2))
    noise[:, LENGTH_NOISE] = draw.standard_exponential(steps)
    return noise


def test_the_band_solver_solves():
    draw = np.random.default_rng(3)
    band = draw.normal(size=(40, BAND_DIAGONALS))
    band[:, 0] = 20.0
    right = draw.normal(size=40)
    expected = solveh_banded(band.T, right, lower=True)
    solve_band(band, right)
    assert right == pytest.approx(expected, rel=1e-10)


def test_a_straight_free_worm_crawls_at_the_stated_speed():
    crawler = replace(PASSIVE, crawl_speed_mm_s=2.02)
    path = moved(crawler, straight(crawler), 5.0).points_mm
    velocity = (path[-1] - path[-401]) / (400 * STEP_S)
    assert velocity[:, 0] == pytest.approx(2.02, rel=1e-6)
    assert velocity[:, 1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
def test_a_bow_straightens_the_more_slowly_the_larger_the_drag_across(ratio):
    """In linear theory all motion is across the line: times grow as ξ⊥/ξ∥, in one proportion."""
    times = []
    for each in (1.0, ratio):
        bent = replace(PASSIVE, drag_ratio=each)
        s = np.linspace(-1.0, 1.0, bent.segments + 1)
        points = np.c_[-10.0 * s, 0.05 * np.cos(np.pi * s)]
        y = moved(bent, points, 2.0).points_mm[:, :, 1]
        bow = y[:, 0] - 2.0 * y[:, bent.segments // 2] + y[:, -1]
        late = len(bow) // 2
        times.append(
            1.0 / -np.polyfit(np.arange(late, len(bow)) * STEP_S, np.log(-bow[late:]), 1)[0]
        )
    assert times[1] / times[0] == pytest.approx(ratio, rel=0.02)


def test_a_bent_free_filament_relaxes_as_linear_theory_says():
    """The slowest mode of a free beam: (4.730/L)⁴ B/ξ⊥."""
    theory = (4.730041 / PASSIVE.length_mm) ** 4 * PASSIVE.bending_mm4_s / PASSIVE.drag_ratio
    s = np.linspace(0.0, 1.0, PASSIVE.segments + 1)
    beta = 4.730041
    sigma = 0.982502
    mode = np.cosh(beta * s) + np.cos(beta * s) - sigma * (np.sinh(beta * s) + np.sin(beta * s))
    points = np.c_[-PASSIVE.length_mm * s, 0.02 * mode]
    y = moved(PASSIVE, points, 1.0).points_mm[:, :, 1]
    amplitude = y @ mode / (mode @ mode)
    rate = -np.log(amplitude[-1] / amplitude[0]) / ((len(amplitude) - 1) * STEP_S)
    assert rate == pytest.approx(theory, rel=0.05)


def test_a_passive_filament_only_loses_energy():
    draw = np.random.default_rng(5)
    turn = np.cumsum(draw.normal(0.0, 0.15, PASSIVE.segments))
    ds = PASSIVE.length_mm / PASSIVE.segments
    points = np.r_[[[0.0, 0.0]], np.cumsum(-ds * np.c_[np.cos(turn), np.sin(turn)], axis=0)]
    loose = replace(PASSIVE, self_contact=False)
    path = moved(loose, points, 2.0).points_mm
    bend = path[:, :-2] - 2.0 * path[:, 1:-1] + path[:, 2:]
    stretch = np.hypot(*np.diff(path, axis=1).transpose(2, 0, 1)) - ds
    energy = 0.5 * PASSIVE.bending_mm4_s * (bend**2).sum(axis=(1, 2)) / ds**3
    energy += 0.5 * PASSIVE.stretching_mm2_s * (stretch**2).sum(axis=1) / ds
    assert np.all(np.diff(energy) <= 1e-9 * energy[0])
    assert energy[-1] < 0.5 * energy[0]


def test_halving_the_time_step_halves_the_error():
    worm = replace(FilamentParameters(), withdrawal_per_s=0.0, head_bend_per_mm=0.0)
    activity = np.zeros(STATE_SIZE)
    activity[UNDULATION_RAD] = 1.0
    ends = [
        moved(worm, straight(worm), 3.0, step_s=h, activity=activity).points_mm[-1]
        for h in (0.02, 0.01, 0.005, 0.000625)
    ]
    error = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert error[0] / error[1] == pytest.approx(2.0, rel=0.2)
    assert error[1] / error[2] == pytest.approx(2.0, rel=0.25)
    assert error[2] < 0.05


def test_mirrored_noise_gives_the_mirrored_worm():
    worm, rig = FilamentParameters(), FilamentRig(exit_width_mm=1.0)
    points = straight(worm) + np.array([10.4, 0.2])
    activity = np.zeros(STATE_SIZE)
    activity[[UNDULATION_RAD, HEAD_BEND, HEAD_AIM]] = 0.4, 0.1, 0.3
    noise = random_noise(2000, seed=7)
    path = moved(worm, points, 0.0, rig, activity=activity, noise=noise).points_mm
    activity[UNDULATION_RAD] += np.pi
    activity[[HEAD_BEND, HEAD_AIM]] *= -1.0
    noise[:, BEND_NOISE] *= -1.0
    other = moved(worm, points * [1, -1], 0.0, rig, activity=activity, noise=noise).points_mm
    assert other * [1, -1] == pytest.approx(path, abs=1e-6)
    assert np.abs(path[-1] - points).max() > 1.0


def test_the_length_follows_the_peristaltic_stroke_and_nothing_else():
    worm = replace(FilamentParameters(), withdrawal_per_s=0.0)
    rig = FilamentRig(exit_width_mm=1.0)
    path = moved(worm, straight(worm) + AT_EXIT, 0.0, rig, noise=random_noise(8000, 1)).points_mm
    t = STEP_S * np.arange(1, len(path) + 1)
    rest = worm.length_mm + 0.5 * worm.peristalsis_mm * np.sin(2 * np.pi * t / worm.peristalsis_s)
    assert np.abs(length_mm(path) / rest - 1.0).max() < 0.015


def test_a_touch_may_shorten_the_front_of_the_body_and_nothing_lengthens_it():
    worm, rig = FilamentParameters(), FilamentRig(exit_width_mm=1.0)
    path = moved(worm, straight(worm) + AT_EXIT, 0.0, rig, noise=random_noise(8000, 1)).points_mm
    longest = worm.length_mm + 0.5 * worm.peristalsis_mm
    rear = worm.segments * 3 // 5
    assert length_mm(path).max() < 1.01 * longest
    assert length_mm(path).min() < worm.length_mm - 1.5 * worm.peristalsis_mm
    assert np.abs(length_mm(path[:, rear:]) / (0.4 * worm.length_mm) - 1.0).max() < 0.04


def test_no_point_of_the_body_is_nearer_to_a_wall_than_half_its_width():
    worm, rig = FilamentParameters(), FilamentRig(exit_width_mm=1.0)
    path = moved(worm, straight(worm) + AT_EXIT, 0.0, rig, noise=random_noise(8000, 2)).points_mm
    clearance = clearance_mm(worm, rig)
    for points in path[::40]:
        assert np.all(wall_distance_mm(points, rig) > clearance - 1e-6)


def test_a_test_can_change_a_setting_of_the_body():
    settings = FilamentSettings(squeezed_width=0.5)
    clearance = clearance_mm(FilamentParameters(), FilamentRig(exit_width_mm=0.4), settings)
    assert clearance.max() == pytest.approx(0.1)


def closest_strands_mm(points, apart):
    distance = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    i, j = np.indices(distance.shape)
    return distance[np.abs(i - j) >= apart].min()


@pytest.mark.parametrize("contact", [True, False])
def test_a_body_that_coils_lies_beside_itself_or_over_itself_as_told(contact):
    """Curvature at rest of 1/2 mm all along: 20 mm make one turn and a half."""
    long_wave = 1000.0
    coiling = replace(
        PASSIVE,
        self_contact=contact,
        undulation_s=1e9,
        undulation_length_mm=long_wave,
        undulation_mm=0.5 / (2 * np.pi / long_wave) ** 2,
    )
    activity = np.zeros(STATE_SIZE)
    activity[UNDULATION_RAD] = np.pi / 2
    path = moved(coiling, straight(coiling), 30.0, activity=activity).points_mm
    found = min(closest_strands_mm(points, 8) for points in path[::100])
    if contact:
        assert found > 0.65 * coiling.width_mm
    else:
        assert found < 0.5 * coiling.width_mm
