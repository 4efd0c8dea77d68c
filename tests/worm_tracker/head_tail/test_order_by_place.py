"""Ends that are seen where they were are the same ends, whichever way round a midline comes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Status
from worm_tracker.head_tail.order_by_place import EndsInPlaceSettings, ends_in_place
from worm_tracker.observation import Observation

WIDTH = 10.0
SETTINGS = EndsInPlaceSettings()


def seen(points):
    return Observation(
        Status.FOLDED, points=points, widths=np.full(len(points), WIDTH), width=WIDTH
    )


def arch(apart_px):
    """Return a body whose ends are so far apart."""
    angle = np.linspace(np.pi, 0.0, 65)
    return np.stack([apart_px / 2 * np.cos(angle), 80.0 * np.sin(angle)], axis=1)


steps = st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))


@given(apart_px=st.floats(40.0, 200.0), first=steps, last=steps, is_reversed=st.booleans())
def test_ends_far_from_each_other_tell_which_way_round_a_midline_comes(
    apart_px, first, last, is_reversed
):
    now = arch(apart_px)
    now[0] += first
    now[-1] += last
    observation = seen(now[::-1] if is_reversed else now)
    assert ends_in_place(observation, arch(apart_px), SETTINGS) is not is_reversed


@given(apart_px=st.floats(0.0, 9.0), first=steps, last=steps)
def test_ends_within_a_width_of_each_other_tell_nothing(apart_px, first, last):
    now = arch(apart_px)
    now[0] += np.sign(apart_px) * np.abs(first) * [1, 0]
    now[-1] -= np.sign(apart_px) * np.abs(last) * [1, 0]
    assert ends_in_place(seen(now), arch(apart_px), SETTINGS) is None


@pytest.mark.parametrize("occluded", [(3, 0), (0, 3)])
def test_a_hidden_end_tells_nothing(occluded):
    observation = replace(seen(arch(100.0)), occluded=occluded)
    assert ends_in_place(observation, arch(100.0), SETTINGS) is None


def test_an_end_that_went_far_tells_nothing():
    now = arch(100.0)
    now[0] += [9.0, 0.0]
    assert ends_in_place(seen(now), arch(100.0), SETTINGS) is None
