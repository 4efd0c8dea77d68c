"""Where an end of one shade lies on its body: asked of the outline beside it alone."""

import numpy as np
import pytest
from drawn_folds import HEADINGS, LEVEL, Drawn, rounded_widths
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.end_by_flanks import EndByFlanksSettings, end_by_flanks
from worm_tracker.midline.likeliest_end import KnownEnd
from worm_tracker.midline.object_outline import Outline
from worm_tracker.midline.path import evenly, nodes_for
from worm_tracker.midline.rounded_widths import rounded_half_widths

WIDTH = 14.0
SETTINGS = EndByFlanksSettings()
MOST_SD_PX = 0.35 * WIDTH
"""What the tracker asks for to tell an end."""
RING = [(8.0, 0.0), (2 * np.pi * 3.0 + 3.0, 1 / 3.0)]
"""A body that goes round once, and three widths on along where it was."""


def crossing(beyond_widths):
    """Return a body whose last end crosses its own strand and goes on so far beyond its middle."""
    return [(16.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (2.5 + beyond_widths, 0.0)]


def from_last_end(drawn, cut_widths=0.0):
    s = np.linspace(drawn.length - cut_widths * WIDTH, 0.0, 800)
    return evenly(drawn.at(s), nodes_for(drawn.length, WIDTH))


def end_of(drawn, curve, signal=None, sd_widths=0.3, length_sd_widths=5.0):
    signal = drawn.signal if signal is None else signal
    outline = Outline.of(np.ascontiguousarray(signal), LEVEL / 2)
    widths = rounded_widths(np.linspace(0.0, drawn.length, 65), WIDTH)
    sd_px, length_sd_px = sd_widths * WIDTH, length_sd_widths * WIDTH
    known = KnownEnd(complex(curve[0]), sd_px, WIDTH, drawn.length, length_sd_px)
    return end_by_flanks(outline, curve, widths, known, SETTINGS)


@given(heading=HEADINGS, beyond=st.floats(1.6, 3.5))
def test_an_end_that_comes_out_beyond_its_own_strand_stays_there(heading, beyond):
    drawn = Drawn.of(crossing(beyond), WIDTH, heading, darker=False)
    end = end_of(drawn, from_last_end(drawn))
    assert end.curve is None
    # Of 1500 such ends two are refused: their outline has a corner that no place explains.
    assert end.sd_px < MOST_SD_PX or end.sd_px == np.inf


@pytest.mark.parametrize("beyond", [1.6, 2.0, 2.5, 3.0, 3.5])
def test_an_end_that_comes_out_beyond_its_own_strand_is_told(beyond):
    headings = np.linspace(0.0, 2 * np.pi, 20, endpoint=False)
    drawn = [Drawn.of(crossing(beyond), WIDTH, float(each), darker=False) for each in headings]
    told = [end_of(each, from_last_end(each)).sd_px < MOST_SD_PX for each in drawn]
    assert sum(told) >= 19


@given(heading=HEADINGS)
def test_an_end_that_lies_within_its_own_strand_may_as_well_lie_elsewhere(heading):
    drawn = Drawn.of(RING, WIDTH, heading, darker=False)
    assert end_of(drawn, from_last_end(drawn)).sd_px > MOST_SD_PX


@pytest.mark.parametrize("cut_widths", [0.8, 1.2, 1.5])
@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0, 4.1])
def test_an_end_that_was_followed_short_is_found_where_it_comes_out(cut_widths, heading):
    drawn = Drawn.of(crossing(2.5), WIDTH, heading, darker=False)
    curve = from_last_end(drawn, cut_widths)
    end = end_of(drawn, curve, sd_widths=1.0)
    true = drawn.at(np.array([drawn.length]))[0]
    assert abs(curve[0] - true) > 0.7 * WIDTH
    assert abs(end.curve[0] - true) < 0.35 * WIDTH
    assert abs(end.curve[-1] - curve[-1]) < 1e-6, "the rest of it lies as it did"
    assert end_of(drawn, end.curve).sd_px < MOST_SD_PX, "it is told there, then at the latest"


@pytest.mark.parametrize("turned", [-1.2, 1.2])
@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0, 4.1])
def test_an_end_that_was_led_astray_is_found_where_it_shows(turned, heading):
    """It comes out of its own strand; it was followed as if it had turned aside on it."""
    drawn = Drawn.of(crossing(2.0), WIDTH, heading, darker=False)
    true = from_last_end(drawn)
    astray = true.copy()
    for k in range(round(3.0 * WIDTH / abs(true[1] - true[0])), 0, -1):
        astray[k - 1] = astray[k] + (true[k - 1] - true[k]) * np.exp(1j * turned)
    end = end_of(drawn, astray, sd_widths=0.7)
    assert abs(astray[0] - true[0]) > 1.5 * WIDTH
    assert abs(end.curve[0] - true[0]) < 0.3 * WIDTH
    assert end.sd_px < MOST_SD_PX


@given(heading=HEADINGS, cut=st.floats(0.5, 2.0))
def test_a_mirrored_picture_has_the_end_mirrored(heading, cut):
    drawn = Drawn.of(crossing(2.0), WIDTH, heading, darker=False)
    curve = from_last_end(drawn, cut)
    across = drawn.signal.shape[1] - 1
    one = end_of(drawn, curve)
    other = end_of(drawn, across - curve.conj(), drawn.signal[:, ::-1])
    assert other.sd_px == pytest.approx(one.sd_px, abs=0.05 * WIDTH)
    tips = [curve[0] if one.curve is None else one.curve[0]]
    tips.append(across - curve[0].conj() if other.curve is None else other.curve[0])
    assert abs(tips[1] - (across - tips[0].conj())) < 0.1 * WIDTH


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0])
def test_the_length_tells_of_an_end_that_the_outline_does_not_show(heading):
    """A worm that keeps its length cannot end anywhere else along its strand."""
    drawn = Drawn.of(RING, WIDTH, heading, darker=False)
    curve = from_last_end(drawn)
    hardly, well = (end_of(drawn, curve, length_sd_widths=sd).sd_px for sd in (5.0, 0.2))
    assert well < MOST_SD_PX < hardly


def test_an_end_as_long_as_the_body_could_lie_nowhere_else():
    drawn = Drawn.of([(6.0, 0.0)], WIDTH)
    end = end_of(drawn, evenly(from_last_end(drawn), 5))
    assert end.curve is None
    assert end.sd_px == np.inf


@pytest.mark.parametrize("seed", range(3))
def test_where_a_body_is_patchy_its_outline_tells_no_end(seed):
    """Half of a real worm's brightness is no outline: no place fits, and any may fit best."""
    drawn = Drawn.of(crossing(2.0), WIDTH, darker=False)
    curve = from_last_end(drawn, 1.0)
    patches = np.random.default_rng(seed).uniform(
        0.2, 1.0, [n // 5 + 1 for n in drawn.signal.shape]
    )
    height, across = drawn.signal.shape
    patchy = drawn.signal * np.kron(patches, np.ones((5, 5)))[:height, :across]
    end = end_of(drawn, curve, patchy.astype(np.uint8))
    assert end.curve is None
    assert end.sd_px == np.inf
    assert end_of(drawn, from_last_end(drawn)).sd_px < MOST_SD_PX, "it is told in one of one shade"


def test_an_end_beyond_the_picture_is_not_told():
    drawn = Drawn.of([(20.0, 0.0)], WIDTH, darker=False)
    curve = from_last_end(drawn)
    beyond = end_of(drawn, curve, drawn.signal[:, : int(curve[0].real - 2 * WIDTH)])
    assert end_of(drawn, curve).sd_px < MOST_SD_PX < beyond.sd_px


@pytest.mark.parametrize(
    ("beside", "least_part", "most_part"),
    [pytest.param(0.9, 0.6, 1.0, id="blunt"), pytest.param(0.1, 0.4, 0.6, id="pointed")],
)
def test_an_end_is_as_round_as_it_is_blunt(beside, least_part, most_part):
    """Half-way to the first width that is known, a pointed end is half as wide as there."""
    widths = np.full(65, 20.0)
    widths[[0, -1]], widths[[1, -2]] = 0.0, beside * 20.0
    half = rounded_half_widths(np.array([0.0, 0.5 / 64, 1 / 64, 0.5, 1 - 0.5 / 64, 1.0]), widths)
    assert half[[0, -1]] == pytest.approx(0.0)
    assert half[2] == pytest.approx(beside * 10.0)
    assert half[3] == pytest.approx(10.0)
    assert least_part <= half[1] / half[2] <= most_part
    assert half[1] == pytest.approx(half[4])
