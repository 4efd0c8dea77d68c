"""A worm that crosses itself, coils and backs out keeps its midline and its head."""

import math
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from body_searches import candidate, kinked_loop, search_after, search_in
from crawling_worm import FRAME_NS
from drawn_folds import DARKENING, LEVEL, Drawn, laid, rounded_widths

from worm_model.evaluation.distances import as_given_rms, resampled
from worm_model.simulator.scenes import SCENES, Take
from worm_msgs_py import Status
from worm_tracker.following.follower import Follower
from worm_tracker.following.follower_settings import FollowerSettings
from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.body_residual import (
    ObjectMasks,
)
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_strands
from worm_tracker.parameters import TrackerParameters
from worm_tracker.propagation.propagation import observation_of
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.tracker import Tracker
from worm_tracker.worm_track import LastBodies, PropagatedBody, WormTrack


def filmed(scene, frames, first=0, px_per_mm=20.0):
    """Return pictures and truth of a scene, from a frame on."""
    shots = list(SCENES[scene](Take(px_per_mm=px_per_mm, frames=frames)))[first:]
    return [shot.picture for shot in shots], [shot.truth for shot in shots]


def tracked(pictures, **parameters):
    tracker = Tracker(TrackerParameters(**parameters))
    given = []
    for frame, picture in enumerate(pictures):
        given += tracker.push(picture, frame * FRAME_NS)
        assert tracker.held <= tracker._parameters.hold_back_frames
    return tracker, given + tracker.finish()


def midline_errors(given, truth):
    """Return the rms distance of each midline from the true one, head on head."""
    errors = []
    for one, true in zip(given, truth, strict=True):
        found = resampled(np.stack([one.midline.u_px, one.midline.v_px], axis=1))
        real = resampled(np.stack([true.midline_u_px, true.midline_v_px], axis=1))
        errors.append(math.inf if found is None else as_given_rms(found, real))
    return np.array(errors)


def centroid_errors(given, truth):
    return np.array(
        [
            math.hypot(
                one.state.centroid.u_px - true.centroid_u_px,
                one.state.centroid.v_px - true.centroid_v_px,
            )
            for one, true in zip(given, truth, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ("scene", "frames", "px_per_mm"),
    [("crossing", 95, 20.0), ("crossing_of_one_shade", 95, 20.0), ("coil", 190, 30.0)],
)
def test_midline_and_head_are_propagated_through(scene, frames, px_per_mm):
    """The first loop of the crossings opens at frame 87; the coil is closed half of the time."""
    pictures, truth = filmed(scene, frames, px_per_mm=px_per_mm)
    _, given = tracked(pictures)
    kinds = Counter(one.state.status for one in given)
    assert set(kinds) <= {Status.TRACKED, Status.FOLDED, Status.END_HIDDEN}
    assert kinds[Status.FOLDED] > 20
    assert kinds[Status.END_HIDDEN] < 10  # while a tip lies on the body for long
    errors = midline_errors(given, truth)
    errors = errors[np.isfinite(errors)]
    assert np.median(errors) < 0.4
    assert np.percentile(errors, 90) < 0.7  # others: a tip lies on the body for a moment
    assert errors.max() < 3.0
    assert np.median(centroid_errors(given, truth)) < 0.3
    assert max(centroid_errors(given, truth)) < 1.5


def test_a_film_that_begins_with_a_loop_is_told_by_the_frames_after_it():
    pictures, truth = filmed("crossing_of_one_shade", 110, first=68)
    _, given = tracked(pictures)
    kinds = Counter(one.state.status for one in given)
    assert kinds[Status.TRACKED] + kinds[Status.FOLDED] > 30
    errors = midline_errors(given, truth)
    errors = errors[np.isfinite(errors)]
    assert np.median(errors) < 0.4
    assert np.percentile(errors, 95) < 1.3


@pytest.mark.parametrize("hidden", [range(76, 78), range(74, 76)])
def test_a_way_back_goes_on_behind_pictures_that_do_not_show_the_body(hidden):
    """A shadow of several body widths lies on the worm in them, where it crosses itself."""
    pictures, truth = filmed("crossing_of_one_shade", 110, first=68)
    for frame in hidden:
        true = truth[frame - 68]
        at = round(true.centroid_u_px), round(true.centroid_v_px)
        cv2.circle(pictures[frame - 68], at, 25, 60, -1)
    _, given = tracked(pictures)
    behind = slice(0, hidden.start - 68)
    assert all(one.state.status is not Status.COILED for one in given[behind])
    errors = midline_errors(given, truth)[behind]
    assert np.median(errors[np.isfinite(errors)]) < 0.4
    shown = [given[frame - 68].state.status for frame in hidden]
    assert set(shown) == {Status.COILED}


def test_a_loop_waits_for_no_longer_than_it_may_and_its_centroid_is_that_of_its_pixels():
    pictures, truth = filmed("crossing_of_one_shade", 80, first=68)
    _, given = tracked(pictures, hold_back_frames=4)
    assert {one.state.status for one in given} == {Status.COILED}
    assert max(centroid_errors(given, truth)) < 0.5


def test_ends_laid_anew_each_where_the_other_was_are_not_kept():
    path = kinked_loop(2.5, 15.0)
    search = search_after(path, 15.0, 1, loops_known=True)
    assert search.keeps_ends(candidate(path))
    assert not search.keeps_ends(candidate(path.turned_round()))


def test_a_body_that_leaves_something_over_is_not_told_whatever_is_known_of_its_loops():
    body = PropagatedBody(kinked_loop(2.5, 15.0), 0.95, 0.95, over_limits=1.2)
    assert not body.is_explained


@pytest.mark.parametrize(
    ("before", "frames", "left_over_widths2", "unexplained"),
    [
        pytest.param(0, 1, 0.1, 0, id="followed"),
        pytest.param(2, 1, 0.3, 3, id="not explained yet"),
        pytest.param(5, 1, 0.1, 0, id="explained in time"),
        pytest.param(6, 1, 0.1, 6, id="explained too late"),
        pytest.param(0, 6, 0.1, 0, id="sought in time"),
        pytest.param(0, 7, 0.1, 6, id="sought too late"),
    ],
)
def test_a_body_is_not_told_again_once_its_strands_had_time_to_change_places(
    before, frames, left_over_widths2, unexplained
):
    path = kinked_loop(2.5, 15.0)
    search = search_after(path, 15.0, frames, loops_known=True)
    search = replace(search, body=replace(search.body, frames_unexplained=before))
    left = search.frames_unexplained(candidate(path, left_over_widths2))
    assert left == unexplained
    assert replace(search.body, frames_unexplained=left).is_explained is (unexplained == 0)


LINE = [(16.0, 0.05)]
ACROSS_ITSELF = [(6.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (6.0, 0.0)]


@pytest.mark.parametrize(
    ("arcs", "left_over_widths2", "overlaps_are_told", "is_found_again"),
    [
        pytest.param(LINE, 0.0, True, True, id="nothing else explains the picture"),
        pytest.param(ACROSS_ITSELF, 0.0, True, True, id="the other way bends much more"),
        pytest.param(LINE, 0.15, False, True, id="it lies apart from itself"),
        pytest.param(ACROSS_ITSELF, 0.15, True, False, id="something is left over"),
        pytest.param(ACROSS_ITSELF, 0.0, False, False, id="overlaps are not told"),
        pytest.param(None, 0.0, True, False, id="a loop may be passed either way"),
    ],
)
def test_a_lost_body_is_found_again_where_no_other_explains_the_picture(
    arcs, left_over_widths2, overlaps_are_told, is_found_again
):
    width = 15.0
    path = kinked_loop(2.5, width) if arcs is None else BodyPath(evenly(laid(arcs, width), 240))
    search = search_after(path, width, 1, loops_known=True)
    dark = search.signal if overlaps_are_told else None
    lost = replace(search.body, frames_unexplained=9)
    search = replace(search, body=lost, seen=replace(search.seen, dark=dark))
    left = search.frames_unexplained(candidate(path, left_over_widths2))
    assert left == (0 if is_found_again else 9)


def tapered_body(turned):
    """Return a search in a picture of a tapered body, and the body the right or wrong way round."""
    width, n = 12.0, 65
    drawn = Drawn.of([(16.0, 0.08)], width)
    s = np.linspace(0.0, drawn.length, n)
    widths = rounded_widths(s, width) * np.clip(1.0 - 0.1 * (s / width - 6.0), 0.2, 1.0)
    path = BodyPath(evenly(drawn.curve, 240))
    mask, *_ = drawn_strands(drawn.mask.shape, path.points, widths, width, StrandDrawingSettings())
    search = search_after(path, width, 1, loops_known=True)
    search = replace(
        search,
        seen=ObjectMasks(mask, None, width, search.settings.residual),
        model=replace(search.model, widths=widths, frames=30),
    )
    last = path.turned_round() if turned else path
    return replace(search, last=last, body=replace(search.body, path=last)), last


@pytest.mark.parametrize("turned", [True, False])
def test_a_body_followed_the_wrong_way_round_is_turned_round_by_its_widths(turned):
    search, path = tapered_body(turned)
    told = search.turned_round(search.scored(path, search.model.widths))
    assert told.turned_round is turned
    assert np.array_equal(told.path.curve, path.curve[::-1] if turned else path.curve)
    assert search.over_limits(told) <= 1


def test_a_body_as_wide_at_both_ends_is_not_turned_round():
    search, path = tapered_body(turned=True)
    even = np.full(65, 12.0)
    search = replace(search, model=replace(search.model, widths=even))
    assert not search.turned_round(search.scored(path, even)).turned_round


def test_a_body_of_which_little_has_been_seen_is_not_turned_round():
    search, path = tapered_body(turned=True)
    search = replace(search, model=replace(search.model, frames=2))
    assert not search.turned_round(search.scored(path, search.model.widths)).turned_round


@pytest.mark.parametrize("turned", [True, False])
def test_widths_tell_which_end_is_which_beside_something_else(turned):
    search, path = tapered_body(turned)
    mask = search.seen.mask.copy()
    mask[20:40, 20:40] = 255
    search = replace(search, seen=ObjectMasks(mask, None, 12.0, search.settings.residual))
    told = search.turned_round(search.scored(path, search.model.widths))
    assert told.turned_round is turned
    assert not search.order_known(told, None), "what leaves something over may lie elsewhere"


@pytest.mark.parametrize(
    ("frames", "even", "is_known"), [(30, False, True), (2, False, False), (30, True, False)]
)
def test_the_order_is_known_of_a_body_whose_ends_differ_once_its_widths_are(frames, even, is_known):
    search, path = tapered_body(turned=False)
    widths = np.full(65, 12.0) if even else search.model.widths
    search = replace(search, model=replace(search.model, widths=widths, frames=frames))
    mask, *_ = drawn_strands(
        search.seen.mask.shape, path.points, widths, 12.0, StrandDrawingSettings()
    )
    search = replace(search, seen=ObjectMasks(mask, None, 12.0, search.settings.residual))
    found = search.scored(path, widths)
    assert search.over_limits(found) <= 1
    assert search.order_known(found, None) is is_known


@pytest.mark.parametrize(
    ("length_over_known", "unexplained", "continues"),
    [
        pytest.param(0.8, 0, True, id="a short body that was followed"),
        pytest.param(0.8, 6, False, id="a body laid double"),
        pytest.param(0.95, 6, True, id="all of the body"),
    ],
)
def test_after_a_body_was_lost_a_contour_must_show_its_known_length(
    length_over_known, unexplained, continues
):
    path = kinked_loop(2.5, 15.0)
    search = search_after(path, 15.0, 1, loops_known=True)
    track = WormTrack()
    track.learn(replace(search.model, length=path.length / length_over_known))
    lost = replace(search.body, frames_unexplained=unexplained)
    track.bodies = LastBodies(path.points, path.points, lost)
    seen = SimpleNamespace(blob=SimpleNamespace(area=200.0), occluder=None)
    follower = Follower(track, (9, 9), FollowerSettings())
    found = SimpleNamespace(points=path.points)
    assert follower._continues(found, seen) is continues


@pytest.mark.parametrize(
    ("longer", "scatter", "status"),
    [
        pytest.param(0.0, 0.001, Status.FOLDED, id="all of a body that keeps its length"),
        pytest.param(0.0, 0.03, Status.END_HIDDEN, id="a length that is right by chance"),
        pytest.param(2.0, 0.001, Status.END_HIDDEN, id="a body that may go on unseen"),
    ],
)
def test_an_end_against_the_body_of_one_shade_is_as_sure_as_the_length(longer, scatter, status):
    """Seen to turn back by six widths."""
    width = 10.0
    path = BodyPath(laid([(14.0, 0.0), (1.25, np.pi / 1.25), (6.0, 0.0)], width))
    widths = np.full(len(path.points), width)
    model = BodyModel(
        length=path.length + longer * width,
        width=width,
        area=200.0,
        level=100.0,
        half_height_width=width,
        widths=widths,
        levels=np.full(len(widths), 100.0),
        gain=1.0,
        settings=BodyModelSettings(),
        first_length=path.length,
        length_scatter=scatter,
    )
    body = PropagatedBody(path, 0.95, 0.95, 0j, (1.0, 1.0))
    told = observation_of(body, model, 0.95, PropagationSettings())
    assert told.status is status
    unsure = max(1.0, longer * width, scatter * model.length)
    assert told.end_sd_px == pytest.approx((1.0, unsure))
    dark = replace(model, darkening=0.5)  # where overlaps are darker, the end is seen
    assert observation_of(body, dark, 0.95, PropagationSettings()).status is Status.FOLDED
    pale = np.where(np.arange(len(widths)) > 0.75 * len(widths), 45.0, 100.0)  # but for a pale one
    faint = replace(dark, levels=pale, length_scatter=0.03)
    assert observation_of(body, faint, 0.95, PropagationSettings()).status is Status.END_HIDDEN


@pytest.mark.parametrize(
    ("arcs", "shorter", "pale", "status"),
    [
        pytest.param(ACROSS_ITSELF, 0.1, True, Status.FOLDED, id="a stroke shortens it as much"),
        pytest.param(ACROSS_ITSELF, 0.2, True, Status.END_HIDDEN, id="its end may be missing"),
        pytest.param(ACROSS_ITSELF, 0.2, False, Status.FOLDED, id="an end not pale is seen"),
        pytest.param(LINE, 0.2, True, Status.TRACKED, id="an open body shows its ends"),
    ],
)
def test_a_short_folded_body_with_a_pale_end_may_go_on_unseen(arcs, shorter, pale, status):
    width = 10.0
    path = BodyPath(laid(arcs, width))
    search = search_after(path, width, 1, loops_known=True)
    levels = np.where(pale & (np.linspace(0.0, 1.0, 65) > 0.75), 45.0, 100.0)
    model = replace(search.model, length=path.length / (1 - shorter), levels=levels)
    body = PropagatedBody(path, 0.95, 0.95, 0j, (1.0, 1.0))
    assert observation_of(body, model, 0.95, PropagationSettings()).status is status


@pytest.mark.parametrize(
    ("missing_widths", "by_darkness", "lacks"),
    [
        pytest.param(0.0, True, (False, False), id="all of it"),
        pytest.param(1.0, True, (False, True), id="its tip is a dark place under one strand"),
        pytest.param(1.0, False, (False, False), id="overlaps are no darker"),
    ],
)
def test_an_end_on_the_body_beside_which_something_is_missing_lies_elsewhere(
    missing_widths, by_darkness, lacks
):
    """The tip lies within the flank that the body comes back to: the outline is the same."""
    width = 12.0
    drawn = Drawn.of([(4.0, 0.0), (7.5, 0.6), (2.6, 0.0)], width, 0.3)
    points, widths = drawn.claimed(last_widths=missing_widths)
    path = BodyPath(evenly(points @ np.array([1, 1j]), 240))
    search = search_in(drawn.signal, drawn.curve, path, widths, LEVEL, DARKENING, by_darkness)
    found = search.scored(path, widths)
    assert search.ends_lack(found) == lacks
    sd_px = search.in_picture(found).end_sd_px
    assert sd_px == tuple(width * one for one in lacks)


@pytest.mark.parametrize(
    ("shorter", "near_itself", "hides"),
    [
        pytest.param(0.1, True, True, id="an end has gone onto the body"),
        pytest.param(0.02, True, False, id="a stroke"),
        pytest.param(0.1, False, False, id="an open body that contracts"),
    ],
)
def test_a_body_that_was_longer_while_it_lay_near_itself_hides_a_part(shorter, near_itself, hides):
    width = 12.0
    path = kinked_loop(3.0, width) if near_itself else BodyPath(np.linspace(0, 300, 240) + 0j)
    search = search_after(path, width, 1, loops_known=True)
    line = np.stack([np.linspace(0.0, (1 - shorter) * path.length, 65), np.zeros(65)], axis=1)
    assert search.hides_a_part(SimpleNamespace(points=line)) is hides


S_SHAPED = [(6.0, 0.0), (1.0, 1.0), (1.0, -1.0)]
S_AT_END = [(0.3, 0.0), (1.0, 1.0), (1.0, -1.0)]


@pytest.mark.parametrize(
    ("before", "after", "marked", "darkening", "is_in_doubt"),
    [
        pytest.param(S_SHAPED, ACROSS_ITSELF, True, 0.5, True, id="an S in a folded skin"),
        pytest.param(S_AT_END, ACROSS_ITSELF, True, 0.5, True, id="at its end, which is seen"),
        pytest.param(S_SHAPED, ACROSS_ITSELF, True, 0.0, False, id="overlaps no darker"),
        pytest.param(S_SHAPED, ACROSS_ITSELF, False, 0.5, False, id="without marks"),
        pytest.param(S_SHAPED, LINE, True, 0.5, False, id="open"),
        pytest.param(LINE, ACROSS_ITSELF, True, 0.5, False, id="no S"),
    ],
)
def test_where_a_folded_skin_makes_an_s_its_midline_is_in_doubt(
    before, after, marked, darkening, is_in_doubt
):
    width = 10.0
    path = BodyPath(evenly(laid([*before, *after], width), 300))
    search = search_after(path, width, 1, loops_known=True)
    levels = np.tile([80.0, 120.0], 33)[:65] if marked else np.full(65, 100.0)
    model = replace(search.model, levels=levels, darkening=darkening)
    told = observation_of(PropagatedBody(path, 0.95, 0.95), model, 0.95, PropagationSettings())
    assert (told.status is Status.LOOP_IN_DOUBT) is is_in_doubt
    assert (told.in_doubt != (0, 0)) is is_in_doubt
    assert told.told_points[[0, -1]].all()
    if is_in_doubt:
        s = (before[0][0] + 1.0) * width / path.length * 64  # where it bends the other way
        assert told.in_doubt[0] < s < told.in_doubt[1] < s + 0.2 * 64
