"""What may be said of a worm of which a part was hidden."""

from dataclasses import replace

import numpy as np

from worm_msgs_py.status import Status
from worm_tracker.finding import Sight
from worm_tracker.known import Known
from worm_tracker.observation import Observation
from worm_tracker.outline import Floats, arc_length
from worm_tracker.segmentation import Picture

BRIDGED_DOUBT = 0.9
"""What a hidden part leaves of the confidence."""


def hidden_in(found: Observation, sight: Sight, known: Known | None) -> Observation:
    """Return an observation that says which part of its midline was not seen.

    Parameters
    ----------
    found : Observation
        Made from a sight into which what is hidden was drawn.
    sight : Sight
    known : Known or None
        The worm, its widths in the order of the midline.
    """
    joined = sight.joined
    if not len(found.points):
        return found
    if sight.zone is not None and known is not None:
        found = _of_known_width(found, sight, sight.zone, known.widths)
    if joined is None:
        return found
    confidence = BRIDGED_DOUBT * found.confidence
    if not any(joined.hidden):
        return replace(found, status=Status.BRIDGED, confidence=confidence)
    ends = joined.ends + np.array([sight.window[1].start, sight.window[0].start])
    straight = np.hypot(*(found.points[[0, -1]] - ends).T).sum()
    turned = np.hypot(*(found.points[[-1, 0]] - ends).T).sum()
    (first, last), at = joined.hidden, ends
    if turned < straight:
        first, last, at = last, first, ends[::-1]
    upto = [int(np.hypot(*(found.points - end).T).argmin()) for end in at]
    count = len(found.points)
    hidden = (upto[0] + 1 if first else 0, count - upto[1] if last else 0)
    return replace(found, status=Status.END_HIDDEN, confidence=confidence, hidden=hidden)


def _of_known_width(found: Observation, sight: Sight, zone: Picture, widths: Floats) -> Observation:
    """Return an observation whose body is as wide in a zone as it is known to be elsewhere."""
    u, v = (found.points - (sight.window[1].start, sight.window[0].start)).round().astype(int).T
    inside = zone[v.clip(0, zone.shape[0] - 1), u.clip(0, zone.shape[1] - 1)] > 0
    if not inside.any():
        return found
    step = np.gradient(arc_length(found.points))
    more = np.where(inside, widths - found.widths, 0.0) * step
    area = float((found.widths * step).sum())
    centre = (area * np.array([found.u, found.v]) + more @ found.points) / (area + more.sum())
    mended = np.where(inside, widths, found.widths)
    return replace(found, u=float(centre[0]), v=float(centre[1]), widths=mended)
