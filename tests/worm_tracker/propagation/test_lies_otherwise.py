"""A body that no longer explains its picture is found where it lies, one or two errors away."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import candidate, search_after
from drawn_folds import LEVEL, Drawn, rounded_widths

from worm_tracker.midline.body_residual import ObjectMasks
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import turned_at_end
from worm_tracker.midline.strand_meetings import StrandExchangeSettings
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.lies_otherwise import followed_or_otherwise, is_doubted
from worm_tracker.propagation.propagation import propagate

WIDTH = 12.0
ARM, TURN = 16.0, 1 / 1.6
HOOK = [(ARM, 0.0), (np.pi / TURN, TURN), (6.0, 0.0)]
"""A hairpin open by two widths of water, its second arm the shorter one."""
LOOP = [(9.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (9.0, 0.0)]
"""A body that goes round a loop and crosses itself."""


def search_in(drawn, followed, end_sd_px):
    """Return the search in a drawn picture for a body that was followed along a path."""
    search = search_after(followed, drawn.width, 1, loops_known=True, end_sd_px=end_sd_px)
    at = np.linspace(0.0, drawn.length, 65)
    model = replace(
        search.model,
        length=drawn.length,
        first_length=drawn.length,
        widths=rounded_widths(at, drawn.width),
        levels=np.full(65, float(LEVEL)),
        level=float(LEVEL),
    )
    seen = ObjectMasks(drawn.mask, None, drawn.width, search.settings.residual)
    return replace(search, signal=drawn.signal, seen=seen, levels=model.levels, model=model)


def true_path(drawn):
    return BodyPath(evenly(drawn.at(np.linspace(0.0, drawn.length, 240)), 240))


def away_widths(found, drawn):
    """Return how far a body lies from the true one, in its order, widths."""
    true = drawn.at(np.linspace(0.0, drawn.length, len(found.path.points)))
    points = found.path.points @ np.array([1, 1j])
    return float(np.abs(points - true).max()) / drawn.width


def led_on_to_the_other_arm(drawn):
    """Return a hook's path whose last end leads over the water, and on along the first arm."""
    tip = drawn.at(np.array([drawn.length - 0.7 * drawn.width]))[0]
    whole = drawn.at(np.linspace(0.0, drawn.length - 0.7 * drawn.width, 220))
    beside = drawn.at(np.array([0.0]))[0] + (tip.real - drawn.at(np.array([0.0]))[0].real)
    onwards = beside + (whole[0] - whole[40]) / abs(whole[0] - whole[40]) * drawn.width * 9.0
    return BodyPath(evenly(np.r_[whole, np.linspace(beside, onwards, 40)], 240))


def test_an_end_thought_to_lie_on_the_other_strand_is_where_the_path_leaves_the_body():
    drawn = Drawn.of(HOOK, WIDTH)
    wrong = led_on_to_the_other_arm(drawn)
    assert abs(wrong.curve[-1] - drawn.curve[-1]) > 2.5 * WIDTH
    search = search_in(drawn, wrong, end_sd_px=(1.0, WIDTH))
    assert search.over_limits(search.slid(wrong)) > 1
    found = followed_or_otherwise(search)
    assert search.over_limits(found) <= 1
    assert found.was_exchanged
    assert away_widths(found, drawn) < 0.4


@pytest.mark.parametrize(("end_sd_px", "leaps"), [(1.0, True), (WIDTH, False)])
def test_only_an_end_that_was_hidden_may_lie_anywhere(end_sd_px, leaps):
    drawn = Drawn.of(HOOK, WIDTH)
    search = search_in(drawn, led_on_to_the_other_arm(drawn), end_sd_px=(1.0, end_sd_px))
    search = replace(search, model=replace(search.model, darkening=0.45))
    assert search.leaps(candidate(true_path(drawn))) is leaps
    first_end_off = BodyPath(evenly(true_path(drawn).curve[60:], 240))
    assert search.leaps(candidate(first_end_off))


@pytest.mark.parametrize("turned", [False, True])
def test_an_end_that_comes_out_where_none_was_expected_is_led_there(turned):
    """It was thought to lie hidden along the strand that it crossed: of one shade nothing tells."""
    drawn = Drawn.of([(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (7.0, 0.0)], WIDTH, darker=False)
    to_strand = drawn.length - 5.0 * WIDTH
    corner = drawn.at(np.array([to_strand]))[0]
    along = drawn.curve[0] - drawn.curve[8]
    hidden = corner + along / abs(along) * np.linspace(0.1, 3.5, 30) * WIDTH
    curve = evenly(np.r_[drawn.at(np.linspace(0.0, to_strand, 300)), hidden], 240)
    wrong = BodyPath(curve[::-1] if turned else curve)
    assert np.abs(wrong.curve[-1 if not turned else 0] - drawn.curve[-1]) > 4 * WIDTH
    search = search_in(drawn, wrong, (WIDTH, 1.0) if turned else (1.0, WIDTH))
    assert search.over_limits(search.slid(wrong)) > 1
    found = followed_or_otherwise(search)
    assert search.over_limits(found) <= 1
    tip = found.path.curve[0 if turned else -1]
    assert abs(tip - drawn.curve[-1]) < 0.3 * WIDTH


def closed_by_its_end(clear_widths):
    """Return a body that goes round a loop, its last end so far short of its own strand."""
    return Drawn.of([(18.0, 0.0), (1.5 * np.pi * 3.0, 1 / 3.0), (3.0 - clear_widths, 0.0)], WIDTH)


@pytest.mark.parametrize(("clear_widths", "is_turned"), [(0.0, False), (1.2, True)])
def test_a_loop_passed_the_wrong_way_is_turned_round_once_its_end_comes_off_its_strand(
    clear_widths, is_turned
):
    """Both ways cover the same until then."""
    drawn = closed_by_its_end(clear_widths)
    was = true_path(closed_by_its_end(0.0))
    wrong = turned_at_end(was, WIDTH, True, StrandExchangeSettings())
    found = followed_or_otherwise(search_in(drawn, wrong, end_sd_px=(1.0, 0.6 * WIDTH)))
    assert bool(away_widths(found, drawn) < 0.5) is is_turned
    assert found.was_exchanged is is_turned


def test_a_body_that_explains_its_picture_is_left_as_it_is():
    drawn = Drawn.of(LOOP, WIDTH)
    search = search_in(drawn, true_path(drawn), end_sd_px=(1.0, 1.0))
    found = followed_or_otherwise(search)
    assert not found.was_exchanged
    assert away_widths(found, drawn) < 0.3


@pytest.mark.parametrize(
    ("unexplained", "is_sought"), [(0, True), (5, True), (6, False), (8, True)]
)
def test_a_lost_body_is_sought_in_each_picture_at_first_and_then_now_and_then(
    unexplained, is_sought
):
    drawn = Drawn.of(HOOK, WIDTH)
    wrong = led_on_to_the_other_arm(drawn)
    search = search_in(drawn, wrong, end_sd_px=(1.0, WIDTH))
    search = replace(search, body=replace(search.body, frames_unexplained=unexplained))
    assert (search.over_limits(followed_or_otherwise(search)) <= 1) is is_sought


@pytest.mark.parametrize(
    ("unexplained", "opens", "is_fitted"),
    [(0, False, True), (5, False, True), (6, False, False), (8, False, True), (6, True, True)],
)
def test_a_lost_body_is_fitted_anew_as_often_or_where_it_may_have_opened(
    monkeypatch, unexplained, opens, is_fitted
):
    drawn = Drawn.of(HOOK, WIDTH)
    aside = true_path(drawn).shifted(2.0 * WIDTH)
    search = search_in(drawn, aside, end_sd_px=(1.0, 1.0))
    search = replace(search, body=replace(search.body, frames_unexplained=unexplained))
    fitted = []

    def best(scene, slid, starts, contour_body):
        fitted.append(contour_body)
        return slid

    monkeypatch.setattr(CandidateSearch, "of", lambda *_: search)
    monkeypatch.setattr(CandidateSearch, "best", best)
    monkeypatch.setattr(CandidateSearch, "contracted", lambda *_: None)
    body, settings, contour_body = search.body, search.settings, object() if opens else None
    found = propagate(None, search.model, body, None, 1, contour_body, settings)
    assert found.over_limits > settings.lost_over_limits
    assert bool(fitted) is is_fitted


@pytest.mark.parametrize(
    ("over_before", "is_marked", "is_sought"),
    [
        pytest.param(0.0, False, True, id="doubted for the first time"),
        pytest.param(0.0, True, True, id="doubted for the first time, with marks"),
        pytest.param(0.6, False, True, id="doubted before"),
        pytest.param(0.6, True, False, id="doubted before, with marks, which leave as much over"),
        pytest.param(0.45, True, True, id="with marks, but more is left over than before"),
    ],
)
def test_another_body_is_sought_anew_for_one_with_marks_only_where_more_is_left_over(
    over_before, is_marked, is_sought
):
    drawn = Drawn.of(HOOK, WIDTH)
    search = search_in(drawn, true_path(drawn), end_sd_px=(1.0, 1.0))
    marks = 1 + (0.1 * (-1.0) ** np.arange(65) if is_marked else np.zeros(65))
    search = replace(
        search,
        seen=replace(search.seen, dark=np.zeros_like(drawn.mask)),
        body=replace(search.body, over_limits=over_before),
        model=replace(search.model, levels=LEVEL * marks, darkening=0.45),
    )
    part = BodyPath(evenly(drawn.at(np.linspace(0.0, drawn.length - 0.7 * WIDTH, 240)), 240))
    found = candidate(part)
    limit = search.settings.residual.most_left_over
    found = replace(found, unexplained=replace(found.unexplained, left_over=0.62 * limit))
    assert 0.55 < search.over_limits(found) < 0.65
    assert is_doubted(search, found) is is_sought
