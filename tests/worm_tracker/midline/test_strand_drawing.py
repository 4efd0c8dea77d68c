"""A body is drawn as wide as it is, inside the picture alone, however long it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from worm_tracker.midline.curve import as_points
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_body, drawn_strands

SETTINGS = StrandDrawingSettings()
SHAPE = (120, 160)


def drawn(line, width, shape=SHAPE):
    points = as_points(np.asarray(line, np.complex128))
    return drawn_strands(shape, points, np.full(len(points), float(width)), width, SETTINGS)


@given(
    heading=st.floats(0.0, 6.2),
    width=st.floats(3.0, 20.0),
    u=st.floats(-40.0, 200.0),
    v=st.floats(-40.0, 160.0),
)
@settings(max_examples=60)
def test_a_straight_body_is_as_wide_as_it_is_wherever_it_lies(heading, width, u, v):
    way = np.exp(1j * heading)
    body, twice, layered, thrice = drawn(u + 1j * v + way * np.linspace(0.0, 80.0, 60), width)
    at = np.add.outer(1j * np.arange(SHAPE[0]), np.arange(SHAPE[1])) - (u + 1j * v)
    along, aside = (at * way.conjugate()).real, np.abs((at * way.conjugate()).imag)
    inside = (along > 0) & (along < 80) & (aside < width / 2)
    outside = (along < -1) | (along > 81) | (aside > width / 2 + 1)
    assert body[inside].all()
    assert not body[outside].any()
    assert not twice.any()
    assert not layered.any()
    assert not thrice.any()


def test_a_body_that_crosses_itself_has_two_strands_there_alone():
    turn = np.linspace(-0.25 * np.pi, 1.25 * np.pi, 120)
    bow = 80 + 60j + 30 * np.exp(1j * turn)
    legs = np.linspace(0.0, 70.0, 60)[1:]
    line = np.concatenate(
        [
            bow[0] + legs[::-1] * -1j * np.exp(1j * turn[0]),
            bow,
            bow[-1] + legs * 1j * np.exp(1j * turn[-1]),
        ]
    )
    body, twice, *_ = drawn(line, 8.0, (160, 200))
    v, u = np.nonzero(twice)
    crossing = 80 + 1j * (60 - 30 * np.sqrt(2))
    assert twice.any()
    assert np.abs(u + 1j * v - crossing).max() < 9.0
    away = distance_transform_edt(body > 0)
    assert away.max() == pytest.approx(5.6, abs=1.0)  # half the diagonal of where they cross


@pytest.mark.parametrize("wrong", [complex("nan"), 1e300 + 1e300j])
def test_numbers_that_are_none_draw_nothing_outside_the_picture(wrong):
    line = 20 + 60j + np.linspace(0.0, 80.0, 60) * (1 + 0j)
    line[30] = wrong
    with np.errstate(all="ignore"):
        body, *_ = drawn(line, 8.0)
    assert not body[:50].any()
    assert not body[70:].any()


def test_a_body_of_a_thousand_widths_is_drawn_whole():
    """Its pieces are told apart by a byte."""
    rows = [10.0 + 4 * k for k in range(50)]
    legs = [
        np.linspace(5.0, 395.0, 400)[:: 1 if k % 2 else -1] + 1j * v for k, v in enumerate(rows)
    ]
    body, *_ = drawn(np.concatenate(legs), 2.0, (220, 400))
    assert body[np.rint(rows).astype(int)][:, 8:392].all()


@given(seed=st.integers(0, 2**32 - 1), width=st.floats(3.0, 20.0))
@settings(max_examples=60)
def test_a_body_covers_the_same_in_one_piece_as_in_strands(seed, width):
    rng = np.random.default_rng(seed)
    line = 80 + 60j + np.cumsum(1.5 * np.exp(1j * np.cumsum(rng.normal(0.0, 0.2, 120))))
    widths = width * rng.uniform(0.2, 1.0, len(line))
    strands, *_ = drawn_strands(SHAPE, as_points(line), widths, width, SETTINGS)
    np.testing.assert_array_equal(drawn_body(SHAPE, line, widths, SETTINGS), strands)
