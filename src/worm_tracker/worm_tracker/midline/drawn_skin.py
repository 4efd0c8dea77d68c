"""Draws a body in its own skin: each place of it lets as much light through as is known of it.

Where two parts lie on each other each dims what the other lets through.
"""

from dataclasses import dataclass

import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.body_shade import ACROSS, at_parts
from worm_tracker.midline.strand_drawing import FARTHEST_PX

_MOST_ABSORBED = 0.98
"""Part of the light that a place of a body keeps at most."""
_LEAST_LET_THROUGH = 0.05
"""Part of the light that most of a body lets through at least: where overlaps are twice as dark it
would be all, and how dark a background is could not be told."""
_OUTERMOST = float(ACROSS[-1])


@dataclass(frozen=True, eq=False, slots=True)
class SkinnedBody:
    """A body in a picture, and what is known of its skin.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,)
        Its midline at equal steps from one end on, u + iv.
    widths : ndarray, shape (m,)
        Its widths from that end on, at equal parts of its length, pixels.
    mean : ndarray, shape (k, len(ACROSS))
        Signal of one layer of it from that end on and from its left to its right, as `curve` heads
        in u + iv.
    level : float
        Signal of most of it, grey levels.
    darkening : float
        How much darker two parts are that lie on each other than one, relatively.
    """

    curve: Complex
    widths: Floats
    mean: Floats
    level: float
    darkening: float

    @property
    def blackest(self) -> float:
        """Signal of what lets no light through, grey levels.

        Of two parts on each other the second takes away as much less than the first as that has
        taken: level (1 - level / blackest) = darkening level.
        """
        return self.level / max(1 - self.darkening, _LEAST_LET_THROUGH)

    def absorbed(self, part: Floats) -> Floats:
        """Return what it keeps of the light at parts of its length, shape (n, len(ACROSS))."""
        seen = at_parts(self.mean, np.clip(part, 0.0, 1.0))
        return np.clip(seen / self.blackest, 0.0, _MOST_ABSORBED)


def dim_by_body(
    through: Floats, line: Complex, half: Floats, absorbed: Floats, cut: tuple[bool, bool]
) -> None:
    """Dim what is let through to each pixel of a window by a body that lies there.

    As often as parts of it pass over that pixel.

    Parameters
    ----------
    through : ndarray, shape (h, w)
        Part of the light; changed in place.
    line : ndarray of complex, shape (n,)
        The midline in the window's coordinates, u + iv; its nodes lie nearer than half a width.
    half : ndarray, shape (n,)
        Half its width there, pixels.
    absorbed : ndarray, shape (n, len(ACROSS))
        Part of the light that the body keeps at each node and across it.
    cut : tuple of bool
        Whether either end is cut straight off at its last node but one, where another part that
        heads the same way goes on; else it is round.
    """
    _dim(line, half, absorbed, *cut, through)


@compiled
def _dim_pixel(
    through: Floats,
    v: int,
    u: int,
    node: int,
    line: Complex,
    half: Floats,
    absorbed: Floats,
    cut_first: bool,
    cut_last: bool,
) -> None:
    """Dim a pixel by the part of a body that passes over it, nearest with one of its nodes."""
    last = len(line) - 1
    along = line[min(node + 1, last)] - line[max(node - 1, 0)]
    off = (u + 1j * v - line[node]) * (along / max(abs(along), 1e-9)).conjugate()
    distance, before_cut = abs(off.imag), 1.0
    if (node == 0 and off.real < 0) or (node == last and off.real > 0):
        distance = abs(off)
    if (cut_first and node == 1) or (cut_last and node == last - 1):
        within = off.real if cut_first and node == 1 else -off.real
        before_cut = min(max(0.5 + within, 0.0), 1.0)
    cover = min(max(half[node] + 0.5 - distance, 0.0), 1.0) * before_cut
    if cover > 0:
        outermost = absorbed.shape[1] - 1
        across = off.imag / (2 * max(half[node], 0.5))
        at = (min(max(across / _OUTERMOST, -1.0), 1.0) + 1) * outermost / 2
        k = min(int(at), outermost - 1)
        kept = absorbed[node, k] + (at - k) * (absorbed[node, k + 1] - absorbed[node, k])
        through[v, u] *= 1 - cover * kept


@compiled_for(
    array_read(types.complex128),
    array_read(types.float64),
    array_read(types.float64, 2),
    types.boolean,
    types.boolean,
    array_written(types.float64, 2),
)
def _dim(
    line: Complex, half: Floats, absorbed: Floats, cut_first: bool, cut_last: bool, through: Floats
) -> None:
    """Dim each pixel once for each run of nodes in a row that are near enough to it."""
    h, w = through.shape
    nearest, latest = np.full((2, h, w), -1, np.int32)
    least = np.empty((h, w))
    for node in range(1 if cut_first else 0, len(line) - 1 if cut_last else len(line)):
        reach, centre = half[node] + 1.0, line[node]
        if not abs(centre) + reach < FARTHEST_PX:
            continue
        for v in range(max(0, int(centre.imag - reach)), min(h - 1, int(centre.imag + reach)) + 1):
            for u in range(
                max(0, int(centre.real - reach)), min(w - 1, int(centre.real + reach)) + 1
            ):
                away = (u - centre.real) ** 2 + (v - centre.imag) ** 2
                if away >= reach**2:
                    continue
                if nearest[v, u] >= 0 and latest[v, u] < node - 1:
                    _dim_pixel(
                        through, v, u, nearest[v, u], line, half, absorbed, cut_first, cut_last
                    )
                    nearest[v, u] = -1
                if nearest[v, u] < 0 or away < least[v, u]:
                    nearest[v, u], least[v, u] = node, away
                latest[v, u] = node
    for v in range(h):
        for u in range(w):
            if nearest[v, u] >= 0:
                _dim_pixel(through, v, u, nearest[v, u], line, half, absorbed, cut_first, cut_last)
