"""What hangs on to an open body is debris, unless an end or a bend of the body may be missing."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.body_residual import BodyResidualSettings
from worm_tracker.midline.contour_body import broad_contour_ends, explains_object, may_hide_end
from worm_tracker.midline.curve import TRACKED_POINTS, as_points, length_of
from worm_tracker.midline.path import evenly
from worm_tracker.midline.refine import RefinedMidline

WIDTH, LEVEL = 12.0, 100
LEG = 10 * WIDTH


def kinked(turn_rad):
    """Return the midline of two legs, u + iv, that meet at an angle."""
    first = np.linspace(-LEG, 0.0, 40)
    last = np.linspace(0.0, LEG, 40)[1:] * np.exp(1j * turn_rad)
    return evenly(150 + 60j + np.r_[first, last], TRACKED_POINTS)


def pictured(line, beside):
    """Return an object: the body along a line, and a round piece that touches it on one side."""
    mask = np.zeros((300, 320), np.uint8)
    points = np.rint(16 * as_points(line[2:-2])).astype(np.int32)  # its ends are round
    cv2.polylines(mask, [points], False, 255, round(WIDTH), cv2.LINE_8, 4)
    centre = int(beside.real), int(beside.imag)
    cv2.circle(mask, centre, round(1.1 * WIDTH), 255, -1)
    return mask


def refined(line):
    widths = np.full(TRACKED_POINTS, WIDTH)
    levels = np.full(TRACKED_POINTS, float(LEVEL))
    area = WIDTH * float(np.abs(np.diff(line)).sum())
    return RefinedMidline(as_points(line), widths, widths, levels, LEVEL, 1.0, area, 0.0, 0.0)


@pytest.mark.parametrize(
    ("turn_rad", "at", "is_debris"),
    [
        pytest.param(1.2, 0.5, False, id="at a kink: a short hairpin that was left out"),
        pytest.param(1.2, 0.25, True, id="beside a leg of a kinked body"),
        pytest.param(0.2, 0.5, True, id="beside a body that hardly bends"),
        pytest.param(0.2, 0.02, False, id="at an end"),
    ],
)
def test_what_hangs_on_to_an_open_body_is_debris_but_at_ends_and_kinks(turn_rad, at, is_debris):
    line = kinked(turn_rad)
    k = round(at * (len(line) - 1))
    way = line[min(k + 1, len(line) - 1)] - line[max(k - 1, 0)]
    mask = pictured(line, line[k] - 1.5j * WIDTH * way / abs(way))
    smooth = np.where(mask > 0, LEVEL, 0).astype(np.uint8)
    settings = BodyResidualSettings()
    assert explains_object(refined(line), smooth, mask, False, None, settings) is is_debris


@pytest.mark.parametrize(
    ("is_hook", "is_all"),
    [
        pytest.param(False, True, id="straight to its end"),
        pytest.param(True, False, id="bent like a hook at its end"),
    ],
)
def test_a_known_worm_whose_end_is_a_hook_is_not_cut_at_its_bend(is_hook, is_all):
    line = kinked(0.2)
    mask = np.zeros((300, 320), np.uint8)
    hooked = np.r_[line[2:-2], line[-3] + np.array([1.2 + 0.6j, 0.6 + 1.2j]) * WIDTH]
    drawn = hooked if is_hook else line[2:-2]
    points = np.rint(16 * as_points(drawn)).astype(np.int32)
    cv2.polylines(mask, [points], False, 255, round(WIDTH), cv2.LINE_8, 4)
    smooth = np.where(mask > 0, LEVEL, 0).astype(np.uint8)
    body = refined(line)
    model = BodyModel.of(body, body.area, 1.0, BodyModelSettings())
    settings = BodyResidualSettings()
    assert explains_object(body, smooth, mask, False, model, settings) is is_all


@pytest.mark.parametrize("is_first", [True, False])
@pytest.mark.parametrize(
    ("broader", "at_end", "is_broad"),
    [
        pytest.param(1.0, 1.2, True, id="broader at an end than the worm is"),
        pytest.param(1.0, 1.05, False, id="hardly broader at an end"),
        pytest.param(1.2, 1.0, False, id="contracted: broader all along"),
        pytest.param(1.2, 1.2, True, id="contracted, and broader still at an end"),
    ],
)
def test_an_end_that_is_bent_back_makes_a_body_broad_there(broader, at_end, is_broad, is_first):
    body = refined(kinked(0.2))
    model = BodyModel.of(body, body.area, 1.0, BodyModelSettings())
    near = np.abs(np.diff(kinked(0.2))).sum() * np.linspace(0, 1, TRACKED_POINTS) < 1.5 * WIDTH
    near = near if is_first else near[::-1]
    found = replace(body, widths=body.widths * broader * np.where(near, at_end, 1.0))
    ends = broad_contour_ends(found, model, BodyResidualSettings())
    assert ends == ((is_broad, False) if is_first else (False, is_broad))


def test_a_pale_rim_that_comes_and_goes_does_not_make_the_end_of_a_marked_body_broad():
    body = refined(kinked(0.2))
    marked = replace(body, levels=body.levels * (1 + 0.1 * (-1.0) ** np.arange(TRACKED_POINTS)))
    near = np.abs(np.diff(kinked(0.2))).sum() * np.linspace(0, 1, TRACKED_POINTS) < 1.5 * WIDTH
    found = replace(body, widths=body.widths * np.where(near, 1.12, 1.0))
    is_broad = [
        broad_contour_ends(
            found, BodyModel.of(known, known.area, 1.0, BodyModelSettings()), BodyResidualSettings()
        )
        for known in (body, marked)
    ]
    assert is_broad == [(True, False), (False, False)]


@pytest.mark.parametrize(
    ("known_over_found", "most", "hides"),
    [(1.3, 0.24, True), (1.2, 0.24, False), (1.3, np.inf, False), (0.9, 0.24, False)],
)
def test_a_body_shorter_than_a_stroke_makes_it_may_hide_an_end(known_over_found, most, hides):
    body = refined(kinked(0.2))
    model = BodyModel.of(body, body.area, 1.0, BodyModelSettings())
    model = replace(model, length=known_over_found * length_of(body.points))
    assert may_hide_end(body, model, most, BodyResidualSettings()) is hides
