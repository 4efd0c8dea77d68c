"""Which way round a loop is passed: by its bends, by what was known, or by what is left over."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import candidate, kinked_loop, search_after
from drawn_folds import laid

from worm_msgs_py import Status
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import exchanged_strands, part_of
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.laid_anew import with_strands_exchanged
from worm_tracker.propagation.propagation import observation_of
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


@pytest.mark.parametrize(
    ("radius_widths", "frames", "was_known", "is_known"),
    [
        pytest.param(2.5, 1, True, True, id="open since it was known"),
        pytest.param(2.5, 1, False, False, id="never known"),
        pytest.param(2.5, 3, True, True, id="two frames are missing"),
        pytest.param(2.5, 6, True, False, id="not followed meanwhile"),
        pytest.param(0.8, 1, True, False, id="its strands may have crossed unseen"),
        pytest.param(0.55, 1, False, False, id="a width broad where flanks are soft"),
        pytest.param(0.3, 1, False, True, id="narrower than a width"),
    ],
)
def test_a_loop_that_the_other_way_round_is_straighter_is_told_where_it_was_known_and_followed(
    radius_widths, frames, was_known, is_known
):
    width = 15.0
    path = kinked_loop(radius_widths, width)
    search = search_after(path, width, frames, was_known)
    assert (search.loops_in_doubt(candidate(path)) == []) is is_known
    assert search.in_picture(candidate(path)).loops_known is is_known


@pytest.mark.parametrize("was_known", [True, False])
def test_a_loop_that_is_straighter_as_it_is_is_known_by_itself(was_known):
    width = 15.0
    arcs = laid([(6.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (6.0, 0.0)], width)
    crossing = BodyPath(evenly(arcs, 240))
    assert search_after(crossing, width, 1, was_known).loops_in_doubt(candidate(crossing)) == []


def test_a_loop_whose_strands_were_exchanged_is_not_passed_as_it_was_known():
    path = kinked_loop(2.5, 15.0)
    search = search_after(path, 15.0, 1, loops_known=True)
    assert search.loops_in_doubt(candidate(path)) == []
    assert search.loops_in_doubt(replace(candidate(path), was_exchanged=True)) != []


@pytest.mark.parametrize(
    "turn_over_pi",
    [
        pytest.param(1.3, id="the other way bends by 0.4 rad2 more"),
        pytest.param(1.4, id="by 0.9"),
        pytest.param(1.5, id="by 1.5"),
    ],
)
def test_a_loop_that_was_turned_round_is_in_doubt_however_much_the_other_way_bends(turn_over_pi):
    width = 15.0
    arcs = laid([(6.0, 0.0), (turn_over_pi * np.pi * 2.5, 1 / 2.5), (6.0, 0.0)], width)
    path = BodyPath(evenly(arcs, 240))
    search = search_after(path, width, 1, loops_known=False)
    assert search.loops_in_doubt(candidate(path)) == []
    for turned in (
        (search, replace(candidate(path), was_exchanged=True)),
        (replace(search, body=replace(search.body, was_turned=True)), candidate(path)),
    ):
        assert turned[0].loops_in_doubt(turned[1]) != []


def test_a_body_that_was_turned_round_and_passes_no_loop_is_not_in_doubt():
    path = BodyPath(evenly(laid([(9.0, 0.0), (np.pi * 3.0, 1 / 3.0), (9.0, 0.0)], 15.0), 240))
    search = search_after(path, 15.0, 1, loops_known=False)
    assert search.loops_in_doubt(replace(candidate(path), was_exchanged=True)) == []


@pytest.mark.parametrize(("left_over_widths2", "stays"), [(0.0, False), (9.0, True)])
def test_a_body_that_was_turned_round_stays_so_while_it_leaves_something_over(
    left_over_widths2, stays
):
    """It may lie so meanwhile that its loop is not to be seen."""
    open_path = BodyPath(evenly(laid([(9.0, 0.0), (np.pi * 3.0, 1 / 3.0), (9.0, 0.0)], 15.0), 240))
    search = search_after(open_path, 15.0, 1, loops_known=True)
    turned = replace(candidate(open_path, left_over_widths2), was_exchanged=True)
    assert search.stays_turned(turned, is_in_doubt=False) is stays
    path = kinked_loop(2.5, 15.0)
    search = search_after(path, 15.0, 1, loops_known=True)
    search = replace(search, body=replace(search.body, was_turned=stays))
    assert (search.loops_in_doubt(candidate(path)) != []) is stays


@pytest.mark.parametrize(("sd_widths", "is_known"), [(0.2, True), (0.6, True), (4.0, False)])
def test_a_loop_is_not_passed_as_it_was_known_where_the_ends_may_have_changed_places(
    sd_widths, is_known
):
    """Its ends lie as far apart as its legs do, unseen where they are that unsure."""
    path = kinked_loop(2.5, 15.0)
    search = search_after(path, 15.0, 1, loops_known=True, end_sd_px=(sd_widths * 15.0, 0.0))
    assert (search.loops_in_doubt(candidate(path)) == []) is is_known


def closed_by_its_end(width, clear_widths=0.0):
    """Return a body whose last end lies on its own strand, or so far beside it."""
    r = 3.0 * width
    strand = np.linspace(-10 * width, 8 * width, 200)
    bend = 8 * width + 1j * r + r * np.exp(1j * np.linspace(-0.5 * np.pi, np.pi, 120))
    end = bend[-1] - 1j * np.linspace(0.0, r - clear_widths * width, 40)
    return BodyPath(evenly(np.r_[strand, bend[1:], end[1:]], 240))


@pytest.mark.parametrize(
    ("in_doubt", "clear_widths", "stays"),
    [
        pytest.param((0.4, 1.0), 0.0, True, id="its strands met where its end lies now"),
        pytest.param((0.4, 1.0), 1.8, False, id="its end lies apart"),
        pytest.param((0.2, 0.6), 0.0, False, id="its strands met elsewhere"),
        pytest.param(None, 0.0, False, id="it was known"),
    ],
)
def test_a_loop_in_doubt_stays_so_where_an_end_has_slid_to_where_its_strands_met(
    in_doubt, clear_widths, stays
):
    path = closed_by_its_end(15.0, clear_widths)
    search = search_after(path, 15.0, 1, loops_known=True)
    search = replace(search, body=replace(search.body, doubt_by_bends=in_doubt))
    assert part_of(search.loops_in_doubt(candidate(path))) == (in_doubt if stays else None)


@pytest.mark.parametrize(
    ("end_moves_widths", "loops_known", "is_exchanged"),
    [
        pytest.param(0.5, False, True, id="the ends stay"),
        pytest.param(1.5, False, False, id="an end moves"),
        pytest.param(0.5, True, False, id="it is known how an open loop is passed"),
    ],
)
def test_strands_are_exchanged_where_the_ends_stay_and_no_known_loop_is_turned(
    monkeypatch, end_moves_widths, loops_known, is_exchanged
):
    width = 15.0
    found = candidate(kinked_loop(2.5, width))
    search = search_after(found.path, width, 1, loops_known=loops_known)
    darker = replace(search.seen, dark=search.seen.mask)  # overlaps tell
    search = replace(search, seen=darker, body=replace(search.body, straighter=10.0))
    crossing, _ = exchanged_strands(found.path, width, search.settings.exchange)
    ends_away = crossing.curve.copy()
    ends_away[0] += end_moves_widths * width * 1j
    slid = candidate(BodyPath(ends_away))
    monkeypatch.setattr(CandidateSearch, "slid", lambda *_: slid)
    told = with_strands_exchanged(search, found)
    assert told.was_exchanged is is_exchanged
    assert np.array_equal(told.path.curve, slid.path.curve if is_exchanged else found.path.curve)


@pytest.mark.parametrize(
    ("end_sd_widths", "status"),
    [
        pytest.param(0.1, Status.LOOP_IN_DOUBT, id="both ends are seen"),
        pytest.param(0.6, Status.END_HIDDEN, id="an end is not seen either"),
    ],
)
def test_what_lies_outside_a_loop_in_doubt_is_told(end_sd_widths, status):
    width = 15.0
    path = kinked_loop(2.5, width)
    search = search_after(path, width, 1, loops_known=False)
    ends = (0.1 * width, end_sd_widths * width)
    part = part_of(search.loops_in_doubt(candidate(path)))
    body = PropagatedBody(path, 0.95, 0.95, 0j, ends, loop_in_doubt=part)
    told = observation_of(body, search.model, 0.95, PropagationSettings())
    assert told.status is status
    first, behind = told.in_doubt
    meeting = np.abs(told.points[:, 0] + 1j * told.points[:, 1])  # the strands meet in (0, 0)
    assert (meeting[[first, behind - 1]] < 1.5 * width).all()
    n = len(told.points)
    assert 0 < first < n / 3
    assert 2 * n / 3 < behind < n
    back = told.reversed()
    assert back.in_doubt == (n - behind, n - first)
    assert back.reversed().in_doubt == told.in_doubt


@pytest.mark.parametrize(
    ("in_doubt", "is_known"),
    [
        pytest.param(None, True, id="no loop in doubt"),
        pytest.param((0.3, 0.8), True, id="a loop between ends that are told"),
        pytest.param((0.02, 0.7), False, id="a loop near an end"),
        pytest.param((0.0, 0.7), True, id="a loop that an end closes"),
        pytest.param((0.3, 1.0), True, id="a loop that the last end closes"),
        pytest.param((0.0, 1.0), False, id="loops that both ends close"),
        pytest.param((0.01, 0.99), False, id="nearly all of the body"),
    ],
)
def test_widths_tell_the_order_of_ends_that_lie_in_no_loop_in_doubt(in_doubt, is_known):
    width = 15.0
    path = kinked_loop(2.5, width)
    search = search_after(path, width, 1, loops_known=False)
    body = PropagatedBody(
        path, 0.95, 0.95, 0j, (1.0, 1.0), loop_in_doubt=in_doubt, order_known=True
    )
    assert observation_of(body, search.model, 0.95, PropagationSettings()).order_known is is_known
