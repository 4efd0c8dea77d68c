"""Draws the signal of a body in a picture: where it is, and darker where it lies on itself."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numba import types

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled_for
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_strands


@dataclass(frozen=True, slots=True)
class SignalDrawingSettings:
    """How a body is drawn."""

    blur_widths: float = 0.08
    """How blurred."""
    finer: int = 1
    """How many times as fine as the picture it is drawn first."""
    strands: StrandDrawingSettings = field(default_factory=StrandDrawingSettings)


@dataclass(frozen=True, eq=False, slots=True)
class BodySignal:
    """A body in a picture, and how dark it is.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,)
        Its midline, u + iv.
    widths : ndarray, shape (n,)
        Its width there, pixels.
    width : float
        That of most of it, pixels.
    level : float
        Signal of most of it, grey levels.
    levels : ndarray, shape (n,)
        Its signal there.
    darkening : float
        How much darker two parts are that lie on each other than one, relatively.
    """

    curve: Complex
    widths: Floats
    width: float
    level: float
    levels: Floats
    darkening: float


def expected_signal(
    shape: tuple[int, ...],
    corner: complex,
    body: BodySignal,
    widths: Floats,
    is_dark_beside: bool,
    settings: SignalDrawingSettings,
) -> Floats32:
    """Return the signal of a body over its level, drawn with some widths, in a window.

    It is darker where it lies on itself, and, where that is said, beside itself at a hairpin. Each
    strand lets the same part of the light through: a third adds as much of what the second adds as
    that adds of the first.

    Parameters
    ----------
    shape : tuple of int
        Height and width of the window, pixels.
    corner : complex
        Where it begins, u + iv.
    body : BodySignal
    widths : ndarray, shape (n,)
        At each node of its midline, pixels.
    is_dark_beside : bool
    settings : SignalDrawingSettings
    """
    finer, half_px = settings.finer, 0.5 + 0.5j
    line = as_points((body.curve - corner + half_px) * finer - half_px)
    fine = shape[0] * finer, shape[1] * finer
    drawn = drawn_strands(fine, line, finer * widths, finer * body.width, settings.strands)
    dark = drawn.twice if is_dark_beside else drawn.layered
    sharp = np.empty(fine, np.float32)
    _fill_signal(drawn.body, dark, drawn.thrice, body.darkening, body.darkening**2, sharp)
    if finer > 1:
        coarse = cv2.resize(sharp, shape[::-1], interpolation=cv2.INTER_AREA)
        sharp = np.asarray(coarse, np.float32)
    blurred = cv2.GaussianBlur(sharp, (0, 0), settings.blur_widths * body.width)
    return np.asarray(blurred, np.float32)


@compiled_for(
    array_read(types.uint8, 2),
    array_read(types.uint8, 2),
    array_read(types.uint8, 2),
    types.float32,
    types.float32,
    array_written(types.float32, 2),
)
def _fill_signal(
    body: Picture, twice: Picture, thrice: Picture, second: float, third: float, signal: Floats32
) -> None:
    """Fill in the signal of a body where it lies once, twice and thrice: 255 in a mask each."""
    height, width = signal.shape
    for v in range(height):
        for u in range(width):
            layers = np.float32(body[v, u]) + second * np.float32(twice[v, u])
            layers += third * np.float32(thrice[v, u])
            signal[v, u] = layers * np.float32(1 / 255)
