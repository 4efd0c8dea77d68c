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
    ],
)
def test_a_body_of_which_less_than_a_quarter_is_told_is_mostly_hidden(
    occluded, in_doubt, is_mostly_hidden
):
    points = np.zeros((65, 2))
    seen = Observation(Status.END_HIDDEN, 0.0, 0.0, points, occluded=occluded, in_doubt=in_doubt)
    assert seen.is_mostly_hidden is is_mostly_hidden
    assert seen.reversed().is_mostly_hidden is is_mostly_hidden
