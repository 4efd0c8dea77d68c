"""A trial is one life of a worm: the same for a seed, seen at any rate, and it gets out."""

from itertools import islice
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wall_distances import wall_distance_mm

from worm_model.filament.parameters import FilamentParameters, parameter_table
from worm_model.filament.rig import FilamentRig
from worm_model.filament.sources_number import sources_number
from worm_model.filament.trial import frames, simulate

WORM, RIG = FilamentParameters(), FilamentRig(exit_width_mm=3.0)


@pytest.fixture(scope="module")
def trial():
    return simulate(WORM, RIG, seed=1, duration_s=420.0, frames_per_s=10.0)


def test_the_same_seed_gives_the_same_bytes_and_another_one_another_life():
    first, again, other = (
        simulate(WORM, RIG, seed=seed, duration_s=3.0, frames_per_s=30.0) for seed in (5, 5, 6)
    )
    assert first.midline_mm.tobytes() == again.midline_mm.tobytes()
    assert np.abs(first.midline_mm - other.midline_mm).max() > 1.0


def test_frames_one_by_one_are_those_of_the_whole_trial():
    whole = simulate(WORM, RIG, seed=5, duration_s=2.5, frames_per_s=12.0)
    live = list(frames(WORM, RIG, seed=5, duration_s=2.5, frames_per_s=12.0))
    assert len(live) == len(whole.t_s) == 30
    assert np.array_equal(np.stack(live), whole.midline_mm)


def test_a_life_without_end_can_be_watched():
    assert len(list(islice(frames(WORM, RIG, seed=1, duration_s=inf, frames_per_s=2.0), 5))) == 5


def test_the_life_does_not_depend_on_how_often_it_is_seen():
    slow = simulate(WORM, RIG, seed=2, duration_s=4.0, frames_per_s=10.0)
    fast = simulate(WORM, RIG, seed=2, duration_s=4.0, frames_per_s=70.0)
    assert fast.midline_mm[::7] == pytest.approx(slow.midline_mm, abs=1e-9)


def test_the_worm_gets_through_the_passage_into_the_other_chamber(trial):
    far = RIG.far_centre_mm
    in_b = np.all(np.hypot(trial.midline_mm[..., 0] - far, trial.midline_mm[..., 1]) < 10, axis=1)
    assert in_b.any()
    assert trial.withdrawing.any()
    assert not trial.withdrawing.all()


def test_no_point_is_in_a_wall(trial):
    points = trial.midline_mm[::20].reshape(-1, 2)
    assert wall_distance_mm(points, RIG).min() > 0.0


def test_the_head_moves_no_faster_than_a_worm_can(trial):
    speed = np.hypot(*np.diff(trial.midline_mm[:, 0], axis=0).T) * 10.0
    assert speed.max() < 50.0


def test_every_parameter_has_a_unit_a_meaning_and_a_source():
    rows = list(parameter_table(WORM))
    assert len(rows) == len(WORM.__dataclass_fields__)
    assert all(unit and meaning and source for _, _, unit, meaning, source in rows)


@pytest.mark.parametrize(
    "wrong",
    [
        {"length_mm": 0.0},
        {"bending_mm4_s": -1.0},
        {"segments": 2},
        {"drag_ratio": 0.0},
        {"peristalsis_mm": 20.0},
        {"head_turn_s": float("nan")},
    ],
)
def test_numbers_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        FilamentParameters(**wrong)


def test_the_machine_code_is_tied_to_all_of_its_sources(tmp_path, monkeypatch):
    (tmp_path / "a.py").write_text("A = 1")
    monkeypatch.setattr("worm_model.filament.sources_number.__file__", str(tmp_path / "b"))
    before = sources_number()
    (tmp_path / "a.py").write_text("A = 2")
    assert sources_number() != before


@pytest.mark.parametrize(
    "numbers", [{"length_mm": 1.2}, {"length_mm": 2.0}, {"length_mm": 10.0, "width_mm": 3.0}]
)
def test_a_body_that_is_no_slender_line_is_refused(numbers):
    with pytest.raises(ValueError, match="length_mm is"):
        FilamentParameters(**numbers)


def test_a_body_does_not_pass_an_exit_of_less_than_half_its_width():
    with pytest.raises(ValueError, match=r"exit_width_mm is 0\.2"):
        simulate(
            FilamentParameters(width_mm=0.5),
            FilamentRig(exit_width_mm=0.2),
            seed=0,
            duration_s=1.0,
            frames_per_s=10.0,
        )


@settings(max_examples=8, deadline=None)
@given(st.floats(3.0, 60.0), st.floats(0.05, 0.25), st.floats(0.3, 10.0), st.integers(0, 99))
def test_a_worm_of_any_allowed_shape_stays_finite_and_in_the_water(length, slender, speed, seed):
    width = slender * length
    rig = FilamentRig(exit_width_mm=min(max(2.0, width), 12.0))
    worm = FilamentParameters(length_mm=length, width_mm=min(width, 5.0), crawl_speed_mm_s=speed)
    trial = simulate(worm, rig, seed=seed, duration_s=5.0, frames_per_s=10.0)
    x, y = np.moveaxis(trial.midline_mm, -1, 0)
    in_passage = (np.abs(y) <= 0.5 * rig.exit_width_mm + 0.02) & (x > 0) & (x < rig.far_centre_mm)
    in_chamber = np.minimum(np.hypot(x, y), np.hypot(x - rig.far_centre_mm, y)) <= 10.02
    assert np.isfinite(trial.midline_mm).all()
    assert (in_chamber | in_passage).all()
