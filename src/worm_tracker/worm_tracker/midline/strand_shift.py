"""Moves a strand of a body sideways, to what of its object is missing beside it.

Where two strands lie on each other each may take the same edge for its own; the other edge is then
left over, and one of the strands belongs there.
"""

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from worm_msgs_py.arrays import Complex, Floats, Mask, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.curve import tangents
from worm_tracker.midline.largest_piece import largest_piece
from worm_tracker.midline.path import BodyPath, evenly


@dataclass(frozen=True, slots=True)
class StrandShiftSettings:
    """Which strands are moved, and how far."""

    reach_widths: float = 1.0
    """How far from a strand's axis something that is missing may be its."""
    most_shift_widths: float = 0.8
    smoothing_widths: float = 0.5
    """Scale along the body over which a shift fades out."""
    apart_widths: float = 1.5
    """Stretch along the body that parts two strands."""
    end_widths: float = 1.0
    """How much of the body's ends stays: they are laid anew in another way."""


def shifted_strands(
    path: BodyPath, wanted: Picture, width: float, settings: StrandShiftSettings
) -> list[BodyPath]:
    """Return paths, each with one strand moved to the largest piece that is missing.

    Parameters
    ----------
    path : BodyPath
        In the mask's coordinates.
    wanted : ndarray of uint8, shape (h, w)
        What of the object is missing in the body; not zero there.
    width : float
        The body's, pixels.
    settings : StrandShiftSettings
    """
    missing = largest_piece(wanted)
    if not len(missing):
        return []
    curve = path.curve
    reach_px = settings.reach_widths * width
    near = np.empty(len(curve), np.bool_)
    _tell_near(curve, missing, reach_px**2, near)
    end = round(settings.end_widths * width / path.step)
    near[:end] = near[len(near) - end :] = False
    nodes = np.flatnonzero(near)
    gaps = np.flatnonzero(np.diff(nodes) > settings.apart_widths * width / path.step)
    moved = []
    for run in np.split(nodes, gaps + 1):
        if not len(run):
            continue
        shift = _shift(curve, run, missing, width, settings)
        shift = gaussian_filter1d(shift, settings.smoothing_widths * width / path.step)
        line = curve + 1j * tangents(curve) * shift
        moved.append(BodyPath(evenly(line, len(line)), path.ways))
    return moved


@compiled_for(
    array_read(types.complex128),
    array_read(types.complex128),
    types.float64,
    array_written(types.boolean),
)
def _tell_near(curve: Complex, places: Complex, reach_px2: float, near: Mask) -> None:
    """Fill in of each node whether one of some places is nearer than a squared distance."""
    for node in range(len(curve)):
        near[node] = False
        for place in places:
            du, dv = curve[node].real - place.real, curve[node].imag - place.imag
            if du * du + dv * dv < reach_px2:
                near[node] = True
                break


@compiled_for(array_read(types.complex128), array_read(types.complex128), array_written(types.intp))
def _find_nearest(curve: Complex, places: Complex, nearest: NDArray[np.intp]) -> None:
    """Fill in the node of a curve that is nearest to each place."""
    for k in range(len(places)):
        least = np.inf
        for node in range(len(curve)):
            du, dv = curve[node].real - places[k].real, curve[node].imag - places[k].imag
            if du * du + dv * dv < least:
                nearest[k], least = node, du * du + dv * dv


def _shift(
    curve: Complex,
    run: NDArray[np.intp],
    missing: Complex,
    width: float,
    settings: StrandShiftSettings,
) -> Floats:
    """Return how far each node must move, to the left, for its edge to take in what is missing."""
    nearest = np.zeros(len(missing), np.intp)
    _find_nearest(curve[run], missing, nearest)
    nearest = run[nearest]
    beside = ((missing - curve[nearest]) * (1j * tangents(curve)[nearest]).conj()).real
    side = 1.0 if np.median(beside) > 0 else -1.0
    beyond = np.clip(side * beside - width / 2, 0.0, settings.most_shift_widths * width)
    shift = np.zeros(len(curve))
    np.maximum.at(shift, nearest, beyond)
    return side * shift
