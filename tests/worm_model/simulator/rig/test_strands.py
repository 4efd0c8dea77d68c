"""What is drawn of a folded body is what its midline, its widths and its looks say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_model.simulator.rig import Optics, Rig, clear_view
from worm_model.simulator.rig.strands import (
    Shade,
    Skin,
    covered,
    is_folded,
    polyline_body,
    shaded_view,
    skinned_view,
    strands_over,
)

SHARP = Rig(
    width_px=500,
    height_px=500,
    px_per_mm=24.0,
    centre_px=(249.5, 249.5),
    optics=Optics(light=200.0, gradient=(0.0, 0.0), blur_px=0.0, noise=0.0, worm_transmission=0.3),
)
WATER, ONE, TWO = 200.0, 60.0, 18.0  # grey levels under no, one and two strands
WIDTH_PX = 12.0


def tapered(count):
    part = np.linspace(0.0, 1.0, count)
    return WIDTH_PX * np.minimum(1.0, np.minimum(0.3 + 6.0 * part, 0.1 + 3.0 * (1.0 - part)))


def body_of(points, width=None):
    points = np.asarray(points, dtype=float)
    return polyline_body(points, tapered(len(points)) if width is None else width)


def arc(radius, turn, centre=(250.0, 250.0), count=121, begin=0.3):
    angle = begin + np.linspace(0.0, turn, count)
    return np.c_[centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)]


def bow(count=241):
    """Crosses itself once, at a right angle."""
    t = np.linspace(-1.5, 1.5, count)
    return np.c_[240 + 90 * (t**2 - 1), 250 + 90 * t * (t**2 - 1)]


def hairpin(apart_px):
    """Two straight strands, so far apart, and the turn between them."""
    there = np.c_[np.linspace(100, 350, 60), np.full(60, 250 - apart_px / 2)]
    back = there[::-1] + np.array([0.0, apart_px])
    return np.r_[there, back]


LINES = {"arc": arc(120, 2.5), "bow": bow(), "hairpin": hairpin(8.0), "flat hairpin": hairpin(1e-3)}


@given(st.floats(0.0, 2.0 * np.pi) | st.sampled_from([0.0, 1e-9, 0.01, np.pi / 2, np.pi]))
def test_a_body_covers_the_same_area_in_any_direction(angle):
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    straight = np.c_[np.linspace(-90.0, 90.0, 41), np.zeros(41)]
    width = np.full(41, WIDTH_PX)
    area = covered(strands_over(body_of(250.0 + straight @ turn, width))).part.sum()
    assert area == pytest.approx(WIDTH_PX * (180.0 - WIDTH_PX) + np.pi * WIDTH_PX**2 / 4, rel=2e-3)


@pytest.mark.parametrize("name", LINES)
def test_the_truths_centroid_is_that_of_the_pixels(name):
    body = body_of(LINES[name])
    strands = strands_over(body)
    share = clear_view(SHARP, None) - shaded_view(SHARP, strands, Shade(overlap_darker=False))
    rows, columns = np.indices(share.shape)
    centroid = np.array([(share * columns).sum(), (share * rows).sum()]) / share.sum()
    np.testing.assert_allclose(centroid, covered(strands).centroid_px(), atol=0.1)


@settings(max_examples=20, deadline=None)
@given(u=st.floats(0, 1), v=st.floats(0, 1), tilt=st.floats(0, 6.3), width=st.floats(3.0, 20.0))
def test_a_straight_body_covers_its_length_times_its_width_about_its_middle(u, v, tilt, width):
    along = np.linspace(-80, 80, 33)
    middle = np.array([250.0 + u, 250.0 + v])
    body = body_of(middle + along[:, None] * (np.cos(tilt), np.sin(tilt)), np.full(33, width))
    coverage = covered(strands_over(body))
    area = 160 * width - (1 - np.pi / 4) * width**2  # its ends are half circles
    assert coverage.part.sum() == pytest.approx(area, rel=0.005)
    np.testing.assert_allclose(coverage.centroid_px(), middle, atol=0.05)


def test_the_outermost_points_are_the_midlines_ends():
    body = body_of(np.c_[np.linspace(100, 400, 121), np.full(121, 250.0)])
    coverage = covered(strands_over(body))
    across = coverage.part.sum(axis=0)
    inside = coverage.u0 + np.flatnonzero(across > 0)
    assert inside[0] == pytest.approx(100, abs=1)
    assert inside[-1] == pytest.approx(400, abs=1)
    middle = across[np.arange(len(across)) + coverage.u0 == 200]
    assert middle == pytest.approx(WIDTH_PX, abs=0.4)


def test_two_strands_let_pass_the_product_of_what_each_lets_pass():
    strands = strands_over(body_of(bow()))
    darker, flat = (shaded_view(SHARP, strands, Shade(each)) for each in (True, False))
    levels = {round(float(level), 3) for level in np.unique(darker)}
    assert {WATER, ONE, TWO} <= levels
    assert darker.min() == pytest.approx(WATER * 0.3**2, rel=1e-6)
    assert flat[darker == darker.min()] == pytest.approx(ONE)
    once = strands.total.reshape(len(strands.total) // 3, 3, -1, 3).max(axis=(1, 3)) <= 1
    here = np.s_[strands.v0 : strands.v0 + once.shape[0], strands.u0 : strands.u0 + once.shape[1]]
    np.testing.assert_array_equal(darker[here][once], flat[here][once])


def test_a_body_that_only_bends_is_nowhere_darker():
    for radius in (WIDTH_PX, 3 * WIDTH_PX):  # from the midline to the bend's middle
        assert strands_over(body_of(arc(radius, 3.0, count=400))).total.max() == 1.0


def test_a_flat_hairpin_is_two_strands_save_for_a_short_way_at_its_turn():
    layers = strands_over(body_of(hairpin(1e-3), np.full(120, WIDTH_PX)))
    row = layers.total[layers.total.shape[0] // 2]
    u = layers.u0 + (np.arange(len(row)) + 0.5) / 3 - 0.5
    twice = u[row > 1.5]
    assert row.max() == 2
    assert twice.min() == pytest.approx(100, abs=1)
    assert 350 - 1.25 * WIDTH_PX < twice.max() < 350 - WIDTH_PX / 4


def test_folded_is_a_body_that_lies_beside_itself_not_one_that_only_turns():
    width = np.full(120, WIDTH_PX)
    assert is_folded(body_of(hairpin(0.9 * WIDTH_PX), width))
    assert not is_folded(body_of(hairpin(1.2 * WIDTH_PX), width))
    assert is_folded(body_of(bow()))
    assert not is_folded(body_of(arc(60, 4.0)))


def test_a_skin_of_one_grey_looks_like_the_shade():
    s, y = np.arange(-18, 620)[:, np.newaxis] / 60, np.arange(-21, 22) / 60
    inside = (np.abs(y) <= 0.25) & (s >= 0) & (s <= 10)
    skin = Skin(np.where(inside, 0.3, 1.0), -0.3, 60.0, 10.0, np.full(100, 0.5))
    line = bow() * 0.4 + 150
    body = body_of(line, np.full(len(line), 12.0))
    skinned = skinned_view(SHARP, body, skin)
    shaded = shaded_view(SHARP, strands_over(body), Shade(overlap_darker=True))
    assert skinned.min() == pytest.approx(TWO, abs=0.1)
    assert np.abs(skinned - shaded).mean() < 0.5
    assert (np.abs(skinned - shaded) > 40).sum() < 0.1 * (shaded < 150).sum()


def test_what_lies_beyond_the_picture_or_in_the_wall_is_not_drawn():
    out = body_of(np.c_[np.linspace(-400, -200, 121), np.full(121, 250.0)])
    across_wall = body_of(np.c_[np.linspace(20, -60, 121), np.full(121, 480.0)])
    empty = clear_view(SHARP, None)
    for body in (out, across_wall):
        drawn = shaded_view(SHARP, strands_over(body), Shade(overlap_darker=True))
        np.testing.assert_array_equal(drawn, empty)
