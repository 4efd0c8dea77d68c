"""Lays a body anew that was slid along itself: its strands, its bends and its ends.

Where something is left over, where two strands that meet are straighter the other way round, and
where the outline tells that an end lies otherwise.
"""

from dataclasses import replace
from math import inf

import numpy as np

from worm_tracker.midline.body_model import end_displacement
from worm_tracker.midline.end_residual import differing_near
from worm_tracker.midline.other_ends import likelier_end, other_ends
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.regrown_ends import regrown
from worm_tracker.midline.self_cover import ends_on_body
from worm_tracker.midline.strand_exchange import exchanged_strands
from worm_tracker.midline.strand_shift import shifted_strands
from worm_tracker.propagation.beside_ends import body_signal
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_sureness import end_sd_px_of, half_widths_along, most_end_sd_px
from worm_tracker.propagation.laid_by_flanks import with_ends_by_flanks
from worm_tracker.propagation.loops_in_doubt import turns_known_loop


def followed_body(scene: CandidateSearch) -> Candidate | None:
    """Return the last body slid along itself, its strands, bends and ends laid anew."""
    found = scene.slid(scene.last)
    if found is None:
        return None
    if scene.over_limits(found) > 1 or any(scene.ends_lack(found)):
        found = _slid_again(scene, _with_missing_parts(scene, found))
    found = _with_likelier_ends(scene, with_ends_by_flanks(scene, found))
    return with_strands_exchanged(scene, found)


def _slid_again(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body slid along the way that was laid anew for it, while that explains more.

    A bend that has moved on by more than a slide finds is laid at most part of the way there. Where
    overlaps are no darker a body that is lost may lie along any strand, and would be led on; marks
    look like overlaps, so that a body with marks must leave more.
    """
    settings, ways = scene.settings, found.path.ways
    least = settings.least_over_limits_slid_again
    if scene.seen.shaded is not None:
        least = settings.least_over_limits_of_marked_slid_again
    if scene.seen.dark is None or scene.over_limits(found) < least:
        return found
    for _ in range(settings.most_slides_again):
        slid = scene.slid(BodyPath(found.path.curve))
        slid = slid and _with_missing_parts(scene, slid)
        if slid is None or slid.unexplained.total >= found.unexplained.total:
            break
        found = replace(slid, path=replace(slid.path, ways=ways))
        if scene.over_limits(found) <= 1:
            break
    return found


def _with_likelier_ends(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body each end of which lies where its outline is explained best.

    Where overlaps are no darker a path that leads an end over the body is not told from others: an
    end that has turned aside unseen shows itself by its outline alone. Where flanks fit the outline
    they tell more, and it stays; so it does where grey levels show that it is where it was: an
    outline closes the narrow gap between an end and the strand beside it.
    """
    if scene.seen.dark is not None:
        return found
    near_px = scene.settings.near_end_widths * scene.model.width
    for last_end in (False, True):
        on_body = ends_on_body(found.path.curve, near_px, found.path.step)[last_end]
        if not on_body or found.flanks_sd_px[last_end] < inf:
            continue
        path = _with_likelier_end(scene, found.path, last_end)
        if path is None:
            continue
        anew = scene.scored(path, scene.model.widths)
        more = anew.unexplained.total - found.unexplained.total
        explains_as_much = more <= scene.settings.most_lost_by_likelier_end_widths2
        if explains_as_much and not _is_contradicted(scene, found.path, path, last_end):
            sd_px, by_flanks = found.end_sd_px, found.flanks_sd_px
            found = replace(anew, end_sd_px=sd_px, flanks_sd_px=by_flanks)
    return found


def _with_likelier_end(scene: CandidateSearch, path: BodyPath, last_end: bool) -> BodyPath | None:
    """Return a path one end of which lies where it is likelier; None where nowhere else is."""
    model, settings = scene.model, scene.settings
    curve, half = path.curve, half_widths_along(path, model)
    if last_end:
        curve, half = curve[::-1], half[::-1]
    drawing, places = settings.residual.drawing, settings.other_ends
    others = other_ends(scene.seen.mask, curve, half, model.width, drawing, places)
    line = likelier_end(others, curve, model.width, places)
    if line is None:
        return None
    return BodyPath(line[::-1] if last_end else line, path.ways)


def _is_contradicted(
    scene: CandidateSearch, path: BodyPath, otherwise: BodyPath, last_end: bool
) -> bool:
    """Tell whether an end is seen where it lies, and not where it is laid otherwise.

    Where the picture does not look like the body as it lies, either, grey levels tell nothing.
    """
    settings = scene.settings
    ends = np.array([each.curve[-1 if last_end else 0] for each in (path, otherwise)])
    before, after = (
        differing_near(
            scene.signal,
            body_signal(each, scene.model, scene.levels),
            ends,
            settings.end_residual,
        )
        for each in (path, otherwise)
    )
    is_seen = before < settings.most_differing_at_seen_end_widths2
    return is_seen and after - before > settings.most_more_differing_at_likelier_end_widths2


def with_strands_exchanged(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body with two strands exchanged where it is straighter and explains as much."""
    width, settings = scene.model.width, scene.settings.exchange
    path, gain = exchanged_strands(found.path, width, settings)
    gain += settings.kept_gain * scene.body.straighter
    found = replace(found, straighter=gain)
    if path is None or gain < settings.least_gain_in_all_rad2:
        return found
    again = None if keeps_loop(scene, found, path) else scene.slid(path)
    if again is None:
        return found
    again = again if scene.over_limits(again) <= 1 else _with_missing_parts(scene, again)
    if scene.over_limits(again) > max(scene.over_limits(found), 1.0):
        return found
    if exchanged_strands(again.path, width, settings)[0] is not None:
        return found  # neither is straighter
    if end_displacement(again.path.points, found.path.points) > width:
        return found  # what lies between the strands is turned round, the ends stay
    return replace(again, path=replace(again.path, ways=found.path.ways), was_exchanged=True)


def keeps_loop(scene: CandidateSearch, found: Candidate, path: BodyPath) -> bool:
    """Tell whether a path passes an open loop otherwise that is known: none turns at once."""
    if scene.seen.dark is None or not scene.is_followed or scene.over_limits(found) > 1:
        return False  # where overlaps are no darker an end may have gone on elsewhere unseen
    width, settings = scene.model.width, scene.settings
    most_px = most_end_sd_px(scene.body, scene.model, settings)
    end_sd_px = end_sd_px_of(scene.body, scene.model, settings)
    seen = end_sd_px[0] < most_px, end_sd_px[1] < most_px
    return turns_known_loop(found.path, path, scene.body, seen, width, settings)


def _with_missing_parts(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body with bends or ends laid anew where that explains more of the object."""
    for _ in range(scene.settings.most_stretches):
        wanted = found.unexplained.wanted
        paths = shifted_strands(found.path, wanted, scene.model.width, scene.settings.shift)
        tried = [scene.scored(path, scene.model.widths) for path in paths]
        best = min([found, *tried], key=lambda one: one.unexplained.total)
        if best is found:
            break
        found = replace(best, end_sd_px=found.end_sd_px)
    near = scene.settings.residual.end_widths * scene.model.width
    if not found.unexplained.wants_near(found.path.points[[0, -1]], 2 * near):
        return found
    for last_end in (False, True):
        path = regrown(
            found.path,
            scene.seen.mask,
            found.unexplained.wanted,
            scene.model.width,
            scene.model.end_width(last_end, scene.settings.end_part_widths),
            last_end,
            scene.settings.regrow,
        )
        if path is None:
            continue
        slid = scene.slid(path)
        if slid is not None and slid.unexplained.total < found.unexplained.total:
            found = slid
    return found
