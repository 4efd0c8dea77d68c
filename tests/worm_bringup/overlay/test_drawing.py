"""What is drawn is to be seen where it is, to a fraction of a pixel, in its own colour."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_bringup.overlay.drawing import draw_over
from worm_bringup.overlay.shapes import DOUBTFUL_OPACITY, Circle, Ink, Polyline, Shapes

GREY = np.full((120, 160), 100, np.uint8)
places = st.tuples(st.floats(30.0, 130.0), st.floats(30.0, 90.0))


def inked(picture, background=100):
    """Return where the picture is not the background any more, weighed by how much."""
    off = np.abs(picture.astype(float) - background).sum(axis=2)
    v, u = np.indices(off.shape)
    return u, v, off


@given(place=places, radius=st.floats(4.0, 20.0))
def test_a_dot_is_drawn_about_its_centre(place, radius):
    dot = Circle(*place, radius, Ink("#FFFFFF"), filled=True)
    u, v, off = inked(draw_over(GREY, Shapes((dot,))))
    assert ((u * off).sum() / off.sum(), (v * off).sum() / off.sum()) == pytest.approx(
        place, abs=0.2
    )


@given(place=places, radius=st.floats(8.0, 28.0))
def test_a_wall_is_drawn_on_its_circle(place, radius):
    u, v, off = inked(draw_over(GREY, Shapes((Circle(*place, radius, Ink("#FFFFFF")),))))
    distance = np.hypot(u - place[0], v - place[1])
    assert (distance * off).sum() / off.sum() == pytest.approx(radius, abs=0.5)
    assert np.abs(distance[off > 60] - radius).max() < 3.0  # half the line, and its soft edge


@given(a=places, b=places)
def test_a_line_runs_from_end_to_end(a, b):
    u, v, off = inked(draw_over(GREY, Shapes((Polyline(np.array([a, b]), Ink("#FFFFFF")),))))
    middle = (u * off).sum() / off.sum(), (v * off).sum() / off.sum()
    assert middle == pytest.approx(((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), abs=0.5)


def test_colours_are_those_of_the_ink_and_opencv_has_blue_first():
    dot = Circle(80.0, 60.0, 10.0, Ink("#D55E00"), filled=True)
    assert draw_over(GREY, Shapes((dot,)))[60, 80].tolist() == [0x00, 0x5E, 0xD5]


def test_what_is_in_doubt_lets_the_picture_through():
    dot = Circle(80.0, 60.0, 10.0, Ink("#FFFFFF", DOUBTFUL_OPACITY), filled=True)
    seen = draw_over(GREY, Shapes((dot,)))[60, 80]
    assert seen == pytest.approx(100 + DOUBTFUL_OPACITY * 155, abs=1)


def test_a_hollow_dot_shows_what_lies_under_it():
    dot = Circle(80.0, 60.0, 10.0, Ink("#FFFFFF"), filled=False)
    assert draw_over(GREY, Shapes((dot,)))[60, 80].tolist() == [100, 100, 100]


def test_the_head_is_drawn_on_top_of_what_came_before():
    below, above = (Circle(80.0, 60.0, 9.0, Ink(c), filled=True) for c in ("#FF0000", "#0000FF"))
    assert draw_over(GREY, Shapes((below, above)))[60, 80].tolist() == [255, 0, 0]


def test_the_reason_is_written_in_the_corner_and_nowhere_else():
    *_, off = inked(draw_over(GREY, Shapes((), "coiled")))
    assert off[:25, :80].any()
    assert not off[25:].any()


def test_the_picture_itself_is_left_as_it_was():
    picture = GREY.copy()
    draw_over(picture, Shapes((Circle(80.0, 60.0, 10.0, Ink("#FFFFFF")),), "coiled"))
    assert (picture == GREY).all()
