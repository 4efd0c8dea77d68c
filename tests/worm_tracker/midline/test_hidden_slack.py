"""Of one shade, what a body hides under itself is told to be slack, and what is seen is not."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import search_after
from drawn_folds import NODES_PER_WIDTH, Drawn

from worm_tracker.midline.body_residual import ObjectMasks
from worm_tracker.midline.hidden_slack import HiddenSlackSettings, without_slack
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.midline.strand_meetings import StrandExchangeSettings

WIDTH = 12.0
STRAIGHT = [(24.0, 0.02)]
LOOP = [(7.0, 0.0), (11.0, 0.55), (7.0, 0.0)]
HAIRPIN = [(12.0, 0.0), (1.25, np.pi / 1.25), (9.0, 0.0)]
MEET = StrandExchangeSettings(most_apart_widths=1.0)


def once(curve):
    """Return a curve without the points that follow on themselves."""
    return curve[np.r_[True, np.abs(np.diff(curve)) > 1e-6]]


def there_and_back(drawn, from_widths, slack_widths):
    """Return a body that goes back over itself by so much, and on again."""
    n, first = round(slack_widths * NODES_PER_WIDTH), round(from_widths * NODES_PER_WIDTH)
    curve = drawn.curve
    back = curve[first - n : first][::-1]
    return once(np.concatenate([curve[:first], back, curve[first - n : first], curve[first:]]))


def spiked(drawn, at_widths, along_widths, slack_widths):
    """Return a body that runs from a place along another strand of its own, and back again."""
    n, at, along = (
        round(widths * NODES_PER_WIDTH) for widths in (slack_widths, at_widths, along_widths)
    )
    curve = drawn.curve
    spike = curve[along - n : along][::-1]
    return once(np.concatenate([curve[:at], spike, spike[::-1], curve[at:]]))


def hides_slack(drawn, curve, darker=False):
    path = BodyPath(evenly(curve, 400))
    search = search_after(path, WIDTH, 1, loops_known=True)
    dark = np.zeros_like(drawn.mask) if darker else None
    seen = ObjectMasks(drawn.mask, dark, WIDTH, search.settings.residual)
    search = replace(search, seen=seen)
    return search.hides_slack(search.scored(path, search.model.widths))


@pytest.mark.parametrize("arcs", [STRAIGHT, LOOP, HAIRPIN], ids=["open", "a loop", "a hairpin"])
def test_a_true_body_hides_none(arcs):
    drawn = Drawn.of(arcs, WIDTH, darker=False)
    assert not hides_slack(drawn, drawn.curve)


@pytest.mark.parametrize("slack_widths", [1.6, 2.5])
def test_a_body_laid_three_times_over_one_stretch_does(slack_widths):
    drawn = Drawn.of(STRAIGHT, WIDTH, darker=False)
    longer = there_and_back(drawn, 13.0, slack_widths)
    assert hides_slack(drawn, longer)
    assert not hides_slack(drawn, longer, darker=True), "there the overlap is seen to be none"


@pytest.mark.parametrize("slack_widths", [1.8, 2.6])
def test_a_spike_along_another_strand_does(slack_widths):
    drawn = Drawn.of(LOOP, WIDTH, darker=False)
    apart = np.abs(drawn.curve[:, None] - drawn.curve)
    far = np.abs(np.subtract.outer(*[np.arange(len(apart))] * 2)) > 5 * NODES_PER_WIDTH
    first, last = np.unravel_index(np.where(far, apart, np.inf).argmin(), apart.shape)
    first, last = sorted((int(first), int(last)))
    curve = spiked(drawn, last / NODES_PER_WIDTH, first / NODES_PER_WIDTH, slack_widths)
    assert hides_slack(drawn, curve)


def test_what_is_left_without_it_goes_straight_on():
    drawn = Drawn.of([(24.0, 0.0)], WIDTH)
    path = BodyPath(evenly(there_and_back(drawn, 13.0, 2.0), 400))
    ways = list(without_slack(path, WIDTH, MEET, HiddenSlackSettings()))
    assert ways
    true = float(np.abs(np.diff(drawn.curve)).sum())
    assert min(abs(way.length - true) for way in ways) < 0.5 * WIDTH
    assert path.length > true + 3.5 * WIDTH
