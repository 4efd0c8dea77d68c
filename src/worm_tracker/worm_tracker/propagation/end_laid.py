"""Lays an end of a body that lies on it where the picture says that it is likeliest."""

from dataclasses import replace

from worm_msgs_py.arrays import Complex
from worm_tracker.midline.curve import complex_arc_length
from worm_tracker.midline.likeliest_end import KnownEnd, LikeliestEnd
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.self_cover import ends_on_body, lies_near_itself
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate


def known_end(scene: CandidateSearch, found: Candidate, last_end: bool) -> KnownEnd | None:
    """Return what is known of an end; None where it does not lie on the body.

    Nor where the other end is: what is seen of one may be the other.
    """
    model, curve = scene.model, found.path.curve
    near_px = scene.settings.near_end_widths * model.width
    on_body = ends_on_body(curve, near_px, found.path.step)[last_end]
    if not on_body or abs(curve[0] - curve[-1]) < near_px:
        return None
    place, sd = complex(curve[-1 if last_end else 0]), found.end_sd_px[last_end]
    return KnownEnd(place, sd, model.width, model.length, scene.length_scatter_px)


def has_other_end_beside(scene: CandidateSearch, found: Candidate) -> bool:
    """Tell whether a body's ends lie so near to each other that either may be taken for the other.

    As they are seen in what is compared of the picture about an end.
    """
    first, last = found.path.curve[[0, -1]]
    reach_widths = scene.settings.by_signal.compared.reach_widths
    return bool(abs(first - last) < reach_widths * scene.model.width)


def with_end_told(
    scene: CandidateSearch, found: Candidate, end: LikeliestEnd, last_end: bool
) -> Candidate:
    """Return a body with an end laid where it is told to lie, and as sure as that.

    As it is where it cannot lie so.
    """
    if end.curve is not None:
        laid = with_end_laid(scene, found, end.curve, last_end)
        if laid is None:
            return found
        found = laid
    return with_end_sd(found, end.sd_px, last_end)


def with_end_sd(found: Candidate, sd_px: float, last_end: bool) -> Candidate:
    """Return a body with an end that is so sure."""
    first, last = found.end_sd_px
    return replace(found, end_sd_px=(first, sd_px) if last_end else (sd_px, last))


def with_end_laid(
    scene: CandidateSearch, found: Candidate, curve: Complex, last_end: bool
) -> Candidate | None:
    """Return a body that lies so from one of its ends on; None where that leaves more over.

    Or where it would lie on itself no more: an end in clear water is sought by other means.
    """
    model, settings = scene.model, scene.settings
    line = evenly(curve, nodes_for(float(complex_arc_length(curve)[-1]), model.width))
    path = BodyPath(line[::-1] if last_end else line, found.path.ways)
    anew = scene.scored(path, model.widths)
    more = anew.unexplained.total - found.unexplained.total
    if more > settings.most_lost_by_likelier_end_widths2:
        return None
    if not lies_near_itself(path.curve, model.width, path.step):
        return None
    return replace(
        anew,
        end_sd_px=found.end_sd_px,
        straighter=found.straighter,
        was_exchanged=found.was_exchanged,
    )
