"""How much darker or paler a picture is beside the ends of a body than that body makes it.

An end that is thin lies along another strand unseen by any outline: where it is said to end too
soon, or the strand that it lies on is taken to bend about it, a sliver is left over that is paler
than half of the body, or narrower than its rim. Drawn as dark as the body is and as blurred as a
lens makes it, the body leaves a signal over there; or lacks one, where it is said to end too late.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Floats32, Picture
from worm_tracker.midline.drawn_signal import BodySignal, SignalDrawingSettings, expected_signal


@dataclass(frozen=True, slots=True)
class EndResidualSettings:
    """How a body is drawn, and what of the picture is darker or paler than that."""

    reach_widths: float = 2.0
    """How far from an end something that is darker or paler is its."""
    beyond_reach_widths: float = 0.3
    """How much more of the picture is drawn: what is blurred comes from there."""
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
    drawing: SignalDrawingSettings = field(default_factory=SignalDrawingSettings)


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
    reach_widths = settings.reach_widths + settings.beyond_reach_widths
    seen, corner = _seen_about(signal, body, np.array([end]), reach_widths)
    if not seen.size:
        return 0.0
    at = end - corner
    widths = body.widths - settings.narrower_px
    darker = seen - expected_signal(seen.shape, corner, body, widths, True, settings.drawing)
    of_signal = body.widths * np.minimum(body.levels / body.level, 1.0)
    widths = of_signal - settings.pale_narrower_px
    paler = expected_signal(seen.shape, corner, body, widths, False, settings.drawing) - seen
    return max(
        _area(darker, at, body.width, settings) / settings.most_darker_widths2,
        _area(paler, at, body.width, settings) / settings.most_paler_widths2,
    )


def differing_near(
    signal: Picture, body: BodySignal, places: Complex, settings: EndResidualSettings
) -> float:
    """Return by how much a picture differs from a body near some places, squared widths.

    The sum of what is darker or paler by more than noise makes it, over the body's signal.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    body : BodySignal
        In the signal's coordinates.
    places : ndarray of complex, shape (n,)
        u + iv. All of the picture about them is compared.
    settings : EndResidualSettings
    """
    seen, corner = _seen_about(signal, body, places, settings.reach_widths)
    if not seen.size:
        return 0.0
    drawn = expected_signal(seen.shape, corner, body, body.widths, False, settings.drawing)
    differing = np.abs(_smoothed(seen - drawn, body.width, settings)) - settings.least_over_level
    return float(differing[differing > 0].sum()) / body.width**2


def _seen_about(
    signal: Picture, body: BodySignal, places: Complex, reach_widths: float
) -> tuple[Floats32, complex]:
    """Return the signal about some places, over the body's, and where that window begins."""
    half = int(reach_widths * body.width)
    u0, v0 = (max(int(part.min()) - half, 0) for part in (places.real, places.imag))
    u1, v1 = (int(part.max()) + half + 1 for part in (places.real, places.imag))
    return signal[v0:v1, u0:u1] * np.float32(1 / body.level), complex(u0, v0)


def _smoothed(more: Floats32, width: float, settings: EndResidualSettings) -> Floats32:
    smooth = cv2.GaussianBlur(more, (0, 0), settings.smoothing_widths * width)
    return np.asarray(smooth, np.float32)


def _area(more: Floats32, at: complex, width: float, settings: EndResidualSettings) -> float:
    """Return the largest connected area near a place in which more is seen, squared widths."""
    smooth = _smoothed(more, width, settings)
    near = np.zeros(more.shape, np.uint8)
    middle, reach = (round(at.real), round(at.imag)), round(settings.reach_widths * width)
    cv2.circle(near, middle, reach, 1, cv2.FILLED)
    near[smooth <= settings.least_over_level] = 0
    _, _, stats, _ = cv2.connectedComponentsWithStats(near, connectivity=8)
    return float(stats[1:, cv2.CC_STAT_AREA].max(initial=0)) / width**2
