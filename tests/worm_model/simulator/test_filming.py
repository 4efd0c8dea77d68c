"""A film shows the worm where its truth is, whatever lamp, shutter, camera and dirt do."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from worm_model.simulator.filming import Filming, film
from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.rig.skins import read_skins

RIG = Rig(
    width_px=400,
    height_px=400,
    px_per_mm=16.0,
    centre_px=(190.3, 205.8),
    exit_rad=0.4,
    chamber_b=True,
    optics=Optics(noise=0.0, gradient=(0.0, 0.0)),
)
PLAIN = Filming(frames_per_s=10.0)


def arc(x_mm=0.0, length_mm=20.0, radius_mm=7.0, points=41):
    """Return a body along a circle around x_mm, 0, head first."""
    angle = np.linspace(0.0, length_mm / radius_mm, points)
    return np.stack([x_mm + radius_mm * np.cos(angle), radius_mm * np.sin(angle)], axis=1)


def hairpin():
    """Return a body whose second half lies on its first."""
    x = np.concatenate([np.linspace(-5.0, 5.0, 21), np.linspace(5.0, -5.0, 21)[1:]])
    y = np.concatenate([np.zeros(20), [0.1, 0.2], np.full(19, 0.2)])
    return np.stack([x, y], axis=1)


def one(line, rig=RIG, filming=PLAIN):
    (frame,) = film([line], rig, filming)
    return frame


def empty(rig=RIG):
    return one(arc(500.0), rig).picture


@pytest.mark.parametrize("skin", [None, "w4", "w5"])
def test_the_truth_lies_on_the_worm(skin):
    worn = None if skin is None else read_skins()[skin]
    frame = one(arc(), filming=replace(PLAIN, skin=worn))
    u, v = (
        np.rint(np.asarray(line)[2:-2]).astype(int)
        for line in (frame.truth.midline_u_px, frame.truth.midline_v_px)
    )
    assert (frame.picture[v, u] < 0.8 * empty()[v, u]).mean() > 0.95
    assert frame.truth.length_mm == pytest.approx(20.0, rel=2e-3)


def test_the_centroid_is_that_of_the_pixels():
    frame = one(arc())
    absorbed = empty().astype(float) - frame.picture
    v, u = np.indices(absorbed.shape)
    total = absorbed.sum()
    assert (absorbed * u).sum() / total == pytest.approx(frame.truth.centroid_u_px, abs=0.05)
    assert (absorbed * v).sum() / total == pytest.approx(frame.truth.centroid_v_px, abs=0.05)


def test_what_lies_over_itself_is_darker_only_if_asked():
    darkest = {
        darker: int(one(hairpin(), filming=replace(PLAIN, overlap_darker=darker)).picture.min())
        for darker in (True, False)
    }
    assert darkest[False] == int(one(arc()).picture.min())
    assert darkest[True] < 0.6 * darkest[False]


def test_an_open_shutter_smears_the_worm_across_its_way_and_keeps_its_light():
    lines = [arc(0.4 * step) for step in (-1, 0, 1)]
    sharp, smeared = (
        list(film(lines, RIG, replace(PLAIN, exposure_s=exposure)))[1] for exposure in (0.0, 0.1)
    )
    assert smeared.truth == sharp.truth
    absorbed = [empty().astype(float) - frame.picture for frame in (sharp, smeared)]
    assert absorbed[1].sum() == pytest.approx(absorbed[0].sum(), rel=0.01)
    assert (absorbed[1] > 5).sum() > 1.1 * (absorbed[0] > 5).sum()


def test_a_worm_that_moves_far_in_an_exposure_leaves_an_even_trace():
    across = np.stack([np.zeros(41), np.linspace(8.0, -8.0, 41)], axis=1)
    lines = [across + np.array([2.5 * step, 0.0]) for step in (-1, 0, 1)]
    smeared = list(film(lines, RIG, replace(PLAIN, exposure_s=0.1)))[1]
    u, v = RIG.chambers[0].to_pixels(0.0, 0.0)
    trace = empty()[round(v)].astype(float) - smeared.picture[round(v)]
    inner = trace[round(u) - 14 : round(u) + 15]
    assert inner.min() > 10.0
    assert inner.max() - inner.min() < 4.0


def test_shot_noise_grows_with_the_light():
    rig = replace(RIG, optics=replace(RIG.optics, noise=1.0, shot_noise=0.05))
    noisy = one(arc(), rig).picture.astype(float) - one(arc()).picture
    bright = empty() > 190
    for where in (bright, ~bright):
        level = float(np.median(one(arc()).picture[where]))
        spread = 1.4826 * float(np.median(np.abs(noisy[where])))
        assert spread == pytest.approx(np.sqrt(1.0 + 0.05 * level), abs=0.6)


def test_sixteen_bits_show_the_same_more_finely():
    deep = replace(RIG, optics=replace(RIG.optics, bits=16))
    picture = one(arc(), deep).picture
    assert picture.dtype == np.uint16
    np.testing.assert_allclose(picture / 257.0, one(arc()).picture, atol=0.51)
    assert len(np.unique(picture)) > len(np.unique(one(arc()).picture))


def test_a_drifting_camera_takes_rig_worm_and_truth_along():
    lines = [arc()] * 601
    drifting = replace(PLAIN, drift_mm_per_min=(0.25, -0.125))
    first, *_, last = film(lines, RIG, drifting)
    shift = np.array([[1.0, 0.0, 4.0], [0.0, 1.0, -2.0]])
    moved = cv2.warpAffine(first.picture, shift, (400, 400), borderMode=cv2.BORDER_REPLICATE)
    np.testing.assert_array_equal(last.picture[5:-5, 5:-5], moved[5:-5, 5:-5])
    assert last.truth.head_u_px - first.truth.head_u_px == pytest.approx(4.0, abs=1e-6)
    assert last.truth.head_x_mm == pytest.approx(first.truth.head_x_mm, abs=1e-9)


@pytest.mark.parametrize("dirt", ["debris", "bubbles", "glare", "flicker"])
def test_dirt_and_flicker_are_seen_and_the_truth_is_as_without(dirt):
    filming = replace(PLAIN, **{dirt: 0.2 if dirt == "flicker" else 5})
    clean, dirty = one(arc()), one(arc(), filming=filming)
    assert dirty.truth == clean.truth
    assert (np.abs(dirty.picture.astype(int) - clean.picture) > 10).sum() > 50


def test_the_same_seed_gives_the_same_bytes_and_another_one_does_not():
    noisy = [replace(RIG, optics=replace(RIG.optics, noise=2.0, seed=seed)) for seed in (1, 1, 2)]
    dirty = replace(PLAIN, debris=5, flicker=0.05)
    a, b, c = (one(arc(), rig, dirty).picture for rig in noisy)
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


def test_a_worm_out_of_the_picture_has_a_truth_and_the_picture_is_empty():
    frame = one(arc(55.0))
    assert frame.truth.where == "chamber_b"
    np.testing.assert_array_equal(frame.picture, empty())


def test_the_wall_hides_what_lies_behind_it():
    line = np.stack([np.linspace(0.0, -14.0, 41), np.zeros(41)], axis=1)
    shown = empty().astype(int) - one(line).picture
    u, v = RIG.chambers[0].to_pixels(-11e-3, 0.0)
    assert shown[round(v), round(u)] == 0


def test_a_shutter_that_is_open_for_longer_than_a_frame_is_refused():
    with pytest.raises(ValueError, match="longer than a frame"):
        Filming(frames_per_s=30.0, exposure_s=0.05)
