"""A tail far paler than the body is tracked to its tip, whether the worm moves or hardly does."""

from dataclasses import replace

import numpy as np
import pytest

from worm_model.simulator.folded_worms import LOOKS, FoldedWorm, film_worm, rig_for
from worm_model.simulator.rig.strands import Skin
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

LENGTH_MM, WIDTH_MM, PALE_MM = 16.0, 0.4, 3.6
PER_MM, AROUND_MM, DARKNESS = 60, 0.6, 0.55
LOOK = replace(LOOKS["darker"], px_per_mm=25.0)


def pale_tailed(part):
    """Return a skin whose tail has a part of the body's darkness, from within a millimetre on."""
    s = np.arange(-AROUND_MM, LENGTH_MM + AROUND_MM, 1 / PER_MM)
    y = np.arange(-36, 37) / PER_MM
    nearer = np.minimum(s, LENGTH_MM - s)
    half = WIDTH_MM / 2 * np.sqrt(np.clip(nearer / 0.5, 0.0, 1.0))
    inside = np.clip((half[:, None] - np.abs(y)) * PER_MM + 0.5, 0.0, 1.0) * (half > 0)[:, None]
    into_tail = np.clip(PALE_MM + 0.5 - (LENGTH_MM - s), 0.0, 1.0)
    dark = DARKNESS * (1.0 - (1.0 - part) * into_tail)
    width = 2 * np.interp(np.linspace(0.0, LENGTH_MM, 161), s, half)
    return Skin(1.0 - inside * dark[:, None], -AROUND_MM, PER_MM, LENGTH_MM, width)


def crawling(frames, mm_per_frame):
    """Return a worm that crawls along a bent way."""
    s = np.linspace(0.0, -LENGTH_MM, 121)
    head = mm_per_frame * np.arange(frames)
    angle = 0.16 * (s + head[:, None])
    lines = np.stack([6.0 * np.sin(angle), 3.0 - 6.0 * np.cos(angle)], axis=2)
    return FoldedWorm(lines, np.full(121, WIDTH_MM), 15.0)


@pytest.mark.parametrize("part", [0.45, 0.33])
@pytest.mark.parametrize("mm_per_frame", [0.005, 0.1])
def test_a_pale_tail_is_part_of_the_worm(part, mm_per_frame):
    """Below 0.4 of the body's darkness the threshold does not reach it."""
    worm, rig = crawling(60, mm_per_frame), rig_for(LOOK, seed=2)
    tracker, off, true = Tracker(TrackerParameters()), [], []
    given = []
    for frame, body in film_worm(rig, worm, LOOK, pale_tailed(part)):
        true.append(body)
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    for tracked, body in zip(given, true, strict=True):
        state = tracked.state
        assert state.status.label == "tracked"
        ends = np.array([[end.u_px, end.v_px] for end in (state.head, state.tail)])
        away = np.hypot(*np.moveaxis(ends[:, None] - body.points_px[[0, -1]], 2, 0))
        off.append(min(away.diagonal().max(), away[::-1].diagonal().max()))
        assert state.length_px == pytest.approx(body.length_px, rel=0.02)
    assert np.median(off) < 1.5
