"""Lays an end of a body anew that lies on it, where overlaps are no darker, by the outline there.

A path that leads an end over the body is not told from others then: an end that has turned aside
unseen shows itself by its outline alone, and what was seen of it so is kept for the next picture.
"""

from dataclasses import replace
from math import ceil, inf

import numpy as np

from worm_tracker.midline.end_by_flanks import end_by_flanks
from worm_tracker.midline.likeliest_end import LikeliestEnd
from worm_tracker.midline.object_outline import Outline
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_laid import known_end, with_end_laid


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
            anew = with_end_laid(scene, found, end.curve, last_end)
            if anew is None:
                continue
            found = anew
        sds[last_end] = end.sd_px
    least = scene.settings.least_end_sd_by_outline_widths * scene.model.width
    first, last = (
        min(seen, max(told, least)) for seen, told in zip(found.end_sd_px, sds, strict=True)
    )
    return replace(found, end_sd_px=(first, last), flanks_sd_px=(sds[0], sds[1]))


def _end_by_outline(
    scene: CandidateSearch, found: Candidate, last_end: bool
) -> LikeliestEnd | None:
    """Return where the flanks say that an end lies; None where they are not asked."""
    settings, model, known = scene.settings, scene.model, known_end(scene, found, last_end)
    if known is None:
        return None
    curve = found.path.curve[:: -1 if last_end else 1]
    reach = ceil((settings.by_flanks.fit.reach_widths + 1) * model.width)
    u, v = (max(int(x) - reach, 0) for x in (known.place.real, known.place.imag))
    window = scene.signal[v : v + 2 * reach, u : u + 2 * reach]
    if min(window.shape) < 2:
        return None
    outline = Outline.of(window, float(np.median(scene.levels)) / 2)
    widths, corner = model.widths[:: -1 if last_end else 1], complex(u, v)
    within = replace(known, place=known.place - corner)
    end = end_by_flanks(outline, curve - corner, widths, within, settings.by_flanks)
    return end if end.curve is None else replace(end, curve=end.curve + corner)
