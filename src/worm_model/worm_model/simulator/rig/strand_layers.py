"""Adds up the strands of a body that lie over each subpixel of a picture."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.arrays import Floats
from worm_msgs_py.compiled import compiled, compiled_and_kept

SUBPIXELS = 3
"""A pixel is so many subpixels wide and high where nothing else is asked for.

The body's edge covers a subpixel in part."""
SAME_STRAND = 1.0
"""Midline points that reach a subpixel are of one strand unless more of the midline than so many
half widths, and a step between points, that does not reach it lies between them."""


STEEP = 0.01
"""A segment at a smaller slope does not limit the columns, or the rows, that are looked at."""


class Layers(NamedTuple):
    """What lies over each subpixel of a crop.

    Attributes
    ----------
    u0, v0 : int
        Picture coordinates of the crop's first pixel.
    total : ndarray of float32, shape (subpixels × height, subpixels × width)
        Sum over the strands; at the edge of one, of the part that it covers.
    subpixels : int
        A pixel is so many of them wide and high.
    """

    u0: int
    v0: int
    total: NDArray[np.float32]
    subpixels: int


class Strip(NamedTuple):
    """A skin's optical density (−ln of the transmission), head first.

    Attributes
    ----------
    density : ndarray of float32, shape (n, m)
        By arc length (rows) and offset across the midline (columns, the midline in the middle).
    rows_per_px, first_row, columns_per_px : float
        A row is ``s_px * rows_per_px - first_row``.
    """

    density: NDArray[np.float32]
    rows_per_px: float
    first_row: float
    columns_per_px: float


ONE_SHADE = Strip(np.zeros((0, 1), dtype=np.float32), 0.0, 0.0, 0.0)


class _Segment(NamedTuple):
    """A straight piece of the midline, in subpixels; arc length and half width in pixels."""

    u: float
    v: float
    axis_u: float
    axis_v: float
    length: float
    s_px: float
    long_px: float
    reach_px: float
    more_reach_px: float


class _Strand(NamedTuple):
    """Of the strand that came last over each subpixel of a row: where that lies deepest in it.

    How deep, what it added, and the arc length last seen; −inf where there was no strand.
    """

    deepest: NDArray[np.float32]
    value: NDArray[np.float32]
    last: NDArray[np.float32]


def sum_strands(
    points_px: Floats,
    s_px: Floats,
    reach_px: Floats,
    strip: Strip = ONE_SHADE,
    subpixels: int = SUBPIXELS,
) -> Layers:
    """Sum over the strands 1, or the density at the strand's nearest midline point.

    Parameters
    ----------
    points_px : ndarray, shape (n, 2)
        The midline, straight between its points.
    s_px, reach_px : ndarray, shape (n,)
        Arc length there, and how far to either side the body reaches.
    strip : Strip
        What is summed instead of 1.
    subpixels : int
        How finely; two are enough for a body many pixels wide.
    """
    margin = float(reach_px.max()) + 2.0
    first = np.floor(points_px.min(axis=0) - margin).astype(int)
    width, height = (np.ceil(points_px.max(axis=0) + margin).astype(int) - first + 1).tolist()
    total = np.zeros((height * subpixels, width * subpixels), dtype=np.float32)
    gap = SAME_STRAND * float(reach_px.max()) + float(np.diff(s_px).max())
    points = (points_px - first + 0.5) * subpixels - 0.5
    _add_segments(total, points, s_px, reach_px, gap, strip, subpixels)
    return Layers(int(first[0]), int(first[1]), total, subpixels)


@compiled_and_kept
def _add_segments(
    total: NDArray[np.float32],
    points: Floats,
    s_px: Floats,
    reach_px: Floats,
    gap_px: float,
    strip: Strip,
    subpixels: int,
) -> None:
    """Add what each strand absorbs to each subpixel that one of its segments reaches.

    It is done row by row, so that what is kept of a row stays near the processor.
    """
    rows = np.empty((len(points) - 1, 2), dtype=np.int64)
    for k in range(len(rows)):
        rows[k] = _rows_reached(_segment(points, s_px, reach_px, k), subpixels)
    every_column = np.arange(total.shape[1]).astype(np.float64)
    part, away2 = np.empty_like(every_column), np.empty_like(every_column)
    deepest, value, last = np.empty_like(total[0]), np.empty_like(total[0]), np.empty_like(total[0])
    for row in range(len(total)):
        last[:] = -np.inf
        for k in range(len(rows)):
            if not rows[k, 0] <= row < rows[k, 1]:
                continue
            segment = _segment(points, s_px, reach_px, k)
            low, high = _columns_reached(segment, row, subpixels)
            _look_along(segment, row, every_column[low:high], part, away2)
            strand = _Strand(deepest[low:high], value[low:high], last[low:high])
            _add_row(
                total[row, low:high],
                strand,
                segment,
                row,
                low,
                part,
                away2,
                gap_px,
                strip,
                subpixels,
            )


@compiled
def _segment(points: Floats, s_px: Floats, reach_px: Floats, k: int) -> _Segment:
    way_u, way_v = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
    length = max(np.hypot(way_u, way_v), 1e-9)
    return _Segment(
        points[k, 0],
        points[k, 1],
        way_u / length,
        way_v / length,
        length,
        s_px[k],
        s_px[k + 1] - s_px[k],
        reach_px[k],
        reach_px[k + 1] - reach_px[k],
    )


@compiled
def _far(segment: _Segment, subpixels: int) -> float:
    """Return how far away a subpixel may lie that the segment reaches."""
    return subpixels * (segment.reach_px + max(segment.more_reach_px, 0.0)) + 0.5


@compiled
def _rows_reached(segment: _Segment, subpixels: int) -> tuple[int, int]:
    """Return the first row that the segment may reach, and the one behind the last."""
    far = _far(segment, subpixels)
    end = segment.v + segment.length * segment.axis_v
    return int(min(segment.v, end) - far), int(max(segment.v, end) + far) + 2


@compiled
def _columns_reached(segment: _Segment, row: int, subpixels: int) -> tuple[int, int]:
    """Return the first column of a row that it may reach, and the one behind the last."""
    far = _far(segment, subpixels)
    u, axis_u, axis_v, length = segment.u, segment.axis_u, segment.axis_v, segment.length
    low, high = min(u, u + length * axis_u) - far, max(u, u + length * axis_u) + far
    down = row - segment.v
    if abs(axis_v) > STEEP:  # not too far to one side of it
        middle, half = u + down * axis_u / axis_v, far / abs(axis_v)
        low, high = max(low, middle - half), min(high, middle + half)
    if abs(axis_u) > STEEP:  # nor beyond its ends
        middle = u + (0.5 * length - down * axis_v) / axis_u
        half = (0.5 * length + far) / abs(axis_u)
        low, high = max(low, middle - half), min(high, middle + half)
    return int(low), int(max(high, low)) + 2


@compiled
def _look_along(segment: _Segment, row: int, column: Floats, part: Floats, away2: Floats) -> None:
    """Find for each column the nearest point of a segment, as a part of it, and its distance².

    There is no branch in it, so that it is compiled to vector instructions.
    """
    u, axis_u, axis_v, length = segment.u, segment.axis_u, segment.axis_v, segment.length
    down = row - segment.v
    for k in range(len(column)):
        across = axis_u * down - axis_v * (column[k] - u)
        along = axis_u * (column[k] - u) + axis_v * down
        part[k] = min(max(np.divide(along, length), 0.0), 1.0)
        away2[k] = across**2 + (along - part[k] * length) ** 2


@compiled
def _add_row(
    total: NDArray[np.float32],
    strand: _Strand,
    segment: _Segment,
    row: int,
    low: int,
    parts: Floats,
    away2s: Floats,
    gap_px: float,
    strip: Strip,
    subpixels: int,
) -> None:
    """Add a segment to a row: of those of one strand the one counts in which a subpixel is deepest.

    The first column is `low`.
    """
    deepest, value, last = strand
    rows, columns = strip.density.shape
    for k in range(len(total)):
        part, away2 = parts[k], away2s[k]
        reach = subpixels * (segment.reach_px + part * segment.more_reach_px)
        if away2 >= (reach + 0.5) ** 2:
            continue
        away = np.sqrt(away2)
        s, depth = segment.s_px + part * segment.long_px, reach - away
        fresh = s - last[k] > gap_px
        last[k] = s
        if not fresh and depth <= deepest[k]:
            continue
        now = min(0.5 + depth, 1.0)
        if rows:
            right, down = low + k - segment.u, row - segment.v
            across = segment.axis_u * down - segment.axis_v * right
            offset_px = np.copysign(away, across) / subpixels
            i = int(np.rint(s * strip.rows_per_px - strip.first_row))
            j = columns // 2 + int(np.rint(offset_px * strip.columns_per_px))
            now = strip.density[min(max(i, 0), rows - 1), j]
        total[k] += now - (0.0 if fresh else value[k])
        value[k], deepest[k] = now, depth
