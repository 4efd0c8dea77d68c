"""How much darker or paler a picture is beside an end of a body than that body makes it.

An end that is thin lies along another strand unseen by any outline: where it is said to end too
soon, or the strand that it lies on is taken to bend about it, a sliver is left over that is paler
than half of the body, or narrower than its rim. Drawn as dark as the body is and as blurred as a
lens makes it, the body leaves a signal over there; or lacks one, where it is said to end too late.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_strands


@dataclass(frozen=True, slots=True)
class EndResidualSettings:
    """How a body is drawn, and what of the picture is darker or paler than that."""

    reach_widths: float = 2.0
    """How far from an end something that is darker or paler is its."""
    beyond_reach_widths: float = 0.3
    """How much more of the picture is drawn: what is blurred comes from there."""
    blur_widths: float = 0.08
    narrower_px: float = 1.25
    """How blurred a body is drawn, and how much narrower: each pixel that it touches is drawn."""
    smoothing_widths: float = 0.15
    """Scale over which differences are averaged: noise and edges are finer."""
    least_over_level: float = 0.15
    """Part of the body's signal from which on a place is darker, or paler."""
    most_darker_widths2: float = 0.45
    most_paler_widths2: float = 0.3
    """Area that may be, connected, squared widths."""
    drawing: StrandDrawingSettings = field(default_factory=StrandDrawingSettings)


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
        Its signal, grey levels.
    darkening : float
        How much darker two parts are that lie on each other than one, relatively.
    """

    curve: Complex
    widths: Floats
    width: float
    level: float
    darkening: float


def end_over_limits(
    signal: Picture, body: BodySignal, end: complex, settings: EndResidualSettings
) -> float:
    """Return how many times what may be darker or paler than a body near its end is.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    body : BodySignal
        In the signal's coordinates.
    end : complex
        Where it ends, u + iv.
    settings : EndResidualSettings

    Notes
    -----
    Strands that lie beside each other at a hairpin may be darker there or not.
    """
    half = int((settings.reach_widths + settings.beyond_reach_widths) * body.width)
    u0, v0 = max(int(end.real) - half, 0), max(int(end.imag) - half, 0)
    part = signal[v0 : int(end.imag) + half + 1, u0 : int(end.real) + half + 1]
    if not part.size:
        return 0.0
    at = end - complex(u0, v0)
    line, widths = as_points(body.curve - complex(u0, v0)), body.widths - settings.narrower_px
    drawn, twice, layered = drawn_strands(part.shape, line, widths, body.width, settings.drawing)
    seen = part * np.float32(1 / body.level)
    darker = _area(seen - _expected(drawn, twice, body, settings), at, body.width, settings)
    paler = _area(_expected(drawn, layered, body, settings) - seen, at, body.width, settings)
    return max(darker / settings.most_darker_widths2, paler / settings.most_paler_widths2)


def _expected(
    drawn: Picture, dark: Picture, body: BodySignal, settings: EndResidualSettings
) -> Floats32:
    """Return the signal of a body over its level, from where it is and where it is darker."""
    sharp = (drawn + np.float32(body.darkening) * dark) * np.float32(1 / 255)
    blurred = cv2.GaussianBlur(sharp, (0, 0), settings.blur_widths * body.width)
    return np.asarray(blurred, np.float32)


def _area(more: Floats32, at: complex, width: float, settings: EndResidualSettings) -> float:
    """Return the largest connected area near a place in which more is seen, squared widths."""
    smooth = cv2.GaussianBlur(more, (0, 0), settings.smoothing_widths * width)
    near = np.zeros(more.shape, np.uint8)
    middle, reach = (round(at.real), round(at.imag)), round(settings.reach_widths * width)
    cv2.circle(near, middle, reach, 1, cv2.FILLED)
    near[smooth <= settings.least_over_level] = 0
    _, _, stats, _ = cv2.connectedComponentsWithStats(near, connectivity=8)
    return float(stats[1:, cv2.CC_STAT_AREA].max(initial=0)) / width**2
