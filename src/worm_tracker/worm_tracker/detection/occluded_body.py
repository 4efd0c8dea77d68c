"""What may be said of a worm of which a part was hidden."""

from dataclasses import replace

import numpy as np

from worm_msgs_py.status import Status
from worm_tracker.body_model import Known
from worm_tracker.detection.detector import Sight
from worm_tracker.midline.contour_midline import arc_length
from worm_tracker.midline.refine import Fine
from worm_tracker.observation import Observation

BRIDGED_DOUBT = 0.9
"""What a hidden part leaves of the confidence."""


def hidden_in(found: Observation, sight: Sight) -> Observation:
    """Return an observation that says which part of its midline was not seen.

    Parameters
    ----------
    found : Observation
        Made from a sight into which what is hidden was drawn.
    sight : Sight
    """
    joined = sight.joined
    if joined is None or not len(found.points):
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


def of_known_width(fine: Fine, sight: Sight, known: Known | None) -> Fine:
    """Return a body that is as wide in glare as it is known to be, or as it is elsewhere.

    Parameters
    ----------
    fine : Fine
        Points and widths in the order of those that are known.
    sight : Sight
    known : Known or None
        None where nothing is known yet.
    """
    if sight.zone is None:
        return fine
    zone, offset = sight.zone, (sight.window[1].start, sight.window[0].start)
    u, v = np.rint(fine.points - offset).astype(int).T
    inside = zone[v.clip(0, zone.shape[0] - 1), u.clip(0, zone.shape[1] - 1)] > 0
    if not inside.any() or inside.all():
        return fine
    usual = np.median(fine.widths[~inside]) if known is None else known.widths
    widths = np.where(inside, usual, fine.widths)
    more = (widths - fine.widths) * np.gradient(arc_length(fine.points))
    area = fine.area + float(more.sum())
    u0, v0 = (fine.area * np.array([fine.u, fine.v]) + more @ fine.points) / area
    return replace(fine, widths=widths, area=area, u=float(u0), v=float(v0))
