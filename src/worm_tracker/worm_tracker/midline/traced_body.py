"""Traces a body through its object from an end, as straight on as it can, where nothing is known.

Between two edges the body lies in the middle; beside one alone it goes on as far from that as
before; where another strand hides both it goes straight on, and where water is ahead it turns back
along itself. One manner of tracing fails where another does not, so that there are several.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import cv2
import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats32, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.contour_midline import ContourMidlineSettings, ends_of_contour

_TIP_STEPS = 4
"""So many steps from a tip the body is narrow: water ahead does not say that it turns."""
_TURN_RAD, _TURNS, _MOST_TURN_RAD = 0.2, 8, 0.6
"""By how much, and how often, a heading is turned to see where the body goes on; and how far it may
turn in a step."""


class TracingManner(NamedTuple):
    """How a body is traced; lengths are in widths of the body."""

    edge_reach: float = 0.65
    """How far to either side an edge may be to be the body's own."""
    most_shift: float = 0.12
    most_shift_by_one_edge: float = 0.045
    """How far a step is moved aside at most, between two edges and beside one."""
    most_width_over_body: float = 1.3
    """How much wider than the body it may be between two edges: else one is another strand's."""
    weight_of_step: float = 0.35
    """Of the last step, in where the body heads."""
    weight_of_width: float = 0.15
    """Of a step between two edges, in how wide the body is there."""
    look_ahead: float = 0.45
    clearance: float = 0.4
    """The body turns where so far ahead the object's edge is nearer than so many half widths."""


@dataclass(frozen=True, slots=True)
class TracedBodySettings:
    """How a body is traced, and what may be one.

    Of 334 folded pictures in which both ends are seen (seven films, true length) a line of the
    first manner is right in 66 %, of the second in 63, of the third in 57, of any in 82.
    """

    manners: tuple[TracingManner, ...] = (
        TracingManner(),
        TracingManner(weight_of_step=0.2, clearance=0.25),
        TracingManner(edge_reach=0.8, most_shift_by_one_edge=0.08),
    )
    step_widths: float = 0.25
    least_length: float = 0.75
    most_length: float = 1.3
    """Length of a body, over that of the worm."""
    least_hole_widths2: float = 0.5
    """Area of a hole that an end may reach into, squared widths."""
    ends: ContourMidlineSettings = field(default_factory=ContourMidlineSettings)


def traced_bodies(
    mask: Picture, width: float, length: float, settings: TracedBodySettings
) -> list[Complex]:
    """Return bodies that begin at what may be an end of an object.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object; 0 where it is not.
    width, length : float
        The worm's, pixels.
    settings : TracedBodySettings

    Returns
    -------
    list of ndarray of complex, shape (n,)
        u + iv, from the end on.
    """
    step = settings.step_widths * width
    depth = np.asarray(cv2.distanceTransform(mask, cv2.DIST_L2, 5), np.float32)
    line = np.empty(int(settings.most_length * length / step) + 2, np.complex128)
    found = list[Complex]()
    for tip, inwards in _likely_ends(mask, width, settings):
        for manner in settings.manners:
            count = _trace_on(depth, tip, inwards, step, width, manner, line)
            if settings.least_length * length < (count - 1) * step and count < len(line):
                found.append(line[:count].copy())
    return found


def _likely_ends(
    mask: Picture, width: float, settings: TracedBodySettings
) -> list[tuple[complex, complex]]:
    """Return where a body may begin, and the direction into it."""
    contours, tree = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    ends = list[tuple[complex, complex]]()
    for contour, (_, _, _, parent) in zip(contours, tree[0] if len(contours) else [], strict=True):
        pixels = np.asarray(contour[:, 0], np.int32)
        if cv2.contourArea(pixels) > settings.least_hole_widths2 * width**2:
            ends += ends_of_contour(pixels, width, settings.ends, is_hole=parent >= 0)
    return ends


@compiled
def _depth_at(depth: Floats32, place: complex) -> float:
    """Return how far a place lies within the object, pixels; 0 beside it."""
    u, v = int(place.real + 0.5), int(place.imag + 0.5)
    if 0 <= u < depth.shape[1] and 0 <= v < depth.shape[0]:
        return float(depth[v, u])
    return 0.0


@compiled
def _to_edge(depth: Floats32, place: complex, aside: complex, most: float) -> float:
    """Return how far it is from a place to the edge of the object, no more than this, pixels."""
    far = 0.5
    while far < most and _depth_at(depth, place + far * aside) > 0:
        far += 0.5
    return min(far, most)


@compiled
def _turned_off_water(
    depth: Floats32, place: complex, heading: complex, ahead: float, clearance: float
) -> complex:
    """Return the heading, turned by as little as leads on within the object."""
    if _depth_at(depth, place + ahead * heading) >= clearance:
        return heading
    for k in range(1, _TURNS + 1):
        turn = np.exp(1j * _TURN_RAD * k)
        one = _depth_at(depth, place + ahead * heading * turn)
        other = _depth_at(depth, place + ahead * heading / turn)
        if max(one, other) >= clearance:
            turn = np.exp(1j * min(_TURN_RAD * k, _MOST_TURN_RAD))
            return complex(heading * turn if one >= other else heading / turn)
    return heading


@compiled
def _is_between_edges(
    one: float, other: float, half_width: float, width: float, manner: TracingManner
) -> bool:
    """Tell whether the edges to both sides are those of the body."""
    near = one + other < 2 * (manner.most_width_over_body * half_width + 1)
    return near and max(one, other) < manner.edge_reach * width


@compiled
def _shift_aside(
    one: float, other: float, half_width: float, width: float, manner: TracingManner
) -> float:
    """Return how far a step is moved aside, by how far it is to the edge on either side, pixels.

    Both are no more than where an edge was looked for.
    """
    edge, most = manner.edge_reach * width, manner.most_shift_by_one_edge * width
    if _is_between_edges(one, other, half_width, width, manner):
        shift, most = (one - other) / 2, manner.most_shift * width
    elif min(one, other) < edge:
        by_one = other == edge or (one < edge and abs(one - half_width) < abs(other - half_width))
        shift = one - half_width if by_one else half_width - other
    else:
        shift = 0.0
    return min(max(shift, -most), most)


@compiled_for(
    array_read(types.float32, 2),
    types.complex128,
    types.complex128,
    types.float64,
    types.float64,
    types.NamedUniTuple(types.float64, len(TracingManner._fields), TracingManner),
    array_written(types.complex128),
)
def _trace_on(
    depth: Floats32,
    tip: complex,
    inwards: complex,
    step: float,
    width: float,
    manner: TracingManner,
    line: Complex,
) -> int:
    """Fill in a body's points from its tip on; return how many there are: all where it goes on."""
    half_width, edge = width / 2, manner.edge_reach * width
    line[0], heading = tip, inwards
    for k in range(1, len(line)):
        if k > _TIP_STEPS:
            clearance = manner.clearance * min(half_width, width / 2)
            heading = _turned_off_water(
                depth, line[k - 1], heading, manner.look_ahead * width, clearance
            )
        place, aside = line[k - 1] + step * heading, 1j * heading
        if _depth_at(depth, place) == 0:
            return k
        one, other = _to_edge(depth, place, aside, edge), _to_edge(depth, place, -aside, edge)
        aside *= _shift_aside(one, other, half_width, width, manner)
        line[k] = place + aside
        if _is_between_edges(one, other, half_width, width, manner):
            half_width += manner.weight_of_width * ((one + other) / 2 - half_width)
        way = line[k] - line[k - 1]
        heading += manner.weight_of_step * (way / max(abs(way), 1e-9) - heading)
        heading /= max(abs(heading), 1e-9)
    return len(line)
