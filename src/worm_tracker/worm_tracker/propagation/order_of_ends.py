"""How well a body in an object tells that its ends are in the order of those known."""

from math import copysign

from worm_msgs_py.arrays import Picture
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.order_by_widths import order_score
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.way_by_marks import MarksOnPath, WayByMarksSettings


def score_by_marks_or_widths(
    path: BodyPath,
    mask: Picture,
    model: BodyModel,
    marks: MarksOnPath | None,
    settings: WayByMarksSettings,
) -> float:
    """Return how well a body tells that its ends are in the right order, -1 to 1.

    By its marks where these tell, else by its widths.

    Parameters
    ----------
    path : BodyPath
        Where it lies, in the mask's coordinates.
    mask : ndarray of uint8, shape (h, w)
        The object.
    model : BodyModel
        The worm.
    marks : MarksOnPath or None
        What is seen of a skin's marks along it; None where none are known.
    settings : WayByMarksSettings
    """
    odds = 0.0 if marks is None else marks.log_odds()
    if abs(odds) > settings.least_log_odds:
        return copysign(1.0, odds)
    return score_by_widths(path, mask, model)


def score_by_widths(
    path: BodyPath,
    mask: Picture,
    model: BodyModel,
    untold: tuple[float, float] | None = None,
) -> float:
    """Return the same by a body's widths; but for a part of its length, from where to where."""
    if not model.tells_order:
        return 0.0
    return order_score(mask, path.points, model.widths, model.settings.order, untold)
