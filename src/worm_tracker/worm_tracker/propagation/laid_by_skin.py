"""Lays an end of a body with marks anew where its skin is seen, and doubts one where it is not.

An end that is not sure is asked, and one that was thought to be sure where the body, drawn so in
its skin, is not what is seen. A pale end is not asked: it adds so little to what it lies on that it
was led widths away.
"""

from worm_tracker.midline.body_shade import BodyShade
from worm_tracker.midline.curve import median_of
from worm_tracker.midline.drawn_skin import SkinnedBody
from worm_tracker.midline.end_by_skin import EndInSkin
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_laid import (
    has_other_end_beside,
    known_end,
    with_end_sd,
    with_end_told,
)


def with_ends_by_skin(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body whose ends lie where the marks and the darkness of its skin say so.

    As they are where overlaps are no darker, or where it has no marks.
    """
    if scene.seen.dark is None or scene.seen.shaded is None:
        return found
    shade = scene.seen.shaded.shade
    for last_end in (False, True):
        if not scene.model.pale_ends[last_end]:
            found = _with_end_by_skin(scene, found, shade, last_end)
    return found


def _with_end_by_skin(
    scene: CandidateSearch, found: Candidate, shade: BodyShade, last_end: bool
) -> Candidate:
    """Return a body with an end where its skin says that it lies, unsure where it is not seen.

    It stays where the other end is beside it: either may be taken for the other.
    """
    in_skin = _end_in_skin(scene, found, shade, last_end)
    if in_skin is None:
        return found
    settings, width, known = scene.settings, scene.model.width, in_skin.picture.known
    by_skin, cost = settings.by_skin, in_skin.cost
    is_sure = known.sd_px < settings.least_end_sd_by_signal_widths * width
    is_asked = not is_sure or cost >= by_skin.most_cost_of_sure
    if is_asked and not has_other_end_beside(scene, found):
        end = in_skin.likeliest()
        most_px = settings.most_end_sd_in_darker_overlap_widths * width if is_sure else known.sd_px
        if end.sd_px <= most_px:
            found = with_end_told(scene, found, end, last_end)
            laid = _end_in_skin(scene, found, shade, last_end)
            cost = 0.0 if laid is None else laid.cost
    if cost < by_skin.least_cost_of_wrong:
        return found
    sd_px = max(found.end_sd_px[last_end], by_skin.sd_of_wrong_widths * width)
    return with_end_sd(found, sd_px, last_end)


def _end_in_skin(
    scene: CandidateSearch, found: Candidate, shade: BodyShade, last_end: bool
) -> EndInSkin | None:
    """Return an end that lies on the body, and the body from that end on; None of another one."""
    known = known_end(scene, found, last_end)
    if known is None:
        return None
    model, back = scene.model, -1 if last_end else 1
    path = found.path.turned_round() if last_end else found.path
    mean = (shade.turned_round() if last_end else shade).mean
    level, widths = median_of(scene.levels), model.widths[::back]
    body = SkinnedBody(path.curve, widths, mean, level, model.darkening)
    return EndInSkin.of(scene.signal, body, known, scene.settings.by_skin)
