"""What is told of a midline of which a part is hidden or in doubt."""

import numpy as np
import pytest

from worm_msgs_py import Status
from worm_tracker.observation import Observation


@pytest.mark.parametrize(
    ("occluded", "in_doubt", "is_mostly_hidden"),
    [
        pytest.param((0, 0), (2, 60), False, id="both ends seen, whatever lies between"),
        pytest.param((10, 0), (0, 0), False, id="a hidden end"),
        pytest.param((10, 0), (30, 40), False, id="a loop in doubt as well"),
        pytest.param((10, 0), (15, 60), True, id="most in doubt"),
        pytest.param((10, 0), (5, 60), True, id="the same, overlapping"),
        pytest.param((25, 25), (0, 0), True, id="both ends hidden"),
        pytest.param((0, 0), (0, 65), True, id="both ends within what is in doubt"),
    ],
)
def test_a_body_of_which_less_than_a_quarter_is_told_is_mostly_hidden(
    occluded, in_doubt, is_mostly_hidden
):
    points = np.zeros((65, 2))
    seen = Observation(Status.END_HIDDEN, 0.0, 0.0, points, occluded=occluded, in_doubt=in_doubt)
    assert seen.is_mostly_hidden is is_mostly_hidden
    assert seen.reversed().is_mostly_hidden is is_mostly_hidden


@pytest.mark.parametrize(
    ("in_doubt", "contradicts"),
    [
        pytest.param((0, 0), True, id="nothing is in doubt"),
        pytest.param((25, 45), False, id="what lies elsewhere is in doubt"),
        pytest.param((30, 45), True, id="a part of it"),
        pytest.param((2, 63), True, id="hardly anything is told"),
    ],
)
@pytest.mark.parametrize("by_other", [False, True])
def test_two_bodies_contradict_each_other_by_what_both_tell(in_doubt, contradicts, by_other):
    line = np.stack([np.linspace(0.0, 200.0, 65), np.zeros(65)], axis=1)
    aside = line + np.outer((np.arange(65) >= 26) & (np.arange(65) < 44), [0.0, 60.0])
    doubts = ((0, 0), in_doubt) if by_other else (in_doubt, (0, 0))
    one, other = (
        Observation(Status.FOLDED, 0.0, 0.0, points, width=10.0, in_doubt=doubt)
        for points, doubt in zip((line, aside), doubts, strict=True)
    )
    assert one.contradicts(other) is contradicts
    assert one.reversed().contradicts(other) is contradicts
