"""A worm that moves as real ones did, through hairpins and loops: its body, by exact truth."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.drawn_lines import LINE_LOOKS, light_and_wall, picture_of, true_line_px

from worm_model.evaluation.distances import resampled
from worm_model.simulator.folded_worms import LOOKS, film_worm, read_folded_worms, rig_for
from worm_model.simulator.rig.strands import is_folded
from worm_msgs_py import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

WORMS = Path(__file__).parents[2] / "bags" / "source" / "folded_worms.npz"


HOUR_NS = 3600 * 10**9


def tracked(name, first, last, look_name="darker", paused_at=None):
    """Return what the tracker says of a stretch of a film, and the true bodies.

    The recording stands still for an hour before the frame `paused_at`.
    """
    look, worm = LOOKS[look_name], read_folded_worms(WORMS)[name]
    worm = replace(worm, midlines_mm=worm.midlines_mm[first:last])
    tracker, given, bodies = Tracker(TrackerParameters()), [], []
    for frame, body in film_worm(rig_for(look, seed=int(name)), worm, look):
        late_ns = HOUR_NS * (paused_at is not None and first + len(bodies) >= paused_at)
        bodies.append(body)
        given += tracker.push(frame.picture, frame.stamp_ns + late_ns)
    return given + tracker.finish(), bodies


def off_widths(one, body):
    """Return how far the midline is off at most, either way round, in widths; NaN without one.

    Where a loop is in doubt, how far what is told of it strays from the body.
    """
    if not one.state.status.has_pose:
        return np.nan
    line = np.stack([one.midline.u_px, one.midline.v_px], axis=1)
    if one.state.status is Status.LOOP_IN_DOUBT:
        return strays_px(line, body).max() / body.mean_width_px
    line, true = resampled(line), resampled(body.points_px)
    away = min(np.abs(way - true).max() for way in (line, line[::-1]))
    return away / body.mean_width_px


def strays_px(line, body):
    """Return how far the points told of a midline are from the body's."""
    told = line[np.isfinite(line).all(axis=1)]
    true = body.at(np.linspace(0.0, body.length_px, 400))
    return np.hypot(*np.moveaxis(told[:, np.newaxis] - true, 2, 0)).min(axis=1)


@pytest.mark.parametrize(
    ("name", "first", "last"),
    [
        pytest.param("4003", 350, 450, id="a hairpin is made"),
        pytest.param("4005", 190, 290, id="a film begins in one"),
    ],
)
def test_a_body_is_right_through_hairpins(name, first, last):
    given, bodies = tracked(name, first, last)
    folded = np.array([is_folded(body) for body in bodies])
    off = np.array([off_widths(*pair) for pair in zip(given, bodies, strict=True)])
    assert folded.sum() > 40
    told = np.isfinite(off)
    assert told[folded].mean() > 0.8
    assert (off[told & folded] < 1.0).mean() > 0.95
    assert off[told & ~folded].max() < 1.0


def test_a_thin_end_along_its_own_flank_is_told_where_it_lies():
    """No outline shows it: a sliver beside the strand is paler than half of the body."""
    given, bodies = tracked("4005", 625, 785)
    folded = np.array([is_folded(body) for body in bodies])
    off = np.array([off_widths(*pair) for pair in zip(given, bodies, strict=True)])
    told = np.isfinite(off)
    assert told[folded].mean() > 0.75
    assert off[told].max() < 1.0


def test_a_head_that_is_farther_off_than_contact_allows_is_said_to_be_unsure():
    """A head on the body is right to a width, where contact asks for 0.3 of one."""
    given, bodies = tracked("4005", 500, 580)
    folded = np.array([is_folded(body) for body in bodies])
    heads = np.array([(one.state.head.u_px, one.state.head.v_px) for one in given])
    true, width_px = np.array([body.points_px[0] for body in bodies]), bodies[0].mean_width_px
    off = np.hypot(*(heads - true).T) / width_px
    sd = np.array([one.state.head_sd_m / one.state.width_m for one in given])
    assert np.isfinite(off).all()
    assert (sd > 0.15).sum() > 10
    assert off[sd < 0.15].max() < 0.1
    assert np.all(off < 3 * np.maximum(sd, 0.05))
    assert np.all(sd[~folded] == 0.0)


def test_a_loop_whose_end_was_cut_off_with_debris_is_not_told_as_an_open_body():
    """The tail lies across the body, between specks that hang on to it; no tip of it is seen."""
    given, bodies = tracked("4002", 900, 992, "coarse")
    off = np.array([off_widths(*pair) for pair in zip(given, bodies, strict=True)])
    cut_off = off[-27:]
    assert all(is_folded(body) for body in bodies[-27:])
    assert np.isfinite(cut_off).mean() > 0.8  # it has been followed into the loop
    assert np.nanmax(cut_off) < 1.0


def test_a_recording_that_paused_for_an_hour_in_a_fold_goes_on():
    """A way foretold for an hour would lead through a hundred metres of path."""
    given, bodies = tracked("4002", 225, 290, paused_at=282)
    assert is_folded(bodies[282 - 225])
    assert [one.state.frame for one in given] == list(range(len(bodies)))
    off = np.array([off_widths(one, body) for one, body in zip(given, bodies, strict=True)])
    assert not (off > 1.0).any(), "what is told is right, on either side"


def test_where_a_loop_may_be_passed_either_way_round_the_rest_of_the_body_is_told():
    given, bodies = tracked("4001", 0, 110, "coarse")
    doubted = [one for one in given if one.state.status is Status.LOOP_IN_DOUBT]
    assert doubted
    for one in doubted:
        body, state = bodies[one.state.frame], one.state
        ends = [(end.u_px, end.v_px) for end in (state.head, state.tail)]
        either_may_be_head = state.head_certainty < 0.9
        ways = ([0, -1], [-1, 0]) if either_may_be_head else ([0, -1],)
        away = [np.hypot(*(np.array(ends) - body.points_px[way]).T).max() for way in ways]
        assert min(away) < body.mean_width_px
        line = np.stack([one.midline.u_px, one.midline.v_px], axis=1)
        assert 0.1 < np.isfinite(line).all(axis=1).mean() < 1.0
        assert strays_px(line, body).max() < 0.5 * body.mean_width_px
        assert state.length_px == pytest.approx(body.length_px, rel=0.03)


def test_no_head_is_told_for_certain_of_a_worm_that_lies_exactly_double_all_the_time():
    """Of one shade it looks like a shorter worm that crawls: its head is not at an end.

    Drawn by other means than the rig's.
    """
    look, worm = LINE_LOOKS["lines_one_shade"], read_folded_worms(WORMS)["4006"]
    light, wall = light_and_wall(look)
    tracker, given = Tracker(TrackerParameters()), []
    for frame in range(400, 480):
        line, widths = true_line_px(worm, frame, look)
        picture = picture_of(line, widths, look, light, wall, seed=frame)
        given += tracker.push(picture, frame * 40_000_000)
    given += tracker.finish()
    posed = [one.state for one in given if one.state.status.has_pose]
    assert len(posed) > 40
    assert max(state.head_certainty for state in posed) < 0.9


def test_a_worm_that_strokes_at_a_dozen_frames_a_second_keeps_its_thin_ends():
    """They were taken for debris, as the whole body is longer than a frame of 15 a second allows.

    Drawn by other means than the rig's.
    """
    look, worm = LINE_LOOKS["lines"], read_folded_worms(WORMS)["4006"]
    light, wall = light_and_wall(look)
    tracker, given, lengths_px = Tracker(TrackerParameters()), [], []
    for frame in range(878, 912, 2):
        line, widths = true_line_px(worm, frame, look)
        lengths_px.append(np.hypot(*np.diff(line, axis=0).T).sum())
        picture = picture_of(line, widths, look, light, wall, seed=frame)
        given += tracker.push(picture, frame * 40_000_000)
    given += tracker.finish()
    told_px = np.array([one.state.length_px for one in given])
    assert np.isfinite(told_px).mean() > 0.8
    assert np.nanmax(np.abs(told_px / lengths_px - 1)) < 0.02
