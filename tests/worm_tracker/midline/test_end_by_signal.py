"""Where overlaps are darker, the picture about an end tells where it lies along another strand."""

import numpy as np
import pytest
from flank_ends import DARKENING, LEVEL, along_itself, signal_of, with_last_end_moved
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_tracker.midline.drawn_signal import BodySignal
from worm_tracker.midline.end_by_signal import EndBySignalSettings, end_by_signal
from worm_tracker.midline.end_in_picture import with_end_aside
from worm_tracker.midline.likeliest_end import KnownEnd

SETTINGS = EndBySignalSettings()
MOST_SD_WIDTHS = 0.42
"""What the tracker asks for to tell an end where overlaps are darker."""
WIDTH = 14.0
ANGLES, ASIDE = st.floats(0.0, 2 * np.pi), st.floats(0.3, 0.9)


def from_last_end(line, longer_widths=0.0):
    return with_last_end_moved(line, WIDTH, longer_widths)[::-1]


def end_of(signal, curve, widths, length_sd_widths=5.0):
    nodes = np.linspace(0, 1, len(curve))
    from_end = widths[::-1]
    at_nodes = np.interp(nodes, np.linspace(0, 1, len(widths)), from_end)
    body = BodySignal(curve, at_nodes, WIDTH, LEVEL, np.full(len(curve), LEVEL), DARKENING)
    known = from_end[np.linspace(0, len(widths) - 1, 65).astype(int)]
    length = float(abs(np.diff(curve)).sum())
    end = KnownEnd(complex(curve[0]), WIDTH, WIDTH, length, length_sd_widths * WIDTH)
    return end_by_signal(signal, body, known, end, SETTINGS)


@given(start=ANGLES, aside=ASIDE)
@settings(max_examples=30)
def test_a_thin_end_along_its_own_strand_is_told_where_it_lies(start, aside):
    line, widths = along_itself(WIDTH, start, aside)
    curve = from_last_end(line)
    end = end_of(signal_of(line, widths), curve, widths)
    tip = curve[0] if end.curve is None else end.curve[0]
    assert abs(tip - curve[0]) < max(0.5, 2 * end.sd_px / WIDTH) * WIDTH
    assert end.sd_px < MOST_SD_WIDTHS * WIDTH


@pytest.mark.parametrize("longer_widths", [-2.0, -1.2, 1.2, 2.0])
@pytest.mark.parametrize("start", [0.0, 0.7, 2.0, 4.1])
def test_an_end_told_too_short_or_too_long_is_found_where_it_is_seen(longer_widths, start):
    line, widths = along_itself(WIDTH, start, 0.6)
    curve = from_last_end(line, longer_widths)
    end = end_of(signal_of(line, widths), curve, widths)
    assert abs(curve[0] - line[-1]) > 1.1 * WIDTH
    assert abs(end.curve[0] - line[-1]) < 0.5 * WIDTH
    assert end.sd_px < MOST_SD_WIDTHS * WIDTH


@pytest.mark.parametrize("aside_widths", [-0.4, 0.4])
@pytest.mark.parametrize("start", [0.0, 0.7, 2.0, 4.1])
def test_an_end_followed_aside_is_found_where_it_is_seen(aside_widths, start):
    line, widths = along_itself(WIDTH, start, 0.6)
    curve = with_end_aside(from_last_end(line), aside_widths * WIDTH, 2.0 * WIDTH)
    end = end_of(signal_of(line, widths), curve, widths)
    off = (end.curve[0] - line[-1]) / (line[-1] - line[-20])
    assert abs(off.imag * abs(line[-1] - line[-20])) < 0.2 * WIDTH


@given(start=ANGLES, longer=st.floats(-1.5, 1.5))
@settings(max_examples=20)
def test_a_mirrored_picture_has_the_end_mirrored(start, longer):
    line, widths = along_itself(WIDTH, start, 0.6)
    signal, curve = signal_of(line, widths), from_last_end(line, longer)
    across = signal.shape[1] - 1
    one = end_of(signal, curve, widths)
    other = end_of(np.ascontiguousarray(signal[:, ::-1]), across - curve.conj(), widths)
    tips = [curve[0] if one.curve is None else one.curve[0]]
    tips.append(across - curve[0].conj() if other.curve is None else other.curve[0])
    assert abs(tips[1] - (across - tips[0].conj())) < 0.3 * WIDTH


@pytest.mark.parametrize("seed", range(3))
def test_a_body_that_the_picture_does_not_show_as_drawn_tells_no_end(seed):
    """A real worm's brightness is patchy: what is darker beside an end need not be the body."""
    line, widths = along_itself(WIDTH, 1.0, 0.6)
    signal, curve = signal_of(line, widths), from_last_end(line, 1.2)
    patches = np.random.default_rng(seed).uniform(0.4, 1.6, [n // 7 + 1 for n in signal.shape])
    height, across = signal.shape
    patchy = signal * np.kron(patches, np.ones((7, 7)))[:height, :across]
    end = end_of(patchy.clip(0, 255).astype(np.uint8), curve, widths)
    assert end.curve is None
    assert end.sd_px == np.inf
    assert end_of(signal, curve, widths).curve is not None, "it is told in an even one"


def test_where_overlaps_are_no_darker_an_end_within_a_strand_may_lie_anywhere_along_it():
    line, widths = along_itself(WIDTH, 1.0, 0.0)
    curve = from_last_end(line)
    even = np.minimum(signal_of(line, widths), LEVEL).astype(np.uint8)
    body = BodySignal(curve, widths[::-1], WIDTH, LEVEL, np.full(len(curve), LEVEL), 0.0)
    known = widths[::-1][np.linspace(0, len(widths) - 1, 65).astype(int)]
    end = KnownEnd(complex(curve[0]), WIDTH, WIDTH, 1.0, 1e6)
    assert end_by_signal(even, body, known, end, SETTINGS).sd_px > MOST_SD_WIDTHS * WIDTH


def test_an_end_beyond_the_picture_is_not_told():
    line, widths = along_itself(WIDTH, 0.0, 0.6)
    end = end_of(signal_of(line, widths), from_last_end(line) + 5000, widths)
    assert end.curve is None
    assert end.sd_px == np.inf


@given(by=st.floats(-0.3, 0.3), start=ANGLES)
def test_an_end_moved_aside_takes_along_what_is_behind_it_and_no_more(by, start):
    line = from_last_end(along_itself(WIDTH, start, 0.6)[0])
    moved = with_end_aside(line, by * WIDTH, 2.5 * WIDTH)
    away, s = abs(moved - line), np.r_[0.0, np.cumsum(abs(np.diff(line)))]
    assert away[0] == pytest.approx(abs(by) * WIDTH)
    assert (np.diff(away[s < 2.5 * WIDTH]) <= 1e-9).all()
    assert away[s > 2.5 * WIDTH].max() == 0
