"""A worm that wears a real skin, and lies open: its tips, length and width."""

import numpy as np
import pytest

from worm_model.simulator.folded_worms import (
    LOOKS,
    FoldedWorm,
    film_worm,
    rig_for,
)
from worm_model.simulator.rig.skins import read_skins
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

FRAMES = 24


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
