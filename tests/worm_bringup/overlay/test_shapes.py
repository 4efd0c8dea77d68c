"""What is drawn over a frame is where the frame says, and what is in doubt looks so."""

from dataclasses import replace
from math import hypot, nan

import numpy as np
import pytest

from worm_bringup.overlay.shapes import DOUBTFUL_OPACITY, circle_points, shapes_of
from worm_model.simulator.rig import Rig
from worm_msgs_py import BodyState, Keypoint, Midline, Status
from worm_msgs_py.colours import (
    CENTROID_COLOUR,
    EXIT_COLOUR,
    HEAD_COLOUR,
    MIDLINE_COLOUR,
    TAIL_COLOUR,
    WALL_COLOUR,
)

RIG = Rig(chamber_b=True, px_per_mm=16.0, width_px=1280, height_px=448, centre_px=(200.3, 235.1))
STATE = BodyState(
    frame=3,
    stamp_ns=7,
    status=Status.TRACKED,
    geometry=1,
    head_certainty=0.99,
    head=Keypoint(100.0, 50.0),
    centroid=Keypoint(150.0, 60.0),
    tail=Keypoint(200.0, 70.0),
    width_px=8.0,
)
NOTHING = BodyState(frame=3, stamp_ns=7)


def midline(u, v):
    u, v = np.asarray(u, float), np.asarray(v, float)
    return Midline(u, v, u * nan, u * nan, u * nan, u * nan)


def wave(n=65):
    u = np.linspace(100.0, 200.0, n)
    return midline(u, 60.0 + 12.0 * np.sin(u / 9.0))


def of_colour(items, colour):
    return [item for item in items if item.ink.colour == colour]


def distance_to(points, line):
    """Return how far each point is from a line of many points."""
    starts, steps = line[:-1], np.diff(line, axis=0)
    along = np.einsum("nkd,kd->nk", points[:, None] - starts, steps) / (steps**2).sum(axis=1)
    feet = starts + np.clip(along, 0.0, 1.0)[..., None] * steps
    return np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1)


def test_walls_are_the_circles_of_both_chambers_and_exits_close_the_gap():
    shapes = shapes_of(NOTHING, Midline.empty(), RIG.geometry())
    walls, exits = of_colour(shapes.circles, WALL_COLOUR), of_colour(shapes.lines, EXIT_COLOUR)
    for chamber, wall, way_out in zip(RIG.chambers, walls, exits, strict=True):
        edge = RIG.wall_distance_px(*circle_points(wall).T)
        assert np.abs(edge[edge > -0.5]).max() < 1e-9  # on the wall's inner edge, but at the exit
        assert len(circle_points(wall)) - (edge > -0.5).sum() > 3
        a, b = way_out.points_px
        assert hypot(*(a - b)) == pytest.approx(chamber.exit_width_m * chamber.px_per_m)
        assert np.abs(RIG.wall_distance_px(*way_out.points_px.T)).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "colour"),
    [("head", HEAD_COLOUR), ("centroid", CENTROID_COLOUR), ("tail", TAIL_COLOUR)],
)
def test_each_keypoint_has_a_dot_of_its_own_colour(name, colour):
    (dot,) = of_colour(shapes_of(STATE, wave(), None).circles, colour)
    point = getattr(STATE, name)
    assert (dot.u_px, dot.v_px, dot.filled) == (point.u_px, point.v_px, True)


def test_the_midline_is_thinned_by_less_than_can_be_seen():
    line = wave()
    (drawn,) = of_colour(shapes_of(STATE, line, None).lines, MIDLINE_COLOUR)
    there = np.stack([line.u_px, line.v_px], axis=1)
    assert len(drawn.points_px) < len(there)
    assert distance_to(there, drawn.points_px).max() < 0.25
    assert drawn.points_px[[0, -1]] == pytest.approx(there[[0, -1]], abs=1e-4)


def test_a_part_of_the_midline_that_was_not_seen_is_left_open():
    line = wave()
    line.u_px[20:30] = nan
    parts = of_colour(shapes_of(STATE, line, None).lines, MIDLINE_COLOUR)
    ends = [part.points_px[[0, -1], 0] for part in parts]
    assert np.ravel(ends) == pytest.approx(line.u_px[[0, 19, 30, 64]], abs=1e-4)


@pytest.mark.parametrize("status", [Status.FOLDED, Status.BRIDGED])
def test_a_pose_in_doubt_is_pale_and_says_why(status):
    shapes = shapes_of(replace(STATE, status=status), wave(), RIG.geometry())
    for item in (*shapes.lines, *shapes.circles):
        of_the_rig = item.ink.colour in (WALL_COLOUR, EXIT_COLOUR)
        assert item.ink.opacity == (1.0 if of_the_rig else DOUBTFUL_OPACITY)
    assert shapes.text == status.label


def test_an_uncertain_head_is_hollow_and_so_is_the_tail():
    shapes = shapes_of(replace(STATE, head_certainty=0.71), wave(), None)
    filled = {dot.ink.colour: dot.filled for dot in shapes.circles}
    assert filled == {HEAD_COLOUR: False, TAIL_COLOUR: False, CENTROID_COLOUR: True}
    assert shapes.text == "head or tail? 0.71"


def test_a_frame_without_a_worm_shows_the_rig_and_the_reason_alone():
    shapes = shapes_of(NOTHING, Midline.empty(), RIG.geometry())
    assert {item.ink.colour for item in (*shapes.lines, *shapes.circles)} == {
        WALL_COLOUR,
        EXIT_COLOUR,
    }
    assert shapes.text == "no_worm"


def test_a_frame_without_doubt_has_no_text():
    assert shapes_of(STATE, wave(), RIG.geometry()).text == ""
