"""The tracker keeps its bars on pictures that were not made by the rig it was tuned on."""

import numpy as np
import pytest
from other_pictures import Look, taken, wall_following

from worm_msgs_py.contract.status import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

FRAMES = 36
"""The worm is clear of the exit by its 24th frame, and the exit is looked at again at 2 s."""


@pytest.mark.parametrize(
    ("look", "px"),
    [
        pytest.param(Look(), 0.5, id="as it comes"),
        pytest.param(Look(worm=50.0, jpeg_quality=60), 0.5, id="as dark as the wall, JPEG"),
        pytest.param(Look(worm=110.0, blur_px=1.3), 0.6, id="pale and blurred"),
    ],
)
def test_a_worm_at_the_wall_is_found_below_a_pixel(look, px):
    rng = np.random.default_rng(0)
    tracker, given, tips = Tracker(TrackerParameters()), [], []
    for frame, midline in enumerate(wall_following(look, FRAMES)):
        picture, ends = taken(look, midline, rng)
        tips.append(ends)
        given += tracker.push(picture, frame * 66_666_667)
        if frame == 0:  # the tail lies before the exit
            assert np.isnan(tracker.geometry.chambers[0].exit_width_m)
    given += tracker.finish()
    assert [tracked.state.status for tracked in given] == [Status.TRACKED] * FRAMES
    found = np.array([[[p.u_px, p.v_px] for p in (t.state.head, t.state.tail)] for t in given])
    head, tail = np.hypot(*(found - np.array(tips)).transpose(2, 1, 0))
    assert np.median(head) < px
    assert np.quantile(head, 0.95) < 1.5
    assert np.median(tail) < px
    radial = np.hypot(*(found - look.centre_px).transpose(2, 1, 0))
    true = np.hypot(*(np.array(tips) - look.centre_px).transpose(2, 1, 0))
    # Contact is decided at 0.3 of the width, 2.5 px here: a bias of that size would decide it.
    assert abs(np.median((radial - true)[0])) < 0.3
    (chamber,) = tracker.geometry.chambers
    off = np.hypot(chamber.centre_u_px - look.centre_px[0], chamber.centre_v_px - look.centre_px[1])
    assert off < 0.05
    assert chamber.radius_px == pytest.approx(look.radius_mm * look.px_per_mm, rel=1e-3)
    assert np.degrees(chamber.exit_rad) == pytest.approx(look.exit_deg, abs=0.1)
    assert chamber.exit_width_m * 1e3 == pytest.approx(look.exit_width_mm, abs=0.03)


def stroking(look, frames, stroke=0.08, period_frames=14):
    """Midlines of a worm that stretches and shortens as it goes, by up to 4 % in a frame."""
    for frame in range(frames):
        length_mm = 20.0 * (1.0 + stroke * np.sin(2.0 * np.pi * frame / period_frames))
        *_, midline = wall_following(look, frame + 1, length_mm=length_mm)
        yield midline


def test_a_worm_that_stroked_while_frames_were_missing_is_told_in_its_whole_length():
    look, rng = Look(), np.random.default_rng(0)
    missing = {k for first in (40, 47, 51, 58, 66) for k in (first, first + 1)}
    tracker, given, tips = Tracker(TrackerParameters()), [], []
    for frame, midline in enumerate(stroking(look, 75)):
        if frame not in missing:
            picture, ends = taken(look, midline, rng)
            tips.append(ends)
            given += tracker.push(picture, frame * 40_000_000)
    given += tracker.finish()
    assert {tracked.state.status for tracked in given} == {Status.TRACKED}
    found = np.array([[[p.u_px, p.v_px] for p in (t.state.head, t.state.tail)] for t in given])
    head, tail = np.hypot(*(found - np.array(tips)).transpose(2, 1, 0))
    assert head.max() < 3.0
    assert tail.max() < 3.0, "a third of the worm's width"
