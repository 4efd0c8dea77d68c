"""What lies beside the ends of a body that it does not explain: such an end lies elsewhere."""

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.body_residual import ObjectMasks, part_near, px2_near
from worm_tracker.midline.curve import median_of, unit_grid
from worm_tracker.midline.drawn_signal import BodySignal
from worm_tracker.midline.end_residual import end_over_limits
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.self_cover import ends_on_body
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_sureness import half_widths_along
from worm_tracker.propagation.propagation_settings import PropagationSettings


def ends_lack(
    found: Candidate, seen: ObjectMasks, width: float, settings: PropagationSettings
) -> tuple[bool, bool]:
    """Tell of each end whether it lies on the body and something of the object is missing there.

    Told where overlaps are darker: marks of a skin look like them.

    Parameters
    ----------
    found : Candidate
    seen : ObjectMasks
        The object.
    width : float
        The body's, pixels.
    settings : PropagationSettings
    """
    if seen.dark is None or seen.shaded is not None:
        return False, False
    near = settings.near_end_widths * width
    on_body = ends_on_body(found.path.curve, near, found.path.step)
    reach = settings.missing_at_end_widths * width
    most = settings.most_missing_at_end_widths2 * width**2
    first, last = (
        on and found.unexplained.missing_px2(point, reach) > most
        for on, point in zip(on_body, found.path.points[[0, -1]], strict=True)
    )
    return first, last


def end_over_limits_at(
    signal: Picture,
    path: BodyPath,
    place: complex,
    seen: ObjectMasks,
    model: BodyModel,
    levels: Floats,
    settings: PropagationSettings,
) -> float:
    """Return how many times what may be darker or paler than a body near a place is.

    0 where marks are, which look like that, and where overlaps are no darker: the outline alone
    tells there.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    path : BodyPath
        The body in the window's coordinates.
    place : complex
        u + iv.
    seen : ObjectMasks
        The object.
    model : BodyModel
    levels : ndarray, shape (TRACKED_POINTS,)
        The body's signal along it in a picture of this brightness.
    settings : PropagationSettings
    """
    if seen.dark is None or seen.shaded is not None:
        return 0.0
    return end_over_limits(signal, body_signal(path, model, levels), place, settings.end_residual)


def body_signal(path: BodyPath, model: BodyModel, levels: Floats) -> BodySignal:
    """Return a body in a picture of some brightness, in the path's order.

    Parameters
    ----------
    path : BodyPath
    model : BodyModel
    levels : ndarray, shape (TRACKED_POINTS,)
        The body's signal along it.
    """
    part, known = unit_grid(len(path.curve)), unit_grid(len(levels))
    return BodySignal(
        path.curve,
        2 * half_widths_along(path, model),
        model.width,
        median_of(levels),
        np.interp(part, known, levels),
        model.darkening,
    )


def broad_ends(
    found: Candidate, signal: Picture, levels: Floats, width: float, settings: PropagationSettings
) -> tuple[bool, bool]:
    """Tell of each end whether the object is broader there than the body is.

    An end that is bent back onto its own flank makes it so, and the bend is taken for the end. It
    is as dark as the body; a pale rim of a skin, which looks alike, is not.

    Parameters
    ----------
    found : Candidate
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    levels : ndarray, shape (TRACKED_POINTS,)
        The body's signal along it in a picture of this brightness.
    width : float
        The body's, pixels.
    settings : PropagationSettings
    """
    reach, most = settings.broad_end_widths * width, settings.most_beside_end_widths2 * width**2
    least = settings.least_beside_over_body_level * median_of(levels)
    beside, ends = found.unexplained.beside.copy(), found.path.points[[0, -1]]
    for point in ends:
        part = part_near(point, reach)
        beside[part][signal[part] < least] = 0
    first, last = (px2_near(beside, point, reach) > most for point in ends)
    return first, last
