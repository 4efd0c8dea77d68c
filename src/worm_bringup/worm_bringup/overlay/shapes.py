"""Which shapes say over a picture what was found in it: wall, exit, midline, head, centroid, tail.

One rule for all who draw: annotations in bags, the live view, the overlay topic and the film. A
frame that is in doubt looks so: a pose that is not plainly `tracked` is pale, an uncertain head is
hollow, and a line of text says which it is.
"""

from dataclasses import dataclass
from math import asin, isfinite, pi

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.colours import (
    CENTROID_COLOUR,
    EXIT_COLOUR,
    HEAD_COLOUR,
    MIDLINE_COLOUR,
    TAIL_COLOUR,
    WALL_COLOUR,
)
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY, BodyState, Midline
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.status import Status

DOUBTFUL_OPACITY = 0.45
"""Opacity of what is in doubt."""
_THICK_PX = 1.5
_LEAST_DOT_PX = 5.0
_DOT_WIDTHS = 0.8
"""A keypoint's dot in widths of the body: the body's edges stay to be seen beside it."""
_RING_OVER_DOT = 2.0
"""A ring is so much larger than a dot: one that is small would look filled."""
_MIDLINE_WITHIN_PX = 0.2
"""A midline is drawn through the fewest of its points that keep all others so near."""
_KEYPOINT_COLOURS = (("tail", TAIL_COLOUR), ("centroid", CENTROID_COLOUR), ("head", HEAD_COLOUR))
"""In the order of drawing: the head on top."""


@dataclass(frozen=True, slots=True)
class Ink:
    """How a shape is drawn: a colour as ``#RRGGBB``, and its opacity, 0 to 1."""

    colour: str
    opacity: float = 1.0


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle; `u_px`, `v_px` with whole numbers at pixel centres."""

    u_px: float
    v_px: float
    radius_px: float
    ink: Ink
    filled: bool = False
    thick_px: float = _THICK_PX


@dataclass(frozen=True, eq=False, slots=True)
class Polyline:
    """A line from point to point; `points_px` has shape (n, 2), u and v."""

    points_px: Floats
    ink: Ink
    thick_px: float = _THICK_PX


@dataclass(frozen=True, slots=True)
class Shapes:
    """All that is drawn over one picture.

    Attributes
    ----------
    items : tuple of Circle and Polyline
        Each lies below the next.
    text : str
        What is doubtful of the frame, for the picture's upper left corner; empty where nothing is.
    """

    items: tuple[Circle | Polyline, ...] = ()
    text: str = ""

    @property
    def lines(self) -> list[Polyline]:
        """Exits and midline."""
        return [item for item in self.items if isinstance(item, Polyline)]

    @property
    def circles(self) -> list[Circle]:
        """Walls, then tail, centroid and head."""
        return [item for item in self.items if isinstance(item, Circle)]


def shapes_of(state: BodyState, midline: Midline, geometry: Geometry | None) -> Shapes:
    """Return what is drawn of a frame.

    Parameters
    ----------
    state : BodyState
    midline : Midline
        Of the same frame; points that were not seen are NaN, and are left open.
    geometry : Geometry, optional
        The rig in this frame; None where it is not known.
    """
    ink = 1.0 if state.status is Status.TRACKED else DOUBTFUL_OPACITY
    body = tuple(Polyline(part, Ink(MIDLINE_COLOUR, ink)) for part in _seen_stretches(midline))
    rig = shapes_of_rig(geometry) if geometry is not None else ()
    return Shapes((*rig, *body, *_dots(state, ink)), _doubt(state))


def shapes_of_rig(geometry: Geometry) -> tuple[Circle | Polyline, ...]:
    """Return walls and exits."""
    chambers = geometry.chambers
    walls = (Circle(c.centre_u_px, c.centre_v_px, c.radius_px, Ink(WALL_COLOUR)) for c in chambers)
    exits = (_exit(c) for c in chambers if isfinite(c.exit_width_m) and c.exit_width_m > 0)
    return (*walls, *exits)


def _exit(chamber: Chamber) -> Polyline:
    """Return the exit as a line across its opening, from one end of the wall to the other."""
    half = asin(min(1.0, chamber.exit_width_m / (2 * chamber.radius_m)))
    angles = np.array([-half, half])
    x, y = chamber.radius_m * np.cos(angles), chamber.radius_m * np.sin(angles)
    return Polyline(np.stack(chamber.to_pixels(x, y), axis=1), Ink(EXIT_COLOUR), 2 * _THICK_PX)


def _seen_stretches(midline: Midline) -> list[Floats]:
    """Return the stretches of a midline that were seen, through as few points as will do."""
    points = np.stack([midline.u_px, midline.v_px], axis=1)
    seen = np.isfinite(points).all(axis=1)
    cuts = np.flatnonzero(np.diff(seen.astype(np.int8))) + 1
    return [
        cv2.approxPolyDP(part.astype(np.float32), _MIDLINE_WITHIN_PX, closed=False)[:, 0].astype(
            np.float64
        )
        for part in np.split(points, cuts)
        if len(part) > 1 and np.isfinite(part).all()
    ]


def _dots(state: BodyState, opacity: float) -> tuple[Circle, ...]:
    width_px = state.width_px if isfinite(state.width_px) else 0.0
    radius_px = max(_LEAST_DOT_PX, _DOT_WIDTHS * width_px) / 2
    dots = []
    for name, colour in _KEYPOINT_COLOURS:
        point = getattr(state, name)
        if isfinite(point.u_px) and isfinite(point.v_px):
            filled = name == "centroid" or state.head_certainty >= SURE_HEAD_CERTAINTY
            size_px = radius_px if filled else _RING_OVER_DOT * radius_px
            ink = Ink(colour, opacity)
            dots.append(Circle(point.u_px, point.v_px, size_px, ink, filled))
    return tuple(dots)


def _doubt(state: BodyState) -> str:
    said = [] if state.status is Status.TRACKED else [state.status.label]
    if state.status.may_have_head and state.head_certainty < SURE_HEAD_CERTAINTY:
        said.append(f"head or tail? {state.head_certainty:.2f}")
    return ", ".join(said)


def circle_points(circle: Circle, count: int = 360) -> Floats:
    """Return points on a circle, shape (count, 2)."""
    angles = np.linspace(0.0, 2 * pi, count, endpoint=False)
    return np.stack(
        [
            circle.u_px + circle.radius_px * np.cos(angles),
            circle.v_px + circle.radius_px * np.sin(angles),
        ],
        axis=1,
    )
