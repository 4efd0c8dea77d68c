"""The simulated worm keeps within the wall, follows it with its head, and obeys its laws."""

from itertools import pairwise

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from scipy.stats import kstest

from worm_model.simulator.film import write_film
from worm_model.simulator.gait import GaitSettings
from worm_model.simulator.head_path import HeadPath, Walker
from worm_model.simulator.rig import Body, Optics, Rig
from worm_model.simulator.worm import midlines_mm, rounded_body, simulate_film
from worm_msgs_py.errors import BadInput
from worm_msgs_py.paper import CONTACT_DISTANCE_WIDTHS

RIG = Rig(
    width_px=360, height_px=340, px_per_mm=15.0, centre_px=(170.4, 171.7), optics=Optics(noise=1.0)
)


@settings(max_examples=10)
@given(seed=st.integers(0, 10_000), turns=st.sampled_from([0.0, 0.05, 0.5]))
def test_the_worm_never_pokes_through_the_wall(seed, turns):
    walker = Walker(seed=seed, reversal_per_cycle=turns)
    for midline in midlines_mm(walker, 10.0, 3.0, 16.0):
        body = Body.along(midline * 40.0, 16.0)
        centres, radius = body.discs()
        assert (np.hypot(*centres.T) + radius).max() <= 400.0


def test_a_test_can_change_the_gait():
    """Kept half a millimetre off the wall, no point of the midline comes nearer to it."""
    gait = GaitSettings(clearance_mm=0.5)
    for midline in midlines_mm(Walker(seed=1), 10.0, 2.0, 16.0, gait=gait):
        assert np.hypot(*midline.T).max() < 10.0 - 0.25 * gait.clearance_mm


def test_the_same_seed_gives_the_same_worm_and_another_seed_another():
    first, again, other = (
        np.array(list(midlines_mm(Walker(seed=seed), 10.0, 2.0, 16.0))) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1.0


def test_length_stays_that_of_the_worm():
    midlines = np.array(list(midlines_mm(Walker(seed=3, reversal_per_cycle=0.1), 10.0, 40.0, 10.0)))
    length = np.hypot(*np.moveaxis(np.diff(midlines, axis=1), 2, 0)).sum(axis=1)
    assert np.median(length) == pytest.approx(20.0, rel=0.03)
    assert length.min() > 14.0
    assert length.max() < 23.0


def test_the_body_trails_inside_and_points_where_it_goes():
    walker = Walker(seed=4, reversal_per_cycle=0.0)
    film = [f.truth for f in simulate_film(RIG, walker, 20.0, 10.0)]
    theta = np.unwrap([t.theta_h_rad for t in film])
    turned = np.sign(theta[-1] - theta[0])
    psi = np.array([t.psi_b_deg for t in film])
    assert (np.sign(psi) == turned).mean() > 0.95
    assert np.median([t.r_c_mm for t in film]) < 8.0
    assert 0.4 < np.mean([t.contact for t in film]) < 0.8


def slides_and_hops(walker, seconds=1000.0, step=0.01):
    """Distances along the wall of the head's slides and hops, and the hops' depth past contact."""
    head = HeadPath(walker, 10.0)
    steps = round(seconds / step)
    theta, depth = np.empty(steps), np.empty(steps)
    for k in range(steps):
        head.advance(step, np.copysign(0.6, head.turning or head.lean_rad))
        theta[k], depth[k] = head.theta_rad, head.depth_mm
    free = depth > 0.0
    edges = np.flatnonzero(np.diff(free)) + 1
    parts = list(pairwise(edges))
    slides = np.array([10 * abs(theta[b] - theta[a]) for a, b in parts if not free[a]])
    hops = np.array([10 * abs(theta[b] - theta[a]) for a, b in parts if free[a]])
    excursions = np.array([depth[a:b].max() for a, b in parts if free[a]])
    return slides, hops, excursions - CONTACT_DISTANCE_WIDTHS * walker.width_mm


@pytest.mark.parametrize(
    "walker",
    [
        Walker(seed=5, reversal_per_cycle=0.0),
        Walker(seed=6, reversal_per_cycle=0.2, mean_slide_mm=1.0, mean_excursion_mm=0.6),
    ],
    ids=["paper", "other"],
)
def test_slides_hops_and_excursions_follow_their_exponential_laws(walker):
    slides, hops, excursions = slides_and_hops(walker)
    assert len(slides) > 250
    assert kstest(slides, "expon", args=(0, walker.mean_slide_mm)).pvalue > 0.01
    assert kstest(hops, "expon", args=(0, walker.mean_hop_mm)).pvalue > 0.01
    assert kstest(excursions, "expon", args=(0, walker.mean_excursion_mm)).pvalue > 0.01


def along(walker, exit_width_mm, fps=5.0):
    return list(midlines_mm(walker, 10.0, 80.0, fps, exit_width_mm))


@pytest.mark.parametrize("exit_width_mm", [0.5, 3.0])
def test_a_worm_that_meets_the_exit_goes_through_it_without_a_touch(exit_width_mm):
    rig = Rig(exit_width_mm=exit_width_mm)
    lines = along(Walker(seed=3), exit_width_mm)
    assert len(lines) < 400
    assert 10.0 < lines[-1][-1, 0] < 11.0
    assert lines[-1][0, 0] < 45.0
    assert abs(lines[-1][0, 1]) < 1e-9
    for before, line in pairwise(lines):
        assert np.hypot(*(line[0] - before[0])) < 1.5
        u, v = rig.chambers[0].to_pixels(line[:, 0] * 1e-3, line[:, 1] * 1e-3)
        centres, radius = rounded_body(np.c_[u, v], 0.4 * rig.px_per_mm).discs()
        assert (rig.wall_distance_px(*centres.T) + radius).max() < 0.0


def test_behind_the_wall_s_line_the_worm_follows_its_head_at_v_w():
    lines = [line for line in along(Walker(seed=3, speed_mm_s=3.0), 3.0) if line[0, 0] > 10.5]
    way = np.array([np.hypot(*(b[0] - a[0])) for a, b in pairwise(lines)])
    np.testing.assert_allclose(way * 5.0, 3.0, rtol=0.01)
    path = np.concatenate([line[0] for line in lines]).reshape(-1, 2)
    for line in lines[-3:]:
        inside = line[line[:, 0] > path[0, 0]]
        np.testing.assert_allclose(inside[:, 1], np.interp(inside[:, 0], *path.T), atol=0.05)


@pytest.mark.parametrize("exit_width_mm", [0.0, 0.4])
def test_an_exit_as_narrow_as_the_body_is_wall(exit_width_mm):
    lines = along(Walker(seed=3), exit_width_mm, fps=1.0)
    heads = np.unwrap([np.arctan2(*line[0, ::-1]) for line in lines])
    assert len(lines) == 80
    assert np.diff(np.floor(heads / (2.0 * np.pi))).any()


def test_a_film_is_a_bag_with_its_truth_beside_it(tmp_path):
    bag = tmp_path / "walk"
    film = list(simulate_film(RIG, Walker(seed=6), 1.0, 15.0))
    truth = write_film(bag, film, jpeg_quality=95)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["walk", "walk_truth.parquet"]
    types = get_typestore(Stores.ROS2_JAZZY)
    with Reader(bag) as reader:
        messages = [
            (stamp, types.deserialize_cdr(raw, c.msgtype)) for c, stamp, raw in reader.messages()
        ]
    stamps = [stamp for stamp, _ in messages]
    assert stamps == [round(k * 1e9 / 15.0) for k in range(15)]
    header = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in messages]
    assert header == stamps
    picture = cv2.imdecode(messages[7][1].data, cv2.IMREAD_GRAYSCALE)
    assert np.abs(picture.astype(int) - film[7].picture).mean() < 1.5
    table = pq.read_table(truth)
    assert table["stamp_ns"].to_pylist() == stamps
    assert table["frame"].to_pylist() == list(range(15))


def test_a_film_does_not_overwrite_and_leaves_no_half(tmp_path):
    bag = tmp_path / "walk"

    def breaks():
        yield from simulate_film(RIG, Walker(), 0.2, 15.0)
        raise RuntimeError("the lamp went out")

    with pytest.raises(RuntimeError, match="lamp"):
        write_film(bag, breaks())
    assert list(tmp_path.iterdir()) == []
    write_film(bag, simulate_film(RIG, Walker(), 0.2, 15.0))
    with pytest.raises(BadInput, match="exists already"):
        write_film(bag, simulate_film(RIG, Walker(), 0.2, 15.0))


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed_mm_s": 0.0},
        {"length_mm": float("nan")},
        {"reversal_per_cycle": 1.5},
        {"mean_excursion_mm": 2.0, "mean_hop_mm": 0.3},
    ],
)
def test_a_worm_that_makes_no_sense_is_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Walker(**wrong)
