"""Lays a loop of a body as its widths say that it is passed."""

from dataclasses import replace
from math import inf

from worm_tracker.midline.order_by_widths import area_of_body
from worm_tracker.midline.way_by_widths import loops_by_widths, score_of_way
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate


def with_loop_by_widths(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body with the loop turned round that covers its object much better that way.

    A thin tail that leaves a loop where its strands meet goes on straight along either; but only
    the right one thins towards it.
    """
    if scene.over_limits(found) > 1:
        return found  # it lies elsewhere
    model, settings = scene.model, scene.settings
    mask, widths, by_widths = scene.seen.mask, model.widths, settings.way_by_widths
    loops = loops_by_widths(
        mask,
        found.path,
        widths,
        model.width,
        settings.doubt,
        settings.least_breadth_widths,
        by_widths,
    )
    least, otherwise = min(loops, key=lambda each: each[0], default=(inf, found.path))
    if least > by_widths.most_score_of_wrong:
        return found
    slid = scene.slid(otherwise)
    if slid is None or scene.over_limits(slid) > 1 or scene.leaps(slid):
        return found
    one, other = (area_of_body(mask.shape, each.path.points, widths) for each in (slid, found))
    score = score_of_way(mask, one, other, by_widths)
    if score is None or score < by_widths.least_score:
        return found
    return replace(slid, path=replace(slid.path, ways=found.path.ways), was_exchanged=True)
