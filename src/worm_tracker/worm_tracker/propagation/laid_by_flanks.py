"""Lays an end of a body anew that lies on it, where overlaps are no darker, by the outline there.

A path that leads an end over the body is not told from others then: an end that has turned aside
unseen shows itself by its outline alone, and what was seen of it so is kept for the next picture.
"""

from dataclasses import replace
from math import ceil, inf

import numpy as np

from worm_msgs_py.arrays import Complex
from worm_tracker.midline.curve import complex_arc_length
from worm_tracker.midline.end_by_flanks import EndByFlanks, KnownEnd, end_by_flanks
from worm_tracker.midline.object_outline import Outline
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.self_cover import ends_on_body, lies_near_itself
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate


def with_ends_by_flanks(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body each end of which lies where its outline is explained best, and how surely.

    As it is where overlaps tell more.
    """
    if scene.seen.dark is not None:
        return found
    sds = [inf, inf]
    for last_end in (False, True):
        end = _end_by_outline(scene, found, last_end)
        if end is None:
            continue
        if end.curve is not None:
            anew = _with_end_laid(scene, found, end.curve, last_end)
            if anew is None:
                continue
            found = anew
        sds[last_end] = end.sd_px
    least = scene.settings.least_end_sd_by_outline_widths * scene.model.width
    first, last = (
        min(seen, max(told, least)) for seen, told in zip(found.end_sd_px, sds, strict=True)
    )
    return replace(found, end_sd_px=(first, last), flanks_sd_px=(sds[0], sds[1]))


def _end_by_outline(scene: CandidateSearch, found: Candidate, last_end: bool) -> EndByFlanks | None:
    """Return where the flanks say that an end lies; None where it does not lie on the body.

    Nor where the other end is: what is seen of one may be the other.
    """
    settings, model = scene.settings, scene.model
    path = found.path.turned_round() if last_end else found.path
    near_px = settings.near_end_widths * model.width
    apart_px = abs(path.curve[0] - path.curve[-1])
    if not ends_on_body(path.curve, near_px, path.step)[0] or apart_px < near_px:
        return None
    reach = ceil((settings.by_flanks.fit.reach_widths + 1) * model.width)
    u, v = (max(int(x) - reach, 0) for x in (path.curve[0].real, path.curve[0].imag))
    window = scene.signal[v : v + 2 * reach, u : u + 2 * reach]
    if min(window.shape) < 2:
        return None
    outline = Outline.of(window, float(np.median(scene.levels)) / 2)
    widths, corner = model.widths[:: -1 if last_end else 1], complex(u, v)
    known = KnownEnd(found.end_sd_px[last_end], model.length, scene.length_scatter_px)
    end = end_by_flanks(
        outline, path.curve - corner, widths, model.width, known, settings.by_flanks
    )
    return end if end.curve is None else replace(end, curve=end.curve + corner)


def _with_end_laid(
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
    return replace(anew, end_sd_px=found.end_sd_px)
