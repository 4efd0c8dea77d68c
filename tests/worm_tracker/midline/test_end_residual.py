"""An end that lies along its own flank is told from one that is said to end elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from flank_ends import DARKENING, LEVEL, along_itself, signal_of, with_last_end_moved
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_tracker.midline.drawn_signal import BodySignal
from worm_tracker.midline.end_residual import (
    EndResidualSettings,
    differing_near,
    end_over_limits,
)

SETTINGS = EndResidualSettings()
ANGLES, WIDTHS_PX = st.floats(0.0, 2 * np.pi), st.floats(10.0, 18.0)


def told(line, widths, longer_widths=0.0):
    """Return the body as it is known from its ends, the last end so much too far on."""
    width = float(widths.max())
    line = with_last_end_moved(line, width, longer_widths)
    known = np.interp(np.linspace(0, 1, len(line)), np.linspace(0, 1, len(widths)), widths)
    return BodySignal(line, known, width, LEVEL, np.full(len(line), LEVEL), DARKENING)


def over(signal, body):
    return end_over_limits(signal, body, complex(body.curve[-1]), SETTINGS)


@given(width=WIDTHS_PX, start=ANGLES, aside=st.floats(0.0, 0.9), side=st.sampled_from([-1, 1]))
@settings(max_examples=40)
def test_an_end_that_lies_along_its_own_strand_is_explained_where_it_is(width, start, aside, side):
    line, widths = along_itself(width, start, aside, side)
    assert over(signal_of(line, widths), told(line, widths)) < 1


@pytest.mark.parametrize("longer_widths", [-2.0, 2.0])
@given(width=WIDTHS_PX, start=ANGLES, aside=st.floats(0.5, 0.9))
@settings(max_examples=40)
def test_nowhere_else_is_it_explained(longer_widths, width, start, aside):
    line, widths = along_itself(width, start, aside)
    assert over(signal_of(line, widths), told(line, widths, longer_widths)) > 1


@pytest.mark.parametrize("blur_px", [0.8, 1.2])
@pytest.mark.parametrize("start", [0.0, 1.0, 2.5])
def test_a_little_out_of_focus_that_is_told_as_well(blur_px, start):
    line, widths = along_itself(14.0, start, 0.6)
    signal = signal_of(line, widths, blur_px)
    assert over(signal, told(line, widths)) < 1
    assert over(signal, told(line, widths, -2.0)) > 1


def test_an_end_beyond_the_picture_is_not_asked():
    line, widths = along_itself(12.0, 0.0, 0.6)
    body = told(line, widths)
    away = replace(body, curve=body.curve + 5000)
    assert over(signal_of(line, widths), away) == 0


@pytest.mark.parametrize("longer_widths", [-1.0, 1.0])
@given(width=WIDTHS_PX, start=ANGLES, aside=st.floats(0.5, 0.9))
@settings(max_examples=30)
def test_a_picture_differs_more_from_a_body_that_ends_elsewhere(longer_widths, width, start, aside):
    line, widths = along_itself(width, start, aside)
    signal, here, there = (
        signal_of(line, widths),
        *(told(line, widths, x) for x in (0, longer_widths)),
    )
    ends = np.array([here.curve[-1], there.curve[-1]])
    least = differing_near(signal, here, ends, SETTINGS)
    assert least < 0.05
    assert differing_near(signal, there, ends, SETTINGS) > least + 0.02


def test_beyond_the_picture_nothing_differs():
    line, widths = along_itself(12.0, 0.0, 0.6)
    body = told(line, widths)
    away = replace(body, curve=body.curve + 5000)
    assert differing_near(signal_of(line, widths), away, away.curve[-1:], SETTINGS) == 0
