"""The worms that fold are in the water; films show them where the truth says, in each look."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from worm_model.simulator.folded_worms import (
    LOOKS,
    bodies,
    film_worm,
    read_folded_worms,
    rig_for,
    width_in,
)
from worm_model.simulator.rig import clear_view
from worm_model.simulator.rig.skins import read_skins
from worm_model.simulator.rig.strands import is_folded, skinned_view

SOURCE = Path(__file__).parents[3] / "bags" / "source"


@pytest.fixture(scope="module")
def worms():
    return read_folded_worms(SOURCE / "folded_worms.npz")


@pytest.fixture(scope="module")
def skins():
    return read_skins()


def test_six_worms_of_a_thousand_frames_fold_within_the_chamber(worms):
    assert len(worms) == 6
    for worm in worms.values():
        assert worm.midlines_mm.shape == (1000, 121, 2)
        assert worm.fps == 25.0
        outline = np.hypot(*np.moveaxis(worm.midlines_mm, -1, 0)) + 0.5 * worm.width_mm
        assert outline.max() < 10.01
        steps = np.hypot(*np.moveaxis(np.diff(worm.midlines_mm, axis=0), -1, 0))
        assert steps.max() < 1.0  # none is decoded wrongly
        rig = rig_for(LOOKS["darker"])
        some = replace(worm, midlines_mm=worm.midlines_mm[::20])
        folded = [is_folded(body) for body in bodies(rig, some, worm.width_mm)]
        assert 0.2 < np.mean(folded) < 0.9


@pytest.mark.parametrize("name", LOOKS)
def test_the_truth_lies_on_the_worm_in_every_look(worms, skins, name):
    look = LOOKS[name]
    skin = skins.get(look.skin)
    rig = rig_for(look, noise=0.0)
    empty = clear_view(rig, None)
    for worm, frame in (("4001", 25), ("4003", 400), ("4006", 300)):
        motion = replace(worms[worm], midlines_mm=worms[worm].midlines_mm[frame : frame + 1])
        (film_frame, body), *_ = film_worm(rig, motion, replace(look, debris=False), skin)
        part = np.linspace(0.03, 0.97, 60) * body.length_px
        u, v = np.rint(body.at(part)).astype(int).T
        taken = 1.0 - film_frame.picture[v, u] / empty[v, u]
        assert taken.min() > 0.15  # the pale tail of w4 lets most through
        assert np.median(taken) > 0.5
        truth = film_frame.truth
        assert (truth.head_u_px, truth.head_v_px) == pytest.approx(tuple(body.points_px[0]))
        assert truth.r_h_mm < 10.0
        assert is_folded(body)


def test_a_thin_tail_falls_to_a_tenth_of_the_width_and_a_blunt_head_stays_wide(worms):
    width = width_in(LOOKS["thin_tail"], worms["4002"])
    assert width[-1] == pytest.approx(0.1 * width.max())
    assert width[0] == pytest.approx(0.6 * width.max())
    assert (np.diff(width[61:]) <= 0).all()


@pytest.mark.parametrize("name", ["w4", "w5"])
def test_a_skin_keeps_its_width_and_lets_pass_what_it_did(worms, skins, name):
    skin, look = skins[name], LOOKS[f"skin_{name}"]
    worm, rig = worms["4002"], rig_for(look, noise=0.0)
    body = next(iter(bodies(rig, worm, width_in(look, worm, skin))))
    assert not is_folded(body)
    passed = skinned_view(rig, body, skin) / clear_view(rig, None)
    middle = skin.transmission[:, skin.transmission.shape[1] // 2]
    for part in (0.2, 0.5, 0.8):
        u, v = body.at(part * body.length_px)
        row = round((part * skin.length_mm - skin.first_s_mm) * skin.per_mm)
        here = passed[round(v) - 1 : round(v) + 2, round(u) - 1 : round(u) + 2].mean()
        assert here == pytest.approx(middle[row - 3 : row + 4].mean(), abs=0.12)
    assert body.mean_width_px == pytest.approx(40 * np.median(skin.width_mm), rel=0.15)
