"""The drawn picture holds what the truth says, below a tenth of a pixel."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates
from scipy.optimize import brentq

from worm_model.simulator.rig import Body, Optics, Rig, draw, truth_of, worm_coverage
from worm_msgs_py.contract.frames import Where

CLEAN = Optics(gradient=(0.0, 0.0), noise=0.0, blur_px=0.8)
RIG = Rig(
    width_px=640,
    height_px=600,
    px_per_mm=24.0,
    centre_px=(310.3, 297.8),
    exit_rad=0.4,
    optics=CLEAN,
)


def curved_body(angle: float = 0.0, u: float = 300.2, v: float = 310.7) -> Body:
    t = np.linspace(-1.0, 1.0, 21)
    x, y = 90.0 * t, 35.0 * np.cos(2.0 * t) + 10.0 * t**3
    c, s = np.cos(angle), np.sin(angle)
    return Body.along(np.c_[u + c * x - s * y, v + s * x + c * y], 11.0)


def half_level_crossing(picture, start, direction, low, high, level):
    """Distance from `start` along `direction` at which the picture passes `level`."""
    values = picture.astype(float)

    def excess(distance):
        u, v = np.asarray(start) + distance * np.asarray(direction)
        return float(map_coordinates(values, [[v], [u]], order=3)[0]) - level

    return brentq(excess, low, high)


def test_half_level_of_the_wall_lies_at_R():
    picture = draw(RIG, None, 0)
    level = CLEAN.light * (1 + CLEAN.wall_transmission) / 2
    for angle in np.radians(np.arange(60, 330, 17)):
        direction = (np.cos(angle), -np.sin(angle))
        edge = half_level_crossing(
            picture, RIG.centre_px, direction, RIG.radius_px - 3, RIG.radius_px + 3, level
        )
        assert edge == pytest.approx(RIG.radius_px, abs=0.05)


@pytest.mark.parametrize("exit_rad", [0.0, 0.03, 2.2])
def test_water_covers_each_pixel_by_the_distance_of_its_middle_from_the_wall(exit_rad):
    light = 255.0
    dark = replace(CLEAN, light=light, wall_transmission=0.0, blur_px=0.0)
    rig = replace(RIG, width_px=645, height_px=603, exit_rad=exit_rad, chamber_b=True, optics=dark)
    small = replace(rig, px_per_mm=6.1, centre_px=(80.4, 299.7))
    u, v = np.arange(645.0), np.arange(603.0)[:, np.newaxis]
    for one in (rig, small):
        water = np.clip(0.5 - one.wall_distance_px(u, v), 0.0, 1.0)
        np.testing.assert_allclose(draw(one, None, 0), light * water, atol=0.5001)


def test_the_exit_is_W_wide_and_points_where_it_should():
    picture = draw(RIG, None, 0)
    level = CLEAN.light * (1 + CLEAN.wall_transmission) / 2
    chamber = RIG.chambers[0]
    across = np.array([-np.sin(RIG.exit_rad), -np.cos(RIG.exit_rad)])
    for x_mm in (10.8, 11.6):
        middle = np.array(chamber.to_pixels(x_mm * 1e-3, 0.0))
        sides = [half_level_crossing(picture, middle, s * across, 15, 33, level) for s in (1, -1)]
        assert sides == pytest.approx([24.0, 24.0], abs=0.05)


@given(angle=st.floats(0, 6.28), u=st.floats(250, 350), v=st.floats(250, 350))
def test_moments_of_the_picture_give_the_true_centroid(angle, u, v):
    body = curved_body(angle, u, v)
    rig = replace(RIG, optics=replace(CLEAN, gradient=(0.0, 0.0)))
    missing = draw(rig, None, 0).astype(float) - draw(rig, body, 0)
    columns, rows = missing.sum(axis=0), missing.sum(axis=1)
    found = columns @ np.arange(640) / columns.sum(), rows @ np.arange(600) / rows.sum()
    truth = truth_of(rig, body, 0, 0)
    assert found == pytest.approx((truth.centroid_u_px, truth.centroid_v_px), abs=0.05)


@pytest.mark.parametrize("angle", np.radians([0, 30, 45, 77, 200]))
def test_half_level_of_a_straight_worm_lies_half_a_width_from_its_midline(angle):
    middle, along = np.array([300.4, 280.1]), np.array([np.cos(angle), np.sin(angle)])
    body = Body.along([middle + 80 * along, middle - 80 * along], 12.0)
    picture = draw(RIG, body, 0)
    level = CLEAN.light * (1 + CLEAN.worm_transmission) / 2
    across = np.array([-along[1], along[0]])
    sides = [half_level_crossing(picture, middle, s * across, 3, 9, level) for s in (1, -1)]
    assert sides == pytest.approx([6.0, 6.0], abs=0.05)


@pytest.mark.parametrize("angle", np.radians([0, 30, 45, 200]))
def test_tips_are_the_outermost_points_of_the_outline(angle):
    """Blur draws a tip of curvature radius ρ inwards by about σ²/2ρ; a sharp lens does not."""
    middle, along = np.array([300.4, 280.1]), np.array([np.cos(angle), np.sin(angle)])
    head_first = [middle + 80 * along, middle - 80 * along]
    body = Body.along(head_first, 16.0, head_taper_px=16.0, tail_taper_px=8.0)
    picture = draw(replace(RIG, optics=replace(CLEAN, blur_px=0.4)), body, 0)
    level = CLEAN.light * (1 + CLEAN.worm_transmission) / 2
    tips = [half_level_crossing(picture, middle, s * along, 70, 85, level) for s in (1, -1)]
    assert tips == pytest.approx([80.0, 80.0], abs=0.1)
    truth = truth_of(RIG, body, 0, 0)
    assert (truth.head_u_px, truth.head_v_px) == pytest.approx(tuple(head_first[0]))
    assert (truth.tail_u_px, truth.tail_v_px) == pytest.approx(tuple(head_first[1]))


def test_drawn_area_is_that_of_the_outline():
    body = Body.along([(100.3, 200.6), (220.9, 291.2)], 14.0, 20.0, 30.0)
    rectangle = 14.0 * (body.length_px - 50.0)
    ends = np.pi / 4.0 * 14.0 * 50.0
    assert worm_coverage(body).part.sum() == pytest.approx(rectangle + ends, rel=0.002)


def test_a_crossing_is_covered_once():
    t = np.linspace(-0.5, 2 * np.pi - 2.0, 60)
    loop = np.c_[300 + 60 * np.cos(t) * (1 + 0.3 * np.sin(t)), 300 + 60 * np.sin(2 * t)]
    assert worm_coverage(Body.along(loop, 10.0)).part.max() == 1.0


def test_mirrored_rig_gives_the_mirrored_picture():
    body = curved_body(0.3)
    mirrored_rig = replace(
        RIG, centre_px=(639 - RIG.centre_px[0], RIG.centre_px[1]), exit_rad=np.pi - RIG.exit_rad
    )
    mirrored_body = Body.along(body.points_px * [-1, 1] + [639, 0], 11.0)
    difference = draw(mirrored_rig, mirrored_body, 0).astype(int) - draw(RIG, body, 0)[:, ::-1]
    assert np.abs(difference).max() <= 1
    assert truth_of(mirrored_rig, mirrored_body, 0, 0).psi_b_deg == pytest.approx(
        -truth_of(RIG, body, 0, 0).psi_b_deg, abs=0.01
    )


def test_the_same_frame_has_the_same_bytes_and_another_frame_other_noise():
    rig = replace(RIG, optics=replace(CLEAN, noise=2.0, seed=7))
    body = curved_body()
    first = draw(rig, body, 3)
    np.testing.assert_array_equal(first, draw(rig, body, 3))
    other = first.astype(int) - draw(rig, body, 4)
    assert other.std() == pytest.approx(2.0 * np.sqrt(2.0), rel=0.05)
    assert np.any(draw(replace(rig, optics=replace(rig.optics, seed=8)), body, 3) != first)


def test_light_gradient_multiplies_the_light():
    rig = replace(RIG, optics=replace(CLEAN, gradient=(0.2, 0.1)))
    ratio = draw(rig, None, 0).astype(float) / draw(RIG, None, 0)
    assert ratio[299, 620] / ratio[299, 20] == pytest.approx(1.1878 / 0.8125, rel=0.03)


def test_a_worm_out_of_the_picture_or_behind_the_wall_is_not_seen():
    empty = draw(RIG, None, 0)
    outside = Body.along([(-300.0, -200.0), (-100.0, -50.0)], 10.0)
    behind = Body.along([(20.0, 560.0), (90.0, 590.0)], 10.0)
    np.testing.assert_array_equal(draw(RIG, outside, 0), empty)
    np.testing.assert_array_equal(draw(RIG, behind, 0), empty)


def test_a_worm_half_out_of_the_picture_is_drawn():
    rig = replace(RIG, exit_rad=0.0, centre_px=(350.0, 300.0))
    leaving = Body.along([(700.0, 300.0), (560.0, 300.0)], 10.0)
    assert draw(rig, leaving, 0)[300, 630] == pytest.approx(200 * 0.3, abs=1)


@pytest.mark.parametrize(
    "points", [[(1.0, 2.0)], [(1.0, 2.0), (1.0, 2.0)], [(1.0, np.nan), (2.0, 2.0)], [1.0, 2.0]]
)
def test_a_body_needs_a_midline(points):
    with pytest.raises(ValueError, match="midline"):
        Body.along(points, 5.0)


def test_two_chambers_face_each_other_and_know_what_they_hold():
    rig = Rig(
        width_px=1700, height_px=600, px_per_mm=20, centre_px=(300, 300), chamber_b=True, exit_rad=0
    )
    a, b = rig.chambers
    assert (b.centre_u_px, b.centre_v_px) == pytest.approx((300 + 55 * 20, 300))
    assert a.to_metres(850.0, 300.0) == pytest.approx((27.5e-3, 0))
    assert b.to_metres(850.0, 300.0) == pytest.approx((27.5e-3, 0))
    assert rig.where(310, 200) is Where.CHAMBER_A
    assert rig.where(900, 300) is Where.PASSAGE
    assert rig.where(1400, 320) is Where.CHAMBER_B
    picture = draw(rig, None, 0)
    assert picture[300, 850] > 150 > 100 > picture[340, 850]


def test_an_exit_without_width_is_no_exit():
    picture = draw(replace(RIG, exit_width_mm=0.0), None, 0)
    chamber = RIG.chambers[0]
    u, v = chamber.to_pixels(np.linspace(10.2e-3, 13e-3, 30), np.zeros(30))
    wall = CLEAN.light * CLEAN.wall_transmission
    assert picture[np.rint(v).astype(int), np.rint(u).astype(int)].max() <= wall + 3
