"""Of many pictures of one rig: its polarity and geometry, within the uncertainty that is told."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest
from crawling_worm import LARGE_RIG, SMALL_RIG, arc, crawl, film, wall_path, wavy_path
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_model.simulator.rig import Optics, Rig
from worm_msgs_py.errors import NoChamberFound, TrackerError
from worm_tracker.calibration.calibrate_pictures import calibrate_pictures
from worm_tracker.detection.polarity import Polarity
from worm_tracker.parameters import TrackerParameters

MOST_SD = 4.0


def pictures_of(rig, *, along_the_wall=True, count=8):
    width = 0.4 * rig.px_per_mm
    path = wall_path(rig, width, depth=0.1) if along_the_wall else wavy_path(rig)
    heads = np.linspace(20 * rig.px_per_mm, 0.9 * arc(path)[-1], count)
    return film(rig, crawl(path, 20 * rig.px_per_mm, width, heads))


def assert_within_uncertainty(found, true):
    off = hypot(found.centre_u_px - true.centre_u_px, found.centre_v_px - true.centre_v_px)
    turned = abs(np.angle(np.exp(1j * (found.exit_rad - true.exit_rad))))
    assert off < MOST_SD * found.centre_sd_px
    assert abs(found.radius_px - true.radius_px) < MOST_SD * found.radius_sd_px
    assert turned < MOST_SD * found.exit_sd_rad
    assert abs(found.exit_width_m - true.exit_width_m) < MOST_SD * found.exit_width_sd_m


@settings(max_examples=8)
@given(
    u=st.floats(235, 275),
    v=st.floats(235, 275),
    px_per_mm=st.floats(13, 21),
    exit_rad=st.floats(-3, 3),
    width_mm=st.sampled_from([1.0, 2.0, 3.0]),
    blur=st.floats(0.6, 2.0),
    along_the_wall=st.booleans(),
)
def test_the_truth_is_within_the_uncertainty_though_the_worm_passes_the_exit(
    u, v, px_per_mm, exit_rad, width_mm, blur, along_the_wall
):
    rig = Rig(
        width_px=512,
        height_px=512,
        px_per_mm=px_per_mm,
        centre_px=(u, v),
        exit_rad=exit_rad,
        exit_width_mm=width_mm,
        optics=Optics(noise=3.0, blur_px=blur, gradient=(0.2, -0.1)),
    )
    pictures = pictures_of(rig, along_the_wall=along_the_wall)
    found = calibrate_pictures(pictures, TrackerParameters())
    assert found.polarity is Polarity.DARK
    assert (found.showing, found.looked_at) == (8, 8)
    assert_within_uncertainty(found.geometry.chambers[0], rig.chambers[0])


def test_uncertainties_are_small_enough_to_say_something():
    found = calibrate_pictures(pictures_of(LARGE_RIG), TrackerParameters()).geometry.chambers[0]
    assert found.centre_sd_px < 0.05
    assert found.radius_sd_px < 0.05
    assert found.exit_sd_rad < np.radians(0.05)
    assert found.exit_width_sd_m * found.px_per_m < 0.15


def test_an_inverted_film_is_one_of_a_bright_worm():
    pictures = [255 - picture for picture in pictures_of(SMALL_RIG)]
    found = calibrate_pictures(pictures, TrackerParameters())
    assert found.polarity is Polarity.BRIGHT
    assert_within_uncertainty(found.geometry.chambers[0], SMALL_RIG.chambers[0])
    with pytest.raises(NoChamberFound, match="0 of 8 pictures show a circular wall"):
        calibrate_pictures(pictures, TrackerParameters(), Polarity.DARK)


def test_both_chambers_and_their_passage_are_found():
    rig = Rig(
        width_px=1024, height_px=384, px_per_mm=13.0, centre_px=(145.2, 190.7), chamber_b=True
    )
    found = calibrate_pictures(pictures_of(rig), TrackerParameters()).geometry
    assert found.passage_length_m == pytest.approx(rig.passage_length_mm / 1e3, rel=1e-3)
    for chamber, true in zip(found.chambers, rig.chambers, strict=True):
        assert_within_uncertainty(chamber, true)


def test_what_is_told_has_no_uncertainty():
    told = TrackerParameters(exit_width_m=1.5e-3, radius_m=0.012)
    found = calibrate_pictures(pictures_of(SMALL_RIG), told).geometry.chambers[0]
    assert (found.exit_width_m, found.radius_m) == (1.5e-3, 0.012)
    assert np.isnan(found.exit_width_sd_m)


def test_a_closed_chamber_has_no_exit():
    rig = replace(SMALL_RIG, exit_width_mm=0.0)
    found = calibrate_pictures(pictures_of(rig), TrackerParameters()).geometry.chambers[0]
    assert np.isnan(found.exit_width_m)
    assert found.centre_sd_px < 0.05


def test_a_rig_that_moves_between_the_pictures_is_refused():
    moved = replace(SMALL_RIG, centre_px=(SMALL_RIG.centre_px[0] + 3.0, SMALL_RIG.centre_px[1]))
    pictures = [*pictures_of(SMALL_RIG, count=6), *pictures_of(moved, count=2)]
    with pytest.raises(TrackerError, match=r"lies up to 3\.0 px from where most pictures show it"):
        calibrate_pictures(pictures, TrackerParameters())


def test_pictures_of_nothing_are_refused():
    blank = [np.full((256, 256), 120, np.uint8)] * 3
    with pytest.raises(NoChamberFound, match="0 of 3 pictures"):
        calibrate_pictures(blank, TrackerParameters())


def test_a_bright_and_a_dark_disc_ask_for_the_polarity():
    v, u = np.mgrid[:300, :600]
    picture = np.where(u < 300, 60, 200).astype(np.uint8)
    picture[np.hypot(u - 150, v - 150) < 100] = 200
    picture[np.hypot(u - 450, v - 150) < 100] = 60
    with pytest.raises(TrackerError, match="stands out as dark and as bright: say --polarity"):
        calibrate_pictures([picture] * 3, TrackerParameters())
    for polarity, centre_u_px in ((Polarity.DARK, 150.0), (Polarity.BRIGHT, 450.0)):
        found = calibrate_pictures([picture] * 3, TrackerParameters(), polarity)
        assert found.geometry.chambers[0].centre_u_px == pytest.approx(centre_u_px, abs=0.5)
