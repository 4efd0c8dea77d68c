"""A body that was lost is known again once it explains many pictures in a row."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from body_searches import search_after
from drawn_folds import DARKENING, Drawn

from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.propagation.explained_again import explained_again
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody

WIDTH = 12.0
SETTINGS = PropagationSettings()
LOST = SETTINGS.most_frames_unexplained + 1


def model_and_body(darkening=0.0, shorter=1.0, marks=0.0, **body):
    """Return a worm, and its body that was lost and lies in a loop, its ends apart."""
    drawn = Drawn.of([(12.0, 0.0), (1.5 * 3.14 * 2.5, 1 / 2.5), (7.0, 0.0)], WIDTH)
    path = BodyPath(evenly(drawn.curve, 240))
    model = search_after(path, WIDTH, 1, loops_known=True).model
    levels = model.levels * (1 + marks * (-1.0) ** np.arange(len(model.levels)))
    model = replace(model, darkening=darkening, length=path.length / shorter, levels=levels)
    given = {"end_sd_px": (0.5, 0.5), "frames_unexplained": LOST} | body
    return model, PropagatedBody(path, 0.95, 0.95, **given)


def counts(model, bodies, frames=1):
    """Return how long each of some bodies in a row has been lost: 0 where it is known."""
    before, lost = bodies[0], []
    for body in bodies:
        before = explained_again(body, before, frames, model, SETTINGS)
        lost.append(before.frames_unexplained)
    return lost


def test_it_is_known_again_after_as_many_pictures_as_are_asked_for():
    model, body = model_and_body()
    least = SETTINGS.least_frames_explained
    assert counts(model, [body] * least) == [LOST] * (least - 1) + [0]


def test_pictures_in_between_that_it_does_not_explain_are_not_passed_over():
    model, body = model_and_body()
    least = SETTINGS.least_frames_explained
    poor = replace(body, over_limits=2 * SETTINGS.most_over_limits_alone)
    bodies = [body] * (least - 1) + [poor] + [body] * least
    assert counts(model, bodies) == [LOST] * (2 * least - 1) + [0]


def test_one_in_between_in_which_an_end_is_not_told_does_not_count():
    model, body = model_and_body()
    least = SETTINGS.least_frames_explained
    hidden = replace(body, end_sd_px=(0.5, 0.4 * WIDTH))
    bodies = [body] * (least - 1) + [hidden, hidden, body]
    assert counts(model, bodies) == [LOST] * (least + 1) + [0]


def test_pictures_that_lie_apart_are_not_in_a_row():
    """Meanwhile its strands may have changed places."""
    model, body = model_and_body()
    assert set(counts(model, [body] * 30, frames=2)) == {LOST}


@pytest.mark.parametrize(
    "body",
    [
        pytest.param({"over_limits": 0.6}, id="leaves something over"),
        pytest.param({"hides_slack": True}, id="may be shorter"),
        pytest.param({"end_sd_px": (0.5, 0.4 * WIDTH)}, id="has an end that is not told"),
        pytest.param({"shorter": 0.9}, id="is shorter than the worm"),
        pytest.param({"shorter": 1.1}, id="is longer than the worm"),
    ],
)
def test_it_is_not_known_as_long_as_it(body):
    model, found = model_and_body(**body)
    assert set(counts(model, [found] * 30)) == {LOST}


@pytest.mark.parametrize("shorter", [0.9, 1.1])
def test_where_overlaps_are_darker_it_may_have_another_length(shorter):
    """It would leave something over; and a worm's stroke is longer than ten pictures."""
    model, body = model_and_body(darkening=DARKENING, shorter=shorter)
    least = SETTINGS.least_frames_explained
    assert counts(model, [body] * least) == [LOST] * (least - 1) + [0]


def test_one_with_marks_need_only_explain_its_pictures():
    """Something is left over of nearly all of them: a skin is known less well than one shade."""
    least, over = SETTINGS.least_frames_explained, {"over_limits": 0.9, "darkening": DARKENING}
    marked, body = model_and_body(marks=0.1, **over)
    assert marked.is_marked
    assert counts(marked, [body] * least) == [LOST] * (least - 1) + [0]
    plain, body = model_and_body(**over)
    assert set(counts(plain, [body] * 30)) == {LOST}
    poor = replace(body, over_limits=1.1)
    assert set(counts(marked, [poor] * 30)) == {LOST}


def test_a_body_that_was_not_lost_stays_as_it_is():
    model, body = model_and_body(frames_unexplained=0, outline_sd_px=(inf, inf))
    assert explained_again(body, body, 1, model, SETTINGS) is body
