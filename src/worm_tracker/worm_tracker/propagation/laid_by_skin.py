"""Lays an end of a body with marks anew where its skin is seen, and doubts one where it is not.

An end that is not sure is asked, and one that was thought to be sure where the body, drawn so in
its skin, is not what is seen. A pale end is not asked: it adds so little to what it lies on that it
was led widths away.
"""

from worm_tracker.midline.body_shade import BodyShade
from worm_tracker.midline.curve import median_of
from worm_tracker.midline.drawn_skin import SkinnedBody
from worm_tracker.midline.end_by_skin import EndInSkin
from worm_tracker.midline.likeliest_end import KnownEnd
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
        found = _with_likeliest_end_in_skin(scene, found, shade, last_end)
        found = _as_sure_as_seen(scene, found, shade, last_end)
    return found


def _with_likeliest_end_in_skin(
    scene: CandidateSearch, found: Candidate, shade: BodyShade, last_end: bool
) -> Candidate:
    """Return a body with an end where its skin says that it lies; as it is where that is no more.

    Where the other end is beside it, either may be taken for the other.
    """
    known, settings, width = known_end(scene, found, last_end), scene.settings, scene.model.width
    if known is None or has_other_end_beside(scene, found):
        return found
    if scene.model.pale_ends[last_end]:
        return found
    in_skin = _end_in_skin(scene, found, shade, known, last_end)
    is_sure = known.sd_px < settings.least_end_sd_by_signal_widths * width
    if is_sure and in_skin.cost < settings.by_skin.most_cost_of_sure:
        return found
    end = in_skin.likeliest()
    most_px = settings.most_end_sd_in_darker_overlap_widths * width if is_sure else known.sd_px
    return found if end.sd_px > most_px else with_end_told(scene, found, end, last_end)


def _as_sure_as_seen(
    scene: CandidateSearch, found: Candidate, shade: BodyShade, last_end: bool
) -> Candidate:
    """Return a body whose end is unsure where it is not seen as it is said to lie."""
    known = known_end(scene, found, last_end)
    if known is None or scene.model.pale_ends[last_end]:
        return found
    in_skin = _end_in_skin(scene, found, shade, known, last_end)
    if in_skin.cost < scene.settings.by_skin.least_cost_of_wrong:
        return found
    sd_px = scene.settings.by_skin.sd_of_wrong_widths * scene.model.width
    return with_end_sd(found, max(known.sd_px, sd_px), last_end)


def _end_in_skin(
    scene: CandidateSearch, found: Candidate, shade: BodyShade, known: KnownEnd, last_end: bool
) -> EndInSkin:
    """Return an end of a body, and the body from that end on."""
    model, back = scene.model, -1 if last_end else 1
    path = found.path.turned_round() if last_end else found.path
    mean = (shade.turned_round() if last_end else shade).mean
    level, widths = median_of(scene.levels), model.widths[::back]
    body = SkinnedBody(path.curve, widths, mean, level, model.darkening)
    return EndInSkin.of(scene.signal, body, known, scene.settings.by_skin)
