"""A body that was lost for long is found anew where the picture shows it, from its ends alone."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import search_after
from crawling_worm import FRAME_NS
from drawn_folds import DARKENING, LEVEL, Drawn, rounded_widths

from worm_model.evaluation.distances import as_given_rms, resampled
from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_tracker.midline.body_model import BodyModelSettings
from worm_tracker.midline.body_residual import ObjectMasks, dark_places
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.propagation.traced_anew import traced_anew
from worm_tracker.tracker import TRACKER, Tracker

WIDTH = 12.0
LOST = PropagationSettings().most_frames_unexplained + 2
LOOP = [(12.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (7.0, 0.0)]
OPEN = [(12.0, 0.0), (6.0, 0.3), (8.0, -0.2), (5.0, 0.0)]


def lost_in(drawn, frames, frames_unexplained=0, length_over_true=1.0):
    """Return the search for a body last said to lie straight across the picture."""
    darkening = DARKENING if drawn.darker else 0.0
    heights = 5.0 + 1j * drawn.signal.shape[0] / 2
    straight = BodyPath(evenly(heights + np.linspace(0.0, drawn.length, 240), 240))
    search = search_after(straight, drawn.width, frames, loops_known=True)
    settings = search.model.settings
    model = replace(
        search.model,
        frames=settings.young_frames,
        is_settled=True,
        length=length_over_true * drawn.length,
        first_length=drawn.length,
        widths=rounded_widths(np.linspace(0.0, drawn.length, 65), drawn.width),
        levels=np.full(65, float(LEVEL)),
        level=float(LEVEL),
        darkening=darkening,
    )
    dark = None
    if drawn.darker:
        dark = dark_places(drawn.signal, LEVEL, DARKENING, search.settings.residual)
    seen = ObjectMasks(drawn.mask, dark, drawn.width, search.settings.residual)
    body = replace(search.body, frames_unexplained=frames_unexplained)
    return replace(
        search, signal=drawn.signal, seen=seen, levels=model.levels, model=model, body=body
    )


def away_widths(found, drawn):
    """Return how far a body lies from the true one, in the order that is nearer, widths."""
    true = drawn.at(np.linspace(0.0, drawn.length, len(found.path.points)))
    points = found.path.points @ np.array([1, 1j])
    return min(np.abs(points - way).max() for way in (true, true[::-1])) / drawn.width


@pytest.mark.parametrize("arcs", [LOOP, OPEN], ids=["loop", "open"])
@pytest.mark.parametrize("heading", [0.0, 2.2])
def test_a_body_lost_for_long_is_found_by_its_ends(arcs, heading):
    drawn = Drawn.of(arcs, WIDTH, heading)
    search = lost_in(drawn, frames=LOST)
    found = traced_anew(search)
    assert search.over_limits(found) <= 1
    assert away_widths(found, drawn) < 0.4
    assert found.end_sd_px[0] < 0.5 * WIDTH
    assert found.end_sd_px[1] < 0.5 * WIDTH


@pytest.mark.parametrize("heading", [0.0, 2.2])
def test_of_one_shade_it_is_followed_on_from_there_and_is_not_known_yet(heading):
    """Bodies that lie otherwise may explain one picture as well."""
    drawn = Drawn.of(LOOP, WIDTH, heading, darker=False)
    search = lost_in(drawn, frames=LOST)
    found = traced_anew(search)
    assert away_widths(found, drawn) < 0.4
    assert search.in_picture(found).frames_unexplained == LOST - 1


@pytest.mark.parametrize("length_over_true", [0.9, 1.0, 1.1])
def test_where_its_loop_may_be_passed_otherwise_it_is_followed_on_and_is_not_known_yet(
    length_over_true,
):
    search = lost_in(Drawn.of(LOOP, WIDTH), frames=LOST, length_over_true=length_over_true)
    assert search.in_picture(traced_anew(search)).frames_unexplained == 0
    ambiguous = replace(search.settings, least_bend_of_other_way_rad2=100.0)
    search = replace(search, settings=ambiguous)
    found = traced_anew(search)
    assert away_widths(found, Drawn.of(LOOP, WIDTH)) < 0.4
    assert search.in_picture(found).frames_unexplained == LOST - 1


@pytest.mark.parametrize("length_over_true", [0.85, 1.15])
def test_of_one_shade_nothing_of_another_length_is_the_worm(length_over_true):
    drawn = Drawn.of(LOOP, WIDTH, darker=False)
    assert traced_anew(lost_in(drawn, LOST, length_over_true=length_over_true)) is None
    darker = Drawn.of(LOOP, WIDTH)
    assert traced_anew(lost_in(darker, LOST, length_over_true=length_over_true)) is not None


def test_a_body_followed_until_now_is_not_sought_elsewhere():
    drawn = Drawn.of(LOOP, WIDTH)
    assert traced_anew(lost_in(drawn, frames=1)) is None
    assert traced_anew(lost_in(drawn, frames=1, frames_unexplained=LOST)) is None  # not yet again


def test_what_no_traced_body_explains_stays_unexplained():
    drawn = Drawn.of(LOOP, WIDTH)
    search = lost_in(drawn, frames=LOST)
    blot = search.seen.mask.copy()
    blot[: 4 * int(WIDTH), : 4 * int(WIDTH)] = 255  # more than a worm
    assert traced_anew(replace(search, seen=replace(search.seen, mask=blot))) is None


@pytest.mark.parametrize(("scene", "px_per_mm"), [("crossing", 20.0), ("coil", 30.0)])
def test_a_worm_that_comes_back_into_view_folded_is_told_before_it_opens(scene, px_per_mm):
    """For 1.6 s no picture shows it; from then on it lies in a loop or a coil."""
    shots = list(SCENES[scene](Take(px_per_mm=px_per_mm, frames=87)))
    follower = replace(TRACKER.follower, body_model=BodyModelSettings(young_frames=20))
    tracker = Tracker(settings=replace(TRACKER, follower=follower))
    given, seen = [], [*range(45), *range(70, 87)]
    for frame in seen:
        given += tracker.push(shots[frame].picture, frame * FRAME_NS)
    given += tracker.finish()
    assert min(one.state.head_certainty for one in given[:45]) > SURE_HEAD_CERTAINTY
    for k in range(45):
        head, truth = given[k].state.head, shots[seen[k]].truth
        away = np.hypot(head.u_px - truth.midline_u_px[0], head.v_px - truth.midline_v_px[0])
        assert away < given[k].state.width_px
    told = [k for k in range(45, len(seen)) if given[k].state.status.has_pose]
    assert len(told) > 10
    for k in told:
        one, truth = given[k], shots[seen[k]].truth
        found = resampled(np.stack([one.midline.u_px, one.midline.v_px], axis=1))
        real = resampled(np.stack([truth.midline_u_px, truth.midline_v_px], axis=1))
        # Which end is which only motion tells after so long, and the coil's worm backs out.
        assert min(as_given_rms(order, real) for order in (found, found[::-1])) < 3.0


def test_a_worm_of_which_little_has_been_seen_is_not_sought_so():
    drawn = Drawn.of(LOOP, WIDTH)
    search = lost_in(drawn, frames=LOST)
    young = replace(search.model, frames=search.model.settings.young_frames - 1)
    assert traced_anew(replace(search, model=young)) is None
