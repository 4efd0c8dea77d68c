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
    """How blurred a body is drawn."""
    narrower_px: float = 1.0
    pale_narrower_px: float = 0.5
    """How much narrower it is drawn: each pixel that it touches is. And where it is asked what is
    paler: there a place that is pale, as a thin end is that a lens blurs, is narrower by as much as
    it is paler than the rest."""
    smoothing_widths: float = 0.15
    """Scale over which differences are averaged: noise and edges are finer."""
    least_over_level: float = 0.15
    """Part of the body's signal from which on a place is darker, or paler."""
    most_darker_widths2: float = 0.35
    most_paler_widths2: float = 0.15
    """Connected area that may be, squared widths: of 143 ends on the body beside which more was, in
    seven films, 38 were more than 0.6 widths off, of 841 others 17."""
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
    at, corner = end - complex(u0, v0), complex(u0, v0)
    seen = part * np.float32(1 / body.level)
    widths = body.widths - settings.narrower_px
    darker = seen - _expected_signal(part.shape, corner, body, widths, True, settings)
    of_signal = body.widths * np.minimum(body.levels / body.level, 1.0)
    widths = of_signal - settings.pale_narrower_px
    paler = _expected_signal(part.shape, corner, body, widths, False, settings) - seen
    return max(
        _area(darker, at, body.width, settings) / settings.most_darker_widths2,
        _area(paler, at, body.width, settings) / settings.most_paler_widths2,
    )


def _expected_signal(
    shape: tuple[int, ...],
    corner: complex,
    body: BodySignal,
    widths: Floats,
    is_dark_beside: bool,
    settings: EndResidualSettings,
) -> Floats32:
    """Return the signal of a body over its level, drawn with some widths.

    It is darker where it lies on itself, and, where that is said, beside itself at a hairpin. Each
    strand lets the same part of the light through: a third adds as much of what the second adds as
    that adds of the first.
    """
    line = as_points(body.curve - corner)
    drawn = drawn_strands(shape, line, widths, body.width, settings.drawing)
    dark = drawn.twice if is_dark_beside else drawn.layered
    second, third = np.float32(body.darkening), np.float32(body.darkening**2)
    sharp = (drawn.body + second * dark + third * drawn.thrice) * np.float32(1 / 255)
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
