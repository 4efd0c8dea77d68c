"""Each scene shows what it says, its truth lies in the water, and a seed repeats it."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from worm_model.simulator import crawling
from worm_model.simulator.rig import Body, Rig, clear_view, draw, worm_coverage
from worm_model.simulator.rig import disturbances as seen
from worm_model.simulator.rig.drawing import crossings
from worm_model.simulator.scenes import FPS, SCENES, Take, bumped
from worm_model.simulator.worm import rounded_body

TAKE = Take(px_per_mm=12.0, frames=24, noise=2.0)


def film(name, **changes):
    return list(SCENES[name](replace(TAKE, **changes)))


def column(frames, name):
    return np.array([getattr(frame.truth, name) for frame in frames])


def rig_of(name, frame):
    if name == "there_and_back":
        return TAKE.whole_rig
    if name == "bumped_camera" and 2 * frame >= TAKE.frames:
        return bumped(TAKE.chamber)
    return TAKE.chamber


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_as_long_as_asked_and_its_worm_is_in_the_water(name):
    frames = film(name)
    assert [frame.truth.frame for frame in frames] == list(range(TAKE.frames))
    assert (np.diff([frame.stamp_ns for frame in frames]) > 0).all()
    for frame in frames:
        rig, truth = rig_of(name, frame.truth.frame), frame.truth
        assert frame.picture.shape == (rig.height_px, rig.width_px)
        u, v = np.array(truth.midline_u_px), np.array(truth.midline_v_px)
        centres, radius = rounded_body(np.c_[u, v], 0.4 * rig.px_per_mm).discs()
        assert (rig.wall_distance_px(*centres.T) + radius).max() <= 0.25
        assert (truth.circle_u_px, truth.circle_v_px) in [
            pytest.approx((c.centre_u_px, c.centre_v_px)) for c in rig.chambers
        ]
        assert truth.length_mm == pytest.approx(20.0, rel=0.05)


@pytest.mark.parametrize("name", SCENES)
def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(name):
    one, again, other = (film(name, frames=4, seed=seed) for seed in (3, 3, 4))
    for a, b, c in zip(one, again, other, strict=True):
        np.testing.assert_array_equal(a.picture, b.picture)
        assert a.truth == b.truth
        assert (a.picture != c.picture).mean() > 0.3


@pytest.mark.parametrize("name", SCENES)
def test_the_worm_is_where_the_truth_says(name):
    """Its midline is darker than the water beside it, but for what glare hides."""
    frame = film(name, noise=0.0)[-1]
    u, v = (np.rint(frame.truth.midline_u_px), np.rint(frame.truth.midline_v_px))
    on = frame.picture[v.astype(int), u.astype(int)][5:-5]
    water = np.percentile(frame.picture, 90)
    assert np.median(on) < 0.6 * water


def test_a_straight_crossing_is_covered_twice_over_the_square_of_the_width():
    loop = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 200)
    tip = np.sqrt(2.0) * 80.0
    ring = np.c_[tip + 80.0 * np.cos(loop), 80.0 * np.sin(loop)]
    start = ring[0] + np.linspace(2.2, 0.02, 60)[:, np.newaxis] * -(ring[1] - ring[0]) * 45.0
    end = ring[-1] + np.linspace(0.02, 2.2, 60)[:, np.newaxis] * (ring[-1] - ring[-2]) * 45.0
    body = Body.along(np.r_[start, ring, end] + 200.0, 10.0)
    twice = crossings(body, worm_coverage(body))
    assert twice is not None
    assert twice.sum() == pytest.approx(100.0, rel=0.03)
    straight = Body.along([(10.0, 10.0), (150.0, 60.0)], 10.0)
    assert (
        crossings(straight, worm_coverage(straight)) is None
        or not crossings(straight, worm_coverage(straight)).any()
    )


def test_a_crossing_is_darker_by_the_transmission_of_a_second_layer():
    two, one = (film(name, noise=0.0, frames=60) for name in ("crossing", "crossing_of_one_shade"))
    optics = TAKE.chamber.optics
    darkest = min((a.picture / b.picture).min() for a, b in zip(two, one, strict=True))
    assert darkest == pytest.approx(optics.worm_transmission, abs=0.12)
    assert [frame.truth for frame in two] == [frame.truth for frame in one]


def test_the_coils_turns_touch_and_do_not_cross():
    line = crawling.coiling_path(0.4, 32.0, 20.0)[::10]
    step = np.hypot(*np.diff(line, axis=0).T)
    assert step == pytest.approx(0.2, rel=0.02)
    apart = np.hypot(*(line[:, np.newaxis] - line[np.newaxis]).transpose(2, 0, 1))
    i, j = np.indices(apart.shape)
    assert 0.38 < apart[j - i > 20].min() < 0.48
    frames = film("coil", frames=60)
    spread = (
        np.array([np.hypot(np.ptp(t.midline_u_px), np.ptp(t.midline_v_px)) for _, _, t in frames])
        / TAKE.px_per_mm
    )
    assert spread[30:36].max() < 6.0
    assert min(spread[0], spread[-1]) > 12.0


def test_along_the_wall_the_whole_body_is_at_it_and_the_head_touches_and_lifts():
    frames = film("along_the_wall", frames=60)
    chamber = TAKE.chamber.chambers[0]
    touching = [frame.truth for frame in frames if frame.truth.contact]
    assert 15 < len(touching) < 55
    for truth in touching:
        x, y = chamber.to_metres(np.array(truth.midline_u_px), np.array(truth.midline_v_px))
        assert np.hypot(x, y).min() > 9.6e-3


def test_in_the_walks_the_head_touches_the_wall_most_of_the_time():
    assert np.mean(column(film("at_the_wall", frames=150), "contact")) > 0.6


def test_the_bumped_cameras_picture_is_the_rigs_turned_and_shifted():
    rig = TAKE.chamber
    after = bumped(rig)
    moved = np.hypot(*np.subtract(after.centre_px, rig.centre_px))
    assert 0.5 < moved < 0.5 * TAKE.px_per_mm
    frames = film("bumped_camera", noise=0.0)
    np.testing.assert_array_equal(np.unique(column(frames, "circle_u_px")).size, 2)
    empty = draw(replace(after, optics=replace(after.optics, noise=0.0)), None, 0)
    assert (frames[-1].picture != empty).mean() < 0.05
    assert frames[11].truth.circle_u_px == rig.centre_px[0]
    assert frames[12].truth.circle_u_px == after.centre_px[0]


def test_a_worm_rests_for_minutes_and_then_moves():
    frames = film("resting", frames=100)
    still = frames[:80]
    assert len({frame.truth.head_u_px for frame in still}) == 1
    assert still[-1].stamp_ns > 120e9
    assert frames[-1].truth.head_u_px != frames[0].truth.head_u_px
    assert np.any(still[0].picture != still[1].picture)


def test_there_and_back_leads_through_every_part_of_the_rig():
    frames = film("there_and_back", frames=120)
    parts = [part for part, _ in groupby(column(frames, "where"))]
    assert parts == ["chamber_a", "passage", "chamber_b", "passage", "chamber_a"]
    in_b = [frame.truth for frame in frames if frame.truth.where == "chamber_b"]
    assert in_b[0].head_x_mm == pytest.approx(9.0, abs=1.0)  # x points to b's own exit
    assert max(np.abs(column(frames, "exit_deg"))) > 90.0


def test_a_failed_attempt_ends_in_withdrawal():
    frames = film("failed_attempt", frames=90)
    parts = [part for part, _ in groupby(column(frames, "where"))]
    assert parts == ["chamber_a", "passage"] * 2 + ["chamber_a"]
    assert column(frames, "head_x_mm").max() == pytest.approx(13.5, abs=0.05)
    assert column(frames, "r_c_mm").max() < 10.0


def test_flicker_is_a_gain_of_the_whole_picture_and_drift_is_slow():
    calm = film("at_the_wall", noise=0.0)
    for name, largest in (("flicker", 0.24), ("light_drift", 0.15 * 2 * np.pi / 60.0 / FPS)):
        ratio = np.array(
            [
                np.median(frame.picture / np.maximum(still.picture, 1.0))
                for frame, still in zip(film(name, noise=0.0), calm, strict=True)
            ]
        )
        assert np.abs(np.diff(ratio)).max() <= largest + 0.01
        assert np.ptp(ratio) > 0.02
    assert np.abs(np.diff(ratio)).max() < 0.02


def test_disturbances_change_what_they_should_and_nothing_else():
    rig = replace(TAKE.chamber, optics=replace(TAKE.chamber.optics, gradient=(0.0, 0.0)))
    empty = clear_view(rig, None)
    u, v = np.rint(rig.chambers[0].to_pixels(2e-3, 1e-3)).astype(int)

    def with_(add, *arguments):
        view = empty.copy()
        add(view, rig, *arguments)
        return view

    speck = with_(seen.add_debris, [(2.0, 1.0, 0.3)])
    assert speck[v, u] == pytest.approx(seen.DIRT.speck_transmission * empty[v, u])
    assert (speck != empty).sum() < np.pi * (0.3 * 12 + 3) ** 2
    bubble = with_(seen.add_bubbles, [(2.0, 1.0, 1.0)])
    assert bubble[v, u] > empty[v, u] + 25
    assert bubble.min() < 0.5 * empty[v, u]
    spot = with_(seen.add_glare, (2.0, 1.0, 0.5), 100.0)
    assert spot[v, u] == pytest.approx(empty[v, u] + 100.0, abs=1.5)
    outside = with_(seen.add_debris, [(40.0, 40.0, 0.3)])
    np.testing.assert_array_equal(outside, empty)


def test_a_reflection_darkens_the_wall_alone():
    rig = TAKE.chamber
    truth = film("reflection")[-1].truth
    body = Body.along(np.c_[truth.midline_u_px, truth.midline_v_px], 0.4 * rig.px_per_mm)
    view, empty = clear_view(rig, None), clear_view(rig, None)
    seen.add_reflection(view, rig, body, 0.3)
    v, u = np.nonzero(view != empty)
    assert len(u) > 50
    assert rig.wall_distance_px(u.astype(float), v.astype(float)).min() > -1.0


def test_a_ghost_is_a_faint_second_worm_in_the_water():
    rig = TAKE.chamber
    truth = film("reflection")[-1].truth
    body = Body.along(np.c_[truth.midline_u_px, truth.midline_v_px], 0.4 * rig.px_per_mm)
    view, empty = clear_view(rig, None), clear_view(rig, None)
    seen.add_ghost(view, rig, body, (0.5, -0.7), 0.08)
    lost = 1.0 - view / empty
    assert lost.max() == pytest.approx(0.08, abs=1e-3)
    assert lost.sum() == pytest.approx(0.08 * worm_coverage(body).part.sum(), rel=0.1)


def test_a_crawl_beyond_the_paths_end_is_refused():
    path = crawling.winding_path(10.0)
    with pytest.raises(ValueError, match="needs a path"):
        list(crawling.crawl(path, 20.0, [19.0]))
    assert isinstance(Take().whole_rig, Rig)
