"""A body that explained its picture is held while those followed from it explain none."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import kinked_loop

from worm_tracker.propagation.held_body import found_from_held
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import HeldBody, PropagatedBody

SETTINGS = PropagationSettings()
EXPLAINED = PropagatedBody(kinked_loop(2.5, 15.0), 0.95, 0.95, over_limits=0.2, was_slid=True)


def unexplained(frames, held, **changes):
    """Return a body that has not explained its picture for so many frames."""
    return replace(EXPLAINED, over_limits=2.0, frames_unexplained=frames, held=held, **changes)


def asked(found):
    """Return a way to find bodies that gives these, and what it was asked for."""
    calls = []

    def find(body, frames):
        calls.append((body, frames))
        return found[len(calls) - 1]

    return find, calls


def test_from_a_body_that_explains_its_picture_the_next_is_found_and_nothing_is_held():
    find, calls = asked([EXPLAINED])
    assert found_from_held(find, EXPLAINED, 1, SETTINGS) is EXPLAINED
    assert calls == [(EXPLAINED, 1)]


def test_the_last_body_that_explained_its_picture_is_held_while_none_does():
    last, held = EXPLAINED, []
    for frames in range(1, SETTINGS.most_frames_unexplained + 2):
        find, _ = asked([unexplained(frames, None), None])
        last = found_from_held(find, last, 1, SETTINGS)
        held.append(last.held is not None and last.held.body)
    assert held == [EXPLAINED] * SETTINGS.most_frames_unexplained + [False]


@pytest.mark.parametrize(
    ("followed", "from_held", "is_held"),
    [(2.0, 0.4, True), (0.9, 0.4, False), (2.0, 1.1, False), (None, 0.4, True)],
)
def test_a_body_is_found_from_the_one_held_where_only_that_explains_the_picture(
    followed, from_held, is_held
):
    last = unexplained(2, HeldBody(EXPLAINED))
    one = None if followed is None else replace(EXPLAINED, over_limits=followed)
    other = replace(EXPLAINED, over_limits=from_held)
    find, calls = asked([one, other])
    found = found_from_held(find, last, 1, SETTINGS)
    assert calls[0] == (last, 1)
    assert calls[1:] in ([], [(EXPLAINED, 3)])
    assert found.over_limits == (from_held if is_held else followed)


@pytest.mark.parametrize("was_slid", [True, False])
def test_ends_are_those_of_the_last_picture_only_if_all_since_the_one_held_were_slid(was_slid):
    last = found_from_held(
        asked([unexplained(1, None, was_slid=was_slid)])[0], EXPLAINED, 1, SETTINGS
    )
    last = found_from_held(asked([unexplained(2, None), None])[0], last, 1, SETTINGS)
    found = found_from_held(asked([replace(last, held=None), EXPLAINED])[0], last, 1, SETTINGS)
    assert found.over_limits == EXPLAINED.over_limits
    assert found.was_slid is was_slid


def test_a_body_that_is_held_moves_with_the_rig():
    way = np.array([5.0, -3.0])
    moved = unexplained(1, HeldBody(EXPLAINED)).transformed(np.c_[np.eye(2), way])
    assert moved.held.body.points == pytest.approx(EXPLAINED.points + way)
    assert moved.points == pytest.approx(EXPLAINED.points + way)
