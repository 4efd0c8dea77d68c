"""A tail far paler than the body is tracked to its tip, whether the worm moves or hardly does."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from worm_model.simulator.folded_worms import LOOKS, FoldedWorm, film_worm, rig_for
from worm_model.simulator.rig.strands import Skin
from worm_tracker.detection.blobs import BlobSettings, whole_picture
from worm_tracker.detection.detection import Detection, DetectionPrior, SignalView
from worm_tracker.detection.pale_ends import (
    PaleEndSettings,
    kept_for_later,
    with_followed_ends,
    with_pale_ends,
)
from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

LENGTH_MM, WIDTH_MM, PALE_MM = 16.0, 0.4, 3.6
PER_MM, AROUND_MM, DARKNESS = 60, 0.6, 0.55
WIDTH_PX = 11
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


def folded_detection(pale_part, stop_px=270):
    """Return a body in a picture whose last part, up to there, is paler than the threshold."""
    signal = np.zeros((140, 300), np.uint8)
    cv2.line(signal, (20, 70), (200, 70), 100, WIDTH_PX)
    if stop_px > 200:
        cv2.line(signal, (200, 70), (stop_px, 70), round(100 * pale_part), WIDTH_PX)
    cv2.circle(signal, (110, 70), 36, 100, WIDTH_PX)
    smooth = cv2.GaussianBlur(signal, (0, 0), 1.5)
    everything = whole_picture(signal.shape)
    view = SignalView(everything, signal, smooth, 50.0, 1.0, BlobSettings())
    return Detection(view, view.blobs()[0])


def model_with_pale_end():
    levels = np.full(65, 100.0)
    levels[-18:] = 30.0
    widths = np.full(65, float(WIDTH_PX))
    return BodyModel(
        250.0, WIDTH_PX, 2500.0, 100.0, WIDTH_PX, widths, levels, 1.0, BodyModelSettings(), 250.0
    )


@pytest.mark.parametrize(
    ("aside_px", "stop_px", "is_seen"),
    [
        pytest.param(0.0, 270, True, id="followed"),
        pytest.param(0.0, 213, True, id="less than what is found by itself"),
        pytest.param(0.0, 200, False, id="no more than its soft edge"),
        pytest.param(40.0, 270, False, id="followed elsewhere"),
    ],
)
def test_an_end_below_the_threshold_in_a_fold_is_seen_where_it_was_followed_to(
    aside_px, stop_px, is_seen
):
    seen = folded_detection(0.3, stop_px)
    body = np.stack([np.linspace(20.0, 270.0, 65), np.full(65, 70.0 + aside_px)], axis=1)
    found = with_followed_ends(seen, WIDTH_PX, body, PaleEndSettings())
    assert (found.blob.box[2] > seen.blob.box[2] + 4) is is_seen
    assert (found is seen) is not is_seen
    assert np.array_equal(found.view.smooth, seen.view.smooth)


def test_what_may_be_a_pale_end_is_kept_for_later():
    seen = folded_detection(0.3)
    assert seen.cropped(20).view.window[1].stop < 262
    assert kept_for_later(seen, 20, PaleEndSettings()).view.window[1].stop > 270


def test_a_window_that_cuts_a_pale_end_does_not_hold_the_worm():
    seen, settings = folded_detection(0.3), PaleEndSettings()
    known = DetectionPrior(model_with_pale_end())
    assert with_pale_ends(seen.cropped(20), known, settings, may_be_cut=True) is None
    for wide in (seen, seen.cropped(100)):
        found = with_pale_ends(wide, known, settings, may_be_cut=True)
        assert found.blob.box[2] > 262
