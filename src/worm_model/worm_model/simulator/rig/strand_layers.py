"""Adds up the strands of a body that lie over each subpixel of a picture."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from worm_model.filament.compiled import compiled, compiled_and_kept
from worm_msgs_py.arrays import Floats

SUBPIXELS = 3
"""A pixel is so many subpixels wide and high where nothing else is asked for.

The body's edge covers a subpixel in part."""
SAME_STRAND = 1.0
"""Midline points that reach a subpixel are of one strand unless more of the midline than so many
half widths, and a step between points, that does not reach it lies between them."""


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
    way_u: float
    way_v: float
    s_px: float
    long_px: float
    reach_px: float
    more_reach_px: float


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
    """Add what each strand absorbs to each subpixel that one of its segments reaches."""
    deepest, value = np.zeros_like(total), np.zeros_like(total)
    last = np.full_like(total, -np.inf)
    for k in range(len(points) - 1):
        segment = _Segment(
            points[k, 0],
            points[k, 1],
            points[k + 1, 0] - points[k, 0],
            points[k + 1, 1] - points[k, 1],
            s_px[k],
            s_px[k + 1] - s_px[k],
            reach_px[k],
            reach_px[k + 1] - reach_px[k],
        )
        _add_segment(total, deepest, value, last, segment, gap_px, strip, subpixels)


@compiled
def _add_segment(
    total: NDArray[np.float32],
    deepest: NDArray[np.float32],
    value: NDArray[np.float32],
    last: NDArray[np.float32],
    segment: _Segment,
    gap_px: float,
    strip: Strip,
    subpixels: int,
) -> None:
    """Add a segment: of those of one strand the one counts in which a subpixel lies deepest.

    `deepest` and `value` are the depth and what was added of the strand that came last, and `last`
    is its arc length there.
    """
    u, v, way_u, way_v, s_px, long_px, reach_px, more_reach_px = segment
    rows, columns = strip.density.shape
    length = max(np.hypot(way_u, way_v), 1e-9)
    axis_u, axis_v = way_u / length, way_v / length
    far = subpixels * (reach_px + max(more_reach_px, 0.0)) + 0.5
    for row in range(int(min(v, v + way_v) - far), int(max(v, v + way_v) + far) + 2):
        for column in range(int(min(u, u + way_u) - far), int(max(u, u + way_u) + far) + 2):
            across = axis_u * (row - v) - axis_v * (column - u)
            if abs(across) >= far:
                continue
            along = axis_u * (column - u) + axis_v * (row - v)
            part = min(max(along / length, 0.0), 1.0)
            away2 = across**2 + (along - part * length) ** 2
            reach = subpixels * (reach_px + part * more_reach_px)
            if away2 >= (reach + 0.5) ** 2:
                continue
            s, depth = s_px + part * long_px, reach - np.sqrt(away2)
            fresh = s - last[row, column] > gap_px
            last[row, column] = s
            if not fresh and depth <= deepest[row, column]:
                continue
            now = min(0.5 + depth, 1.0)
            if rows:
                offset_px = np.copysign(np.sqrt(away2), across) / subpixels
                i = int(np.rint(s * strip.rows_per_px - strip.first_row))
                j = columns // 2 + int(np.rint(offset_px * strip.columns_per_px))
                now = strip.density[min(max(i, 0), rows - 1), j]
            total[row, column] += now - (0.0 if fresh else value[row, column])
            value[row, column], deepest[row, column] = now, depth
