"""An end of an open body that may be bent back flat onto its flank is not told as one that is seen.

Its contour ends at the bend, and is broad there; a body that has grown shorter, too, hides an end.
"""

from dataclasses import replace

import numpy as np
import pytest

from worm_msgs_py import Status
from worm_tracker.detection.blobs import BlobSettings, whole_picture
from worm_tracker.detection.detection import SignalView
from worm_tracker.following.open_body import open_body
from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.body_residual import BodyResidualSettings
from worm_tracker.midline.curve import TRACKED_POINTS
from worm_tracker.midline.refine import RefinedMidline

WIDTH, LENGTH, LEVEL = 12.0, 240.0, 100.0
SETTINGS = BodyResidualSettings()


def straight(length, *, broader=(1.0, 1.0)):
    """Return a straight body whose last 18 pixels at either end are so many times as broad."""
    s = np.linspace(0.0, length, TRACKED_POINTS)
    first, last = broader
    widths = WIDTH * np.where(s < 1.5 * WIDTH, first, 1.0)
    widths = widths * np.where(length - s < 1.5 * WIDTH, last, 1.0)
    points = np.stack([30 + s, np.full_like(s, 40.0)], axis=1)
    levels = np.full_like(s, LEVEL)
    return RefinedMidline(points, widths, widths, levels, LEVEL, 1.0, WIDTH * length, 150.0, 40.0)


def picture():
    signal = np.zeros((80, 320), np.uint8)
    signal[34:47, 30:270] = round(LEVEL)
    return SignalView(whole_picture(signal.shape), signal, signal, 0.5 * LEVEL, 1.0, BlobSettings())


def known(frames=100):
    body = straight(LENGTH)
    return replace(BodyModel.of(body, body.area, 1.0, BodyModelSettings()), frames=frames)


def told(length, broader, model):
    return open_body(straight(length, broader=broader), 0.9, picture(), model, SETTINGS)


@pytest.mark.parametrize("length", [LENGTH, 0.9 * LENGTH])
def test_an_end_as_broad_as_the_worm_is_seen(length):
    seen = told(length, (1.0, 1.0), known())
    assert seen.status is Status.TRACKED
    assert seen.end_sd_px == (0.0, 0.0)


def test_a_broad_end_is_told_and_unsure_by_half_a_width():
    seen = told(LENGTH, (1.2, 1.0), known())
    assert seen.status is Status.TRACKED
    assert seen.end_sd_px == pytest.approx((0.5 * WIDTH, 0.0))
    assert seen.shows_pose


@pytest.mark.parametrize("is_last", [False, True])
def test_a_broad_end_of_a_body_that_is_shorter_is_hidden(is_last):
    broader = (1.0, 1.2) if is_last else (1.2, 1.0)
    seen = told(0.95 * LENGTH, broader, known())
    assert seen.status is Status.END_HIDDEN
    assert seen.broad_ends == (not is_last, is_last)
    hidden_px = sum(seen.occluded) * 0.95 * LENGTH / (TRACKED_POINTS - 1)
    assert seen.occluded[not is_last] == 0
    assert 2 * WIDTH < hidden_px < 3 * WIDTH
    assert np.array_equal(seen.points, straight(0.95 * LENGTH).points)


def test_a_broad_end_of_a_skin_with_marks_is_told_for_its_rim_may_be_pale_elsewhere():
    model = known()
    marked = replace(model, levels=model.levels * (1 + 0.1 * (-1.0) ** np.arange(TRACKED_POINTS)))
    seen = told(0.95 * LENGTH, (1.3, 1.0), marked)
    assert seen.status is Status.TRACKED
    assert seen.end_sd_px == pytest.approx((0.5 * WIDTH, 0.0))


@pytest.mark.parametrize("model", [None, known(frames=2)])
def test_nothing_is_doubted_while_the_worm_is_not_known(model):
    assert told(0.9 * LENGTH, (1.3, 1.0), model).status is Status.TRACKED
