"""Other places in which an end of a body may lie, and what each explains of the picture beside it.

An end that comes to lie on another part, or along it, shows less of itself than one in clear water.
Whether the picture tells where it is, is asked of the picture: were it bent otherwise from a width
or more behind its tip on, longer or shorter, would as much of the object be explained? It is as
sure as those places lie near to each other that explain as much.
"""

from dataclasses import dataclass
from math import ceil, inf, sqrt

import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.curve import complex_arc_length
from worm_tracker.midline.path import evenly, nodes_for
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_body


@dataclass(frozen=True, slots=True)
class OtherEndsSettings:
    """Which other places are tried, and when one is likelier."""

    window_widths: float = 4.0
    """How far about the end the picture is compared."""
    cut_widths: tuple[float, ...] = (1.0, 2.0, 3.0)
    """How far behind its tip an end may begin to lie otherwise."""
    bends_per_width: tuple[float, ...] = (
        -1.2, -0.9, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.9, 1.2,
    )  # fmt: skip
    """How it may bend from there on, radians in a width: a body does not bend more tightly."""
    longer_widths: float = 3.0
    length_step_widths: float = 0.25
    """How much longer than told it may be, and in which steps its length is tried."""
    step_px: float = 1.0
    """How finely an end is laid over the picture along itself; across it is by pixels."""
    unexplained_sd_widths2: float = 0.02
    moved_sd_widths: float = 2.0
    bend_sd_per_width: float = 0.4
    longer_sd_widths: float = 1.5
    """What a likely end differs by: in what it explains, in its place, its bend and its length."""
    sd_over_spread: float = 0.78
    """How surely an end is placed, over how far likely ones lie from it: of 1145 ends of one shade
    whose spread was up to 0.45 widths one was more than a width off; of those with a spread up to
    0.25, 0.3, 0.35 and 0.45 widths the root mean square error was 0.09, 0.14, 0.24 and 0.26."""
    least_gain_widths2: float = 0.04
    least_moved_widths: float = 0.4
    """How much more another end must explain to be the likelier one, and how far away it must lie:
    of ends nearer to each other the one that was slid there is known below a pixel."""


@dataclass(frozen=True, eq=False, slots=True)
class OtherEnds:
    """What ends leave unexplained in the picture beside one.

    Attributes
    ----------
    told : float
        What the end as it is leaves of the object, and has in the water, squared widths.
    unexplained : ndarray, shape (n,)
        The same of others.
    moved : ndarray, shape (n,)
        How far from the end as it is those end, pixels.
    cost : ndarray, shape (n,)
        What makes each less likely, minus the log of how likely it is: by what it leaves
        unexplained, by its place, its bend and its length.
    cut : ndarray, shape (n,)
        At which node of the body they begin to lie otherwise, a whole number.
    bend : ndarray, shape (n,)
        How they bend from there on, radians in a width.
    length : ndarray, shape (n,)
        How long they are from there on, pixels.
    """

    told: float
    unexplained: Floats
    moved: Floats
    cost: Floats
    cut: Floats
    bend: Floats
    length: Floats


def other_ends(
    mask: Picture,
    curve: Complex,
    half: Floats,
    width: float,
    drawing: StrandDrawingSettings,
    settings: OtherEndsSettings,
) -> OtherEnds:
    """Lay the first end of a body otherwise, and compare it with the object.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object; 0 where it is not.
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps, u + iv in the mask's coordinates.
    half : ndarray, shape (n,)
        Half the width that it is known to have there, pixels.
    width : float
        That of most of the body, pixels.
    drawing : StrandDrawingSettings
    settings : OtherEndsSettings
    """
    s = complex_arc_length(curve)
    window, corner = _window_about(mask, curve[0], settings.window_widths * width)
    line, told = curve - corner, np.inf
    bends = np.array(settings.bends_per_width)
    tried = [(np.empty(0), np.empty(0, np.complex128), np.empty((0, 3)))]
    nodes = np.minimum(np.searchsorted(s, np.array(settings.cut_widths) * width), len(curve) - 4)
    for k in np.unique(nodes[nodes > 1]):
        rest = drawn_body(window.shape, line[k:], 2 * half[k:], drawing)
        gain, left = _explained_by_pixel(window, rest)
        as_it_is = evenly(line[k::-1], max(4, ceil(s[k] / settings.step_px) + 1))
        covered = _covered(gain, as_it_is[None], s[k : k + 1], s, half, float(s[k]))
        told = min(told, left - float(covered[0, 0]))
        step = settings.length_step_widths * width
        lengths = step * np.arange(1, ceil((s[k] + settings.longer_widths * width) / step) + 1)
        arcs = _arcs(line[k], line[k + 2], float(lengths[-1]), bends / width, settings.step_px)
        covered = _covered(gain, arcs, lengths, s, half, float(lengths[-1]))
        at = np.rint(lengths / lengths[-1] * (arcs.shape[1] - 1)).astype(int)
        shapes = np.broadcast_arrays(float(k), bends[:, None], lengths)
        shape = np.stack(shapes, axis=2).reshape(-1, 3)
        tried.append(((left - covered).ravel(), (arcs[:, at] + corner).ravel(), shape))
    unexplained, tips, shape = (np.concatenate(parts) for parts in zip(*tried, strict=True))
    unexplained /= width**2
    moved = np.abs(tips - curve[0])
    cut, bend, length = shape.T
    longer = length - s[cut.astype(int)]
    cost = _cost(unexplained, moved / width, bend, longer / width, settings)
    return OtherEnds(told / width**2, unexplained, moved, cost, cut, bend, length)


def likelier_end(
    others: OtherEnds, curve: Complex, width: float, settings: OtherEndsSettings
) -> Complex | None:
    """Return a body with its first end where it is likelier; None where nowhere else is.

    Parameters
    ----------
    others : OtherEnds
        Of this end.
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps.
    width : float
        The body's, pixels.
    settings : OtherEndsSettings
    """
    if not len(others.cost):
        return None
    best = int(others.cost.argmin())
    gain = others.told - others.unexplained[best]
    least_px = settings.least_moved_widths * width
    if gain < settings.least_gain_widths2 or others.moved[best] < least_px:
        return None
    cut, bend = int(others.cut[best]), others.bend[best : best + 1] / width
    step = float(complex_arc_length(curve[:2])[1])
    arc = _arcs(curve[cut], curve[cut + 2], float(others.length[best]), bend, step)[0]
    whole = np.concatenate([arc[:0:-1], curve[cut:]])
    return evenly(whole, nodes_for(float(complex_arc_length(whole)[-1]), width))


def sd_by_outline(others: OtherEnds, settings: OtherEndsSettings) -> float:
    """Return how surely an end is where it is, by its outline alone.

    A standard deviation in pixels, after how far from it others end, each by how likely it is; inf
    where there are none.
    """
    if not len(others.cost):
        return inf
    likely = np.exp(others.cost.min() - others.cost)
    return settings.sd_over_spread * sqrt(np.average(others.moved**2, weights=likely))


def _cost(
    unexplained: Floats,
    moved_widths: Floats,
    bend: Floats,
    longer_widths: Floats,
    settings: OtherEndsSettings,
) -> Floats:
    """Return what makes ends less likely, minus the log of how likely each is."""
    return (
        unexplained / settings.unexplained_sd_widths2
        + (moved_widths / settings.moved_sd_widths) ** 2 / 2
        + (bend / settings.bend_sd_per_width) ** 2 / 2
        + (longer_widths / settings.longer_sd_widths) ** 2 / 2
    )


def _window_about(mask: Picture, point: complex, reach: float) -> tuple[Picture, complex]:
    """Return what of a mask is about a point, and where that begins."""
    u, v = (max(int(x - reach), 0) for x in (point.real, point.imag))
    beyond_u, beyond_v = (max(ceil(x + reach), 0) + 1 for x in (point.real, point.imag))
    return mask[v:beyond_v, u:beyond_u], complex(u, v)


def _explained_by_pixel(window: Picture, rest: Picture) -> tuple[Floats32, float]:
    """Return what an end explains at each pixel, and what is unexplained without one."""
    gain = np.where(window > 0, np.float32(1), np.float32(-1))
    left = np.count_nonzero((window > 0) != (rest > 0))
    gain[rest > 0] = 0
    return gain, float(left)


def _arcs(start: complex, behind: complex, longest: float, bends: Floats, step: float) -> Complex:
    """Return arcs that go on from a point, one for each bend, shape (bends, nodes)."""
    along = np.linspace(0.0, longest, max(2, ceil(longest / step) + 1))
    heading = np.angle(start - behind) + bends[:, None] * (along[1:] + along[:-1]) / 2
    ways = np.cumsum(np.exp(1j * heading) * np.diff(along), axis=1)
    return start + np.concatenate([np.zeros((len(bends), 1)), ways], axis=1)


def _covered(
    gain: Floats32, ways: Complex, lengths: Floats, s: Floats, half: Floats, longest: float
) -> Floats:
    """Return what ends of some lengths along some ways explain, shape (ways, lengths), pixels.

    So long before its tip an end is as wide as the body is at `s` from there on.
    """
    before_tip = lengths[:, None] - np.linspace(0.0, longest, ways.shape[1])
    halves = np.where(before_tip > 0, np.interp(before_tip, s, half), 0.0)
    covered = np.zeros((len(ways), len(lengths)))
    _sum_up_covered(gain, ways, halves, covered)
    return covered


@compiled_for(
    array_read(types.float32, 2),
    array_read(types.complex128, 2),
    array_read(types.float64, 2),
    array_written(types.float64, 2),
)
def _sum_up_covered(gain: Floats32, ways: Complex, halves: Floats, covered: Floats) -> None:
    """Sum up what lies nearer to each way than half the width, for each course of that.

    The picture is looked at across the way, a pixel after the other; on the outer side of a bend
    these are farther apart than on the inner.
    """
    h, w = gain.shape
    reach = max(1, int(np.ceil(halves.max() + 0.5)) if halves.size else 1)
    within = np.zeros(reach + 2)
    n = ways.shape[1]
    for way in range(len(ways)):
        line = ways[way]
        for node in range(n):
            before, after = line[max(node - 1, 0)], line[min(node + 1, n - 1)]
            along = after - before
            if not 0 < abs(along) < 1e6:
                continue
            normal = 1j * along / abs(along)
            step = abs(along) / (min(node + 1, n - 1) - max(node - 1, 0))
            turn = 0.0
            if 0 < node < n - 1:
                turn = np.angle((after - line[node]) * (line[node] - before).conjugate()) / step
            within[0] = 0.0
            for off in range(reach + 1):
                ring = 0.0
                for side in range(-1, 2, 2):
                    if off == 0 and side < 0:
                        continue
                    point = line[node] + side * off * normal
                    u, v = int(np.rint(point.real)), int(np.rint(point.imag))
                    if 0 <= u < w and 0 <= v < h:
                        ring += gain[v, u] * max(1 - side * off * turn, 0.0)
                within[off + 1] = within[off] + ring * step
            for length in range(halves.shape[0]):
                if halves[length, node] > 0:
                    edge = halves[length, node] + 0.5
                    whole = int(edge)
                    part = edge - whole
                    more = (within[whole + 1] - within[whole]) if whole <= reach else 0.0
                    covered[way, length] += within[whole] + part * more
