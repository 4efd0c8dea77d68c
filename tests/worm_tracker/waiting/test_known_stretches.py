"""A body that was lost is known where it lies as the other way through the fold has it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import AgreementSettings
from worm_tracker.waiting.known_stretches import known_stretches

WIDTH, COUNT = 10.0, 41
LINE = np.stack([np.linspace(0.0, 200.0, COUNT), np.zeros(COUNT)], axis=1)
SETTINGS = AgreementSettings()


def body(aside_widths=0.0, **more):
    points = LINE + np.array([0.0, aside_widths * WIDTH])
    told = Observation(Status.FOLDED, points=points, widths=np.full(COUNT, WIDTH), width=WIDTH)
    return replace(told, **more)


def lost(*place, **more):
    """Return what a way says of a body that explains its picture again, but was lost."""
    return Observation(Status.COILED, followed=body(*place, **more))


def known_of(there, back):
    """Return the frames in which either way is known, of frames 0, 1, 2 and so on."""
    said = [{k: one for k, one in enumerate(way) if one is not None} for way in (there, back)]
    return [sorted(way) for way in known_stretches(range(len(there)), *said, SETTINGS)]


def test_a_lost_body_that_comes_to_lie_where_the_other_way_tells_it_is_known_all_along():
    there, back = known_of([lost(5.0), lost(3.0), lost(0.1)], [None, None, body()])
    assert there == [0, 1, 2]
    assert back == [2]


@pytest.mark.parametrize(
    ("followed", "told"),
    [
        pytest.param(lost(0.4), body(), id="another body"),
        pytest.param(lost(), body(in_doubt=(10, 30)), id="both ways may pass a loop wrong"),
        pytest.param(lost(over_limits=1.5), body(), id="something is left over"),
        pytest.param(lost(occluded=(22, 0)), body(), id="too little of it is seen"),
        pytest.param(lost(occluded=(11, 0)), body(occluded=(0, 11)), id="by both together, too"),
    ],
)
def test_a_lost_body_is_not_known_by_one_that_does_not_tell_it(followed, told):
    assert known_of([followed], [told]) == [[], [0]]


@pytest.mark.parametrize("turned", [False, True])
def test_what_is_hidden_of_either_need_not_agree(turned):
    bent = body().points.copy()
    bent[:8, 1] += 3 * WIDTH
    hidden = body(points=bent, occluded=(8, 0))
    hidden = hidden.reversed() if turned else hidden
    assert known_of([Observation(Status.COILED, followed=hidden)], [body()]) == [[0], [0]]


@pytest.mark.parametrize(("unexplained", "are_known"), [(5, [0, 6]), (6, [7])])
def test_a_stretch_ends_where_the_body_was_lost_once_more(unexplained, are_known):
    gap = [lost(over_limits=2.0)] * unexplained
    back = [None] * (unexplained + 1) + [body()]
    assert known_of([lost(4.0), *gap, lost()], back)[0] == are_known


def test_what_is_known_so_makes_known_what_lies_there():
    """The way there is known by the second frame, the way back by the first one then."""
    there = [lost(2.0), *[None] * 6, lost(2.0), lost(), None]
    back = [lost(2.1), *[None] * 7, body(), body()]
    assert known_of(there, back) == [[7, 8], [8, 9]]
    there[4] = lost(2.0)
    assert known_of(there, back) == [[0, 4, 7, 8], [0, 8, 9]]


SAID = st.one_of(
    st.none(),
    st.builds(body, st.sampled_from([0.0, 0.2, 1.0])),
    st.builds(lost, st.sampled_from([0.0, 0.2, 1.0]), over_limits=st.sampled_from([0.0, 2.0])),
)


@given(pairs=st.lists(st.tuples(SAID, SAID), max_size=25))
def test_what_is_told_is_known_and_what_is_known_was_followed_either_way_alike(pairs):
    there, back = [one for one, _ in pairs], [other for _, other in pairs]
    known = known_of(there, back)
    assert known == known_of(back, there)[::-1]
    for frames, said in zip(known, (there, back), strict=True):
        followed = {k for k, one in enumerate(said) if one is not None}
        told = {k for k in followed if said[k].has_midline}
        assert told <= set(frames) <= followed
