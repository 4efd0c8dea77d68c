"""Films of folds are drawn once, and anew where what is kept is no longer what would be drawn."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from benchmarks import fold_conditions, fold_films
from benchmarks.drawn_by_distance import DistanceLook, steered_pictures
from benchmarks.drawn_lines import POINTS, LineLook, coverage, light_and_wall, picture_of
from benchmarks.fold_conditions import CONDITIONS
from benchmarks.fold_films import fold_film
from benchmarks.steered_path import RADIUS_MM
from benchmarks.steered_worm import SteeredWorm, steered_worm


def test_a_film_is_kept_with_its_truth_until_the_drawing_changes(tmp_path, monkeypatch):
    motion = fold_films._motion("4001")
    short = replace(motion, midlines_mm=motion.midlines_mm[290:303])
    monkeypatch.setattr(fold_films, "_motion", lambda name: short)
    film = fold_film("4001", "coarse", tmp_path)
    (kept,) = tmp_path.iterdir()
    drawn_at = kept.stat().st_mtime_ns
    again = fold_film("4001", "coarse", tmp_path)
    assert kept.stat().st_mtime_ns == drawn_at
    np.testing.assert_array_equal(film.picture(12), again.picture(12))

    assert len(film) == 13
    assert film.folded[0]
    assert not film.folded[-1]  # a loop that opens
    assert np.diff(film.stamp_ns).tolist() == [40_000_000] * 12
    u, v = np.rint(film.midline_px[12, 20:-20]).astype(int).T
    assert np.median(film.picture(12)[v, u]) < 80

    other = replace(short, width_mm=0.9 * short.width_mm)
    monkeypatch.setattr(fold_films, "_motion", lambda name: other)
    assert fold_film("4001", "coarse", tmp_path).width_px < film.width_px


def test_lines_are_darker_where_they_cross_and_not_beside_a_hairpin():
    look = LineLook(px_per_mm=10.0, noise=0.0)
    turn = np.linspace(-np.pi / 2, 3 * np.pi / 2, 400)[:, np.newaxis]
    loop = np.c_[30 * np.cos(turn), 30 * np.sin(turn)] + [100.0, 130.0]
    arm = np.linspace(-60.0, 0.0, 150)[:, np.newaxis]
    crossing = np.r_[arm * [1, 0] + [100, 100], loop, -arm[::-1] * [1, 0] + [100, 100]]
    hairpin = np.r_[arm * [1, 0] + [120, 100], -arm[::-1] * [-1, 0] + [120, 101.0]]
    light, wall = light_and_wall(look)
    greys = []
    for line in (crossing, hairpin):
        at = np.linspace(0, len(line) - 1, POINTS)
        even = np.c_[
            np.interp(at, np.arange(len(line)), line[:, 0]),
            np.interp(at, np.arange(len(line)), line[:, 1]),
        ]
        greys.append(picture_of(even, np.full(POINTS, 6.0), look, light, wall, seed=0))
    crossed, folded = greys
    once = 0.45 * light[100, 60]
    assert crossed[100, 60] == pytest.approx(once, rel=0.05)
    assert crossed[100, 100] < 0.75 * once
    assert folded[100, 118] == pytest.approx(once, rel=0.1)


@pytest.mark.parametrize("width", [1.6, 4.0, 9.0, 12.4])
@pytest.mark.parametrize("heading", [0.0, 0.35, 0.8])
def test_a_line_is_as_broad_as_it_is_said_to_be(width, heading):
    along = np.linspace(-80.0, 80.0, 300)[:, np.newaxis]
    line = np.array([100.3, 100.7]) + along * [np.cos(heading), np.sin(heading)]
    covered = coverage(line, np.full(len(line), width), (200, 200))
    ends = np.pi / 4 * width**2
    assert (covered.sum() - ends) / 160.0 == pytest.approx(width, abs=0.27)


@pytest.fixture(scope="module")
def worm():
    return steered_worm(24)


def test_a_steered_worm_stays_in_the_chamber_and_keeps_about_its_length(worm):
    again = steered_worm(24)
    np.testing.assert_array_equal(worm.midlines_mm, again.midlines_mm)
    assert np.hypot(*np.moveaxis(worm.midlines_mm, 2, 0)).max() < RADIUS_MM
    lengths = np.hypot(*np.moveaxis(np.diff(worm.midlines_mm, axis=1), 2, 0)).sum(axis=1)
    assert np.abs(np.log(lengths / lengths.mean())).max() < 0.15
    moved = np.hypot(*np.moveaxis(np.diff(worm.midlines_mm, axis=0), 2, 0))
    assert moved.max() < worm.width_mm.max()


@pytest.mark.parametrize("is_one_shade", [False, True])
def test_a_body_drawn_by_distance_is_as_broad_as_it_is_and_darker_where_it_crosses(is_one_shade):
    along = np.linspace(-5.0, 5.0, 200)
    there = np.stack([along, np.zeros(200)], axis=1)
    back = np.stack([np.zeros(201), np.linspace(5.0, -5.0, 201)], axis=1)
    line_mm = np.concatenate([there, back])
    worm = SteeredWorm(line_mm[np.newaxis], np.full(401, 0.6), np.ones(401))
    look = DistanceLook(px_per_mm=20.0, noise=0.0, is_one_shade=is_one_shade)
    (picture, line), *_ = steered_pictures(worm, look, seed=0)
    u, v = np.rint(look.centre).astype(int)
    once, twice = float(picture[v, u - 40]), float(picture[v, u])
    assert (twice < 0.7 * once) is not is_one_shade
    across = picture[v - 12 : v + 13, u - 40].astype(float)
    depth = -np.log(across / np.median(across[[0, 1, -2, -1]]))
    dye = 0.35 + 0.65 * np.pi / 4  # of a cylinder, mean over its width
    assert depth.sum() / look.depth == pytest.approx(0.6 * 20.0 * dye, rel=0.1)
    assert np.hypot(*np.diff(line, axis=0).T).max() > 1


def test_a_steered_worm_is_filmed_in_a_real_skin_where_it_is(worm, monkeypatch):
    monkeypatch.setattr(fold_films, "steered_worm", lambda seed: worm)
    film, true = fold_films._drawn("s24", "skin_w5", frames=1), worm.midlines_mm[0]
    picture = cv2.imdecode(film["jpeg"], cv2.IMREAD_GRAYSCALE)
    line = film["midline_px"][0]
    length_px = np.hypot(*np.diff(line, axis=0).T).sum()
    length_mm = np.hypot(*np.diff(true, axis=0).T).sum()
    assert length_px / film["px_per_mm"] == pytest.approx(length_mm, rel=0.01)
    aside = np.gradient(line, axis=0)[:, ::-1] * [-1, 1]
    aside *= 1.5 * film["width_px"] / np.hypot(*aside.T)[:, np.newaxis]
    on_it, left, right = (
        np.median(picture[tuple(np.rint(line + way * aside).astype(int).T[::-1])])
        for way in (0, 1, -1)
    )
    assert on_it < 0.8 * max(left, right)


@pytest.fixture
def short_film(tmp_path, monkeypatch):
    motion = fold_films._motion("4001")
    short = replace(motion, midlines_mm=motion.midlines_mm[290:295])
    monkeypatch.setattr(fold_films, "_motion", lambda name: short)
    return fold_film("4001", "coarse", tmp_path)


def test_a_film_at_half_its_frame_rate_keeps_each_picture_with_its_truth(short_film):
    half = CONDITIONS["half_rate"](short_film)
    assert len(half) == 3
    assert np.diff(half.stamp_ns).tolist() == [80_000_000] * 2
    for frame in range(3):
        np.testing.assert_array_equal(half.picture(frame), short_film.picture(2 * frame))
        np.testing.assert_array_equal(half.midline_px[frame], short_film.midline_px[2 * frame])


def test_a_film_with_gaps_keeps_what_is_left_with_its_truth(short_film, monkeypatch):
    for name, value in (("KNOWN_AFTER", 1), ("GAP_EVERY", 4), ("GAP", 2)):
        monkeypatch.setattr(fold_conditions, name, value)
    left = CONDITIONS["gaps"](short_film)
    assert np.diff(left.stamp_ns).tolist() == [40_000_000, 120_000_000]
    for frame, kept in enumerate((0, 1, 4)):
        np.testing.assert_array_equal(left.picture(frame), short_film.picture(kept))
        np.testing.assert_array_equal(left.midline_px[frame], short_film.midline_px[kept])


@pytest.mark.parametrize("condition", ["vibrating", "unfocused", "noisy"])
def test_a_film_in_another_condition_shows_the_same_worm(short_film, condition):
    shown = CONDITIONS[condition](short_film)
    assert len(shown) == len(short_film)
    u, v = np.rint(shown.midline_px[4, 20:-20]).astype(int).T
    assert np.median(shown.picture(4)[v, u]) < 90
    assert not np.array_equal(shown.picture(4), short_film.picture(4))
