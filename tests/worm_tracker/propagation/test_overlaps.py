"""How dark overlaps are is told by the darkest places of an even body, and not of a marked one."""

from dataclasses import replace

import numpy as np
import pytest
from marked_strands import LENGTH, NODES, WIDTH, laid_back, marks

from worm_tracker.detection.blobs import BlobSettings, find_blobs, whole_picture
from worm_tracker.detection.detection import Detection, SignalView
from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.propagation.overlaps import (
    as_dark_as,
    as_dark_as_followed,
    marked_ends,
    overlaps_tell,
)
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody

SETTINGS = PropagationSettings()
EVEN = np.full(NODES, 90.0)
MARKED = marks(np.random.default_rng(2))
PALE = marks(np.random.default_rng(2), pale_widths=8.0)
PALE[:4] = 80.0, 110.0, 100.0, 70.0


def model_of(levels):
    widths = np.full(NODES, WIDTH)
    level = float(np.median(levels))
    return BodyModel(
        LENGTH, WIDTH, 3000.0, level, WIDTH, widths, levels, 1.0, BodyModelSettings(), LENGTH
    )


def midline_of(levels):
    points = np.c_[np.linspace(0.0, LENGTH, NODES), np.zeros(NODES)]
    level, widths = float(np.median(levels)), np.full(NODES, WIDTH)
    return RefinedMidline(points, widths, widths, levels, level, 1.0, 3000.0, 0.0, 0.0)


def seen_laid_back(levels, darkening):
    signal, line = laid_back(levels, 0.7 * LENGTH, darkening)
    window = whole_picture(signal.shape)
    blob = find_blobs(signal, 40.0, window, BlobSettings())[0]
    view = SignalView(window, signal, signal, 40.0, 1.0, BlobSettings())
    return Detection(view, blob), PropagatedBody(BodyPath(line), 0.95, 0.95)


@pytest.mark.parametrize("darkening", [0.4, 0.3])
def test_the_darkest_places_of_an_even_body_are_its_overlaps(darkening):
    detection, found = seen_laid_back(EVEN, 2 * darkening)
    model = as_dark_as(detection, model_of(EVEN), SETTINGS)
    assert (model.darkening == pytest.approx(2 * darkening, abs=0.03)) is (2 * darkening < 0.7)
    assert as_dark_as_followed(detection, model, found, SETTINGS) is model


@pytest.mark.parametrize("darkening", [0.5, 0.0])
def test_those_of_a_marked_one_do_not_tell_once_it_was_followed_into_overlaps(darkening):
    detection, found = seen_laid_back(MARKED, darkening)
    model = as_dark_as(detection, model_of(MARKED), SETTINGS)
    for _ in range(model.settings.overlap_frames):
        model = as_dark_as_followed(detection, model, found, SETTINGS)
    assert as_dark_as(detection, model, SETTINGS) is model
    assert model.darkening == pytest.approx(darkening, abs=0.06)
    assert overlaps_tell(model, SETTINGS) is (darkening > 0)


def test_a_body_that_does_not_explain_its_picture_tells_nothing_of_overlaps():
    detection, found = seen_laid_back(MARKED, 0.5)
    model = model_of(MARKED)
    assert as_dark_as_followed(detection, model, replace(found, over_limits=1.5), SETTINGS) is model


def test_overlaps_that_are_well_known_are_measured_in_every_eighth_picture_only():
    detection, found = seen_laid_back(MARKED, 0.5)
    model, measured = replace(model_of(MARKED), overlaps=(29, 0.3)), []
    for picture in range(18):
        anew = as_dark_as_followed(detection, model, found, SETTINGS)
        measured += [picture] if anew.overlaps != model.overlaps else []
        model = anew.updated(midline_of(MARKED), 3000.0, 1.0, False)  # it is seen open in between
    assert measured == [0, 8, 16]
    assert 0.3 < model.darkening < 0.5, "what is known follows what is seen"


def test_an_end_that_is_pale_and_has_marks_is_told_by_them():
    assert marked_ends(model_of(PALE), SETTINGS) == (True, False)
    assert marked_ends(model_of(PALE[::-1]), SETTINGS) == (False, True)
    assert marked_ends(model_of(MARKED), SETTINGS) == (False, False)
    plain = np.where(np.arange(NODES) < 24, 40.0, MARKED)
    assert model_of(plain).is_marked
    assert marked_ends(model_of(plain), SETTINGS) == (False, False)


def test_overlaps_seen_on_a_way_back_are_taken_where_they_are_more():
    detection, found = seen_laid_back(MARKED, 0.5)
    here = there = model_of(MARKED)
    for _ in range(there.settings.overlap_frames):
        assert here.with_overlaps_of(there) is here
        there = as_dark_as_followed(detection, there, found, SETTINGS)
    learned = here.with_overlaps_of(there)
    assert (learned.overlaps, learned.darkening) == (there.overlaps, there.darkening)
    assert there.with_overlaps_of(here) is there
