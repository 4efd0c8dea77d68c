"""The taper of an end that lies in a loop tells which way round that is passed."""

import numpy as np
import pytest
from drawn_by_discs import drawn_by_discs, finely
from drawn_folds import laid
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.curve import as_points
from worm_tracker.midline.order_by_widths import area_of_body
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_exchange import loops_otherwise
from worm_tracker.midline.strand_meetings import StrandExchangeSettings
from worm_tracker.midline.way_by_widths import (
    WayByWidthsSettings,
    loops_by_widths,
    score_of_way,
)

WIDTH = 12.0
SETTINGS, EXCHANGE = WayByWidthsSettings(), StrandExchangeSettings()
LEAST_BREADTH_WIDTHS = 0.85
S = np.linspace(0.0, 1.0, 65)
EVEN = np.full(65, WIDTH)


def tapering(part, tip=0.3):
    """Return widths of a body whose last part thins to a tip."""
    return WIDTH * np.interp(S, [0.0, 1.0 - part, 1.0], [1.0, 1.0, tip])


def looped(tail_widths, radius_widths=3.0, lead_widths=6.0):
    """Return a body that crosses itself, so much of its tail beyond the crossing."""
    turn = 1 / radius_widths
    curve = laid(
        [(lead_widths, 0.0), (1.5 * np.pi * radius_widths, turn), (radius_widths + tail_widths, 0)],
        WIDTH,
    )
    return BodyPath(evenly(curve - complex(curve.real.min(), curve.imag.min()) + 40 + 40j, 240))


def seen(path, widths, across=1.0):
    """Return the picture of a body, so much broader than it is known to be."""
    points = as_points(path.curve)
    side = int(points.max()) + 40
    return drawn_by_discs((side, side), points, across * finely(widths, len(points)))


def otherwise(path):
    ((_, other),) = loops_otherwise(path, WIDTH, EXCHANGE, LEAST_BREADTH_WIDTHS)
    return other


def areas(mask, widths, *paths):
    return [area_of_body(mask.shape, path.points, widths) for path in paths]


BODIES = st.builds(looped, st.floats(1.5, 2.5), st.floats(2.5, 3.5))
TAPERS = st.builds(tapering, st.floats(0.35, 0.45), st.floats(0.2, 0.3))


@given(path=BODIES, widths=TAPERS, across=st.floats(0.92, 1.08))
def test_a_tail_that_tapers_into_its_loop_tells_which_way_that_is_passed(path, widths, across):
    mask, other = seen(path, widths, across), otherwise(path)
    score = score_of_way(mask, *areas(mask, widths, path, other), SETTINGS)
    assert score is not None
    assert score > SETTINGS.least_score
    contrary = score_of_way(mask, *areas(mask, widths, other, path), SETTINGS)
    assert contrary == pytest.approx(-score)


@given(path=BODIES, widths=TAPERS)
def test_a_loop_that_is_passed_right_is_not_taken_for_a_wrong_one(path, widths):
    mask = seen(path, widths)
    ((score, _),) = loops_by_widths(
        mask, path, widths, WIDTH, EXCHANGE, LEAST_BREADTH_WIDTHS, SETTINGS
    )
    assert score > SETTINGS.most_score_of_wrong


@given(path=BODIES)
def test_a_body_of_one_width_tells_nothing_of_its_loop(path):
    mask = seen(path, EVEN)
    assert score_of_way(mask, *areas(mask, EVEN, path, otherwise(path)), SETTINGS) is None


def test_a_taper_beyond_the_loop_tells_nothing_of_it():
    path, widths = looped(9.0), tapering(0.15)
    found = loops_by_widths(
        seen(path, widths), path, widths, WIDTH, EXCHANGE, LEAST_BREADTH_WIDTHS, SETTINGS
    )
    assert list(found) == []
