"""A worm that wears a real skin, and lies open: its tips, length and width."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from worm_model.simulator.folded_worms import (
    LOOKS,
    FoldedWorm,
    film_worm,
    read_folded_worms,
    rig_for,
)
from worm_model.simulator.rig.skins import read_skins
from worm_model.simulator.rig.strands import is_folded
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

FRAMES = 24
WORMS = Path(__file__).parents[2] / "bags" / "source" / "folded_worms.npz"


@pytest.mark.parametrize("name", ["w4", "w5"])
def test_a_real_skin_is_tracked_to_its_tips_and_as_wide_as_it_is(name):
    look, skin = LOOKS[f"skin_{name}"], read_skins()[name]
    s = np.linspace(0.0, -20.0, 121)
    angle = 0.14 * (s + 0.08 * np.arange(FRAMES)[:, None]) + 1.5
    lines = np.stack([6.5 * np.sin(angle), 1.5 - 6.5 * np.cos(angle)], axis=2)
    worm = FoldedWorm(lines, np.ones(121), 25.0)
    tracker, given, films = Tracker(TrackerParameters()), [], []
    for frame, body in film_worm(rig_for(look, seed=1), worm, look, skin):
        films.append((frame.truth, body))
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    tips, centroids, widths = [], [], []
    for tracked, (truth, body) in zip(given, films, strict=True):
        state = tracked.state
        assert state.status.label == "tracked"
        assert state.length_px == pytest.approx(body.length_px, rel=0.02)
        ends = np.array([[end.u_px, end.v_px] for end in (state.head, state.tail)])
        away = np.hypot(*np.moveaxis(ends[:, None] - body.points_px[[0, -1]], 2, 0))
        tips.append(min(away.diagonal().max(), away[::-1].diagonal().max()))
        centroids.append(
            np.hypot(
                state.centroid.u_px - truth.centroid_u_px, state.centroid.v_px - truth.centroid_v_px
            )
        )
        widths.append(state.width_px / body.mean_width_px)
    assert np.median(tips) < 2.0
    assert np.median(centroids) < 2.5  # the half-height edges of soft flanks are good to 0.3 px
    assert np.median(widths) == pytest.approx(1.0, abs=0.05)


def test_the_centroid_of_a_folded_body_is_that_of_all_of_it_where_its_skin_is_pale():
    """What stands out from the background is narrower there, by a width and a half of centroid."""
    look, skin = LOOKS["skin_w4"], read_skins()["w4"]
    worm = read_folded_worms(WORMS)["4003"]
    worm = replace(worm, midlines_mm=worm.midlines_mm[320:410])
    tracker, given, true, folded = Tracker(TrackerParameters()), [], [], []
    for frame, body in film_worm(rig_for(look, seed=4003), worm, look, skin):
        true.append((frame.truth.centroid_u_px, frame.truth.centroid_v_px))
        folded.append(is_folded(body))
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    told = np.array([(one.state.centroid.u_px, one.state.centroid.v_px) for one in given])
    away = np.hypot(*(told - true).T)
    posed = np.array([one.state.status.has_pose for one in given])
    assert (posed & folded).sum() > 30
    assert np.median(away[posed & folded]) < 3.0
    assert away[posed & folded].max() < 10.0


def test_a_tail_near_the_threshold_is_part_of_a_worm_at_every_length_of_its_stroke():
    """Stretched, the worm without its tail has as large an area as all of it has on average."""
    frames = 90
    s = np.linspace(0.0, -20.0, 121) * (
        1 + 0.06 * np.sin(2 * np.pi * np.arange(frames)[:, None] / 15)
    )
    angle = 0.14 * (s + 0.03 * np.arange(frames)[:, None]) + 1.5
    lines = np.stack([6.5 * np.sin(angle), 1.5 - 6.5 * np.cos(angle)], axis=2)
    look, skin = LOOKS["skin_w4"], read_skins()["w4"]
    tracker, given, lengths = Tracker(TrackerParameters()), [], []
    worm = FoldedWorm(lines, np.ones(121), 25.0)
    for frame, body in film_worm(rig_for(look, seed=4003), worm, look, skin):
        lengths.append(body.length_px)
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    told = np.array([tracked.state.length_px for tracked in given])
    assert told == pytest.approx(np.array(lengths), rel=0.02)


def test_a_pale_tail_at_rest_is_kept_where_a_film_begins_with_a_fold():
    """What was laid double was learned as a short dark worm, and its tail became background."""
    look, skin, worm = LOOKS["skin_w4"], read_skins()["w4"], read_folded_worms(WORMS)["4003"]
    worm = replace(worm, midlines_mm=worm.midlines_mm[:180:2], fps=worm.fps / 2)
    tracker, given, lengths = Tracker(TrackerParameters()), [], []
    for frame, body in film_worm(rig_for(look, seed=4003), worm, look, skin):
        lengths.append(body.length_px)
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    opened = slice(76, None)
    told = np.array([tracked.state.length_px for tracked in given[opened]])
    assert np.isfinite(told).mean() > 0.9
    off = told / np.array(lengths[opened]) - 1
    assert np.nanmax(np.abs(off)) < 0.03


def turning_back(frames):
    """Return a worm that turns back along the way that it came, over all of its own body."""
    turns_at_mm, radius_mm, apart_mm = 30.0, 6.5, 0.9
    way = np.linspace(0.0, turns_at_mm, 600)
    out = radius_mm * np.exp(1j * way / radius_mm)
    about = np.exp(1j * way[-1] / radius_mm)
    bend = apart_mm / 2 * np.exp(1j * np.linspace(0.0, np.pi, 60))
    nearing = np.cos(np.pi / 2 * np.clip(way / 5.0, 0.0, 1.0)) ** 2
    back = (radius_mm - apart_mm * nearing) * np.exp(-1j * way / radius_mm)
    curve = np.concatenate([out, (radius_mm - apart_mm / 2 + bend[1:]) * about, back[1:] * about])
    s = np.r_[0.0, np.cumsum(np.abs(np.diff(curve)))]
    at = 21.0 + 0.25 * np.arange(frames)[:, None] - np.linspace(0.0, 20.0, 121)
    lines = np.stack([np.interp(at, s, curve.real), np.interp(at, s, curve.imag)], axis=2)
    return FoldedWorm(lines, np.ones(121), 25.0)


def test_a_pale_tail_under_the_body_is_told_by_its_marks():
    """A reversal: from frame 75 to 103 the tail lies under the head's part of the worm."""
    look, skin = LOOKS["skin_w4"], read_skins()["w4"]
    tracker, given, bodies = Tracker(TrackerParameters()), [], []
    for frame, body in film_worm(rig_for(look, seed=5), turning_back(125), look, skin):
        bodies.append(body)
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    off = []
    for tracked, body in zip(given, bodies, strict=True):
        if not tracked.state.status.has_pose or tracked.state.head_certainty < 0.9:
            off.append(np.nan)
            continue
        ends = np.array([[end.u_px, end.v_px] for end in (tracked.state.head, tracked.state.tail)])
        away = np.hypot(*(ends - body.points_px[[0, -1]]).T)
        off.append(away.max() / body.mean_width_px)
    assert np.nanmax(off) < 1.0
    assert np.isfinite(off[75:104]).sum() > 18, "told for certain"
    assert np.isfinite(off[:50]).all()
    assert np.isfinite(off[104:]).all()
