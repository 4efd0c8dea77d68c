"""How much darker two parts of a marked body are where they lie on each other.

The marks of a skin are darker than some of its overlaps, so that the darkest places do not tell.
But where the body was followed through a fold it is known which parts lie on each other, and what
either of them looks like alone.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Mask, Picture
from worm_tracker.midline.curve import as_points, unit_grid
from worm_tracker.midline.drawn_skin import SkinnedBody, dim_by_body
from worm_tracker.midline.rounded_widths import rounded_half_widths

_EITHER = 0.5, 0.9
"""Two darkenings: how an overlap looks is told for any from how it looks for both."""


@dataclass(frozen=True, slots=True)
class OverlapDarkeningSettings:
    """Which places of a body tell."""

    broader_px: float = 0.5
    """How much broader the body is drawn than it is."""
    least_layers: float = 1.8
    """From how many layers on, those cut by a pixel's edge counted in part, a pixel tells."""
    edge_widths: float = 0.2
    """How much of an overlap's edge does not tell: strands that lie side by side are drawn so far
    over each other where they are laid a little too near."""
    end_widths: float = 1.5
    """How far about either end nothing tells: it may lie elsewhere."""
    least_overlap_widths2: float = 0.2
    most_cost: float = 0.01
    """How much of the body lies on itself at least, squared widths, and how far the picture may be
    from the body there, mean square over the body's signal: of a body that lies otherwise it is
    0.04. Of 4189 bodies with more (nine films in skins) 3588 tell it, 94 % of these to 0.1."""


def overlap_darkening(
    signal: Picture, body: SkinnedBody, width: float, settings: OverlapDarkeningSettings
) -> float | None:
    """Return what a part of a body adds to the signal of one that it lies on, over its own.

    That which fits best all of its overlaps: two thirds where transmissions multiply and a layer
    takes away a third of the light, nothing where overlaps are no darker.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window, without the noise of single pixels.
    body : SkinnedBody
        In the window's coordinates; how dark its overlaps are is not asked of it.
    width : float
        That of most of it, pixels.
    settings : OverlapDarkeningSettings

    Returns
    -------
    float or None
        None where too little of the body lies on itself, or where the picture does not look like
        it however dark overlaps are.

    Notes
    -----
    Two layers have the signals a and b alone, and a + b - a b / m together, where m is the signal
    of what lets no light through: linear in 1 / m, which least squares give. Drawn for two m they
    tell a + b (`total`) and a b (`product`) of each pixel.
    """
    tells = _overlaps(body, signal.shape, width, settings)
    if np.count_nonzero(tells) < settings.least_overlap_widths2 * width**2:
        return None
    seen = signal[tells] / body.level
    bodies = [replace(body, darkening=darkening) for darkening in _EITHER]
    drawn, other_drawn = (_signal_at(tells, each, settings) for each in bodies)
    per_m, other_per_m = (each.level / each.blackest for each in bodies)
    product = (other_drawn - drawn) / (per_m - other_per_m)
    total = drawn + per_m * product
    fitted = float(np.vdot(product, total - seen) / max(float(np.vdot(product, product)), 1e-9))
    fitted = min(max(fitted, 0.0), 1.0)
    cost = float(np.mean((total - fitted * product - seen) ** 2))
    return None if cost > settings.most_cost else 1 - fitted


def _overlaps(
    body: SkinnedBody, shape: tuple[int, ...], width: float, settings: OverlapDarkeningSettings
) -> Mask:
    """Return the pixels in which a body lies on itself, those near its ends left out."""
    half = np.full((len(body.curve), body.mean.shape[1]), 0.5)
    layers = np.log2(1 / _through(body, half, shape, settings))
    over = (layers > settings.least_layers).astype(np.uint8)
    for u, v in as_points(body.curve[[0, -1]]).round().astype(int).tolist():
        cv2.circle(over, (u, v), round(settings.end_widths * width), 0, cv2.FILLED)
    edge_px = max(round(settings.edge_widths * width), 1)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * edge_px + 1, 2 * edge_px + 1))
    return np.asarray(cv2.erode(over, kernel) > 0)


def _signal_at(tells: Mask, body: SkinnedBody, settings: OverlapDarkeningSettings) -> Floats:
    """Return the signal of a body in its skin at some pixels, over that of most of it."""
    skin = body.absorbed(unit_grid(len(body.curve)))
    return (1 - _through(body, skin, tells.shape, settings)[tells]) / (body.level / body.blackest)


def _through(
    body: SkinnedBody,
    absorbed: Floats,
    shape: tuple[int, ...],
    settings: OverlapDarkeningSettings,
) -> Floats:
    """Return the part of the light that a body lets through that keeps so much at its nodes."""
    through, n = np.ones(shape), len(body.curve)
    half = rounded_half_widths(unit_grid(n), body.widths) + settings.broader_px / 2
    dim_by_body(through, body.curve, half, absorbed, (False, False))
    return through
