"""Finds a body anew that was lost for long: traced through its object from an end."""

from dataclasses import replace
from math import log

from worm_tracker.midline.body_model import is_nearer_reversed
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.other_ways import add_if_new, other_ways
from worm_tracker.midline.path import BodyPath, path_of
from worm_tracker.midline.traced_body import traced_bodies
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.lies_otherwise import is_due


def traced_anew(scene: CandidateSearch) -> Candidate | None:
    """Return a body traced through its object that explains the picture; None without one.

    Where others may explain it, too, one that leaves hardly anything over: it is not known yet.
    None where what is followed may be right, as the worm was seen lately, or where it is not known
    well: what explains a picture then may be wrong, and was followed in place of what was right.
    """
    if not scene.is_lost or scene.model.is_young or not is_due(scene):
        return None
    ways = sorted(_traced_ways(scene), key=lambda fitting: fitting[0])
    slid = [scene.slid(way) for _, way in ways[: scene.settings.most_ways_slid]]
    likely = [found for found in slid if found is not None and _has_its_length(scene, found)]
    best = min(likely, key=_left_over, default=None)
    if best is None:
        return None
    was_exchanged = scene.is_followed  # else none of its loops is taken for known
    found = scene.turned_round(replace(best, was_exchanged=was_exchanged))
    alone = scene.seen.dark is not None and scene.frames_unexplained(found) == 0
    return found if alone or _leaves_nothing_over(scene, found) else None


def _has_its_length(scene: CandidateSearch, found: Candidate) -> bool:
    """Tell whether a body is about as long as the worm, where overlaps are no darker."""
    most = scene.settings.most_log_length_explained
    return scene.seen.dark is not None or abs(log(found.path.length / scene.model.length)) < most


def _leaves_nothing_over(scene: CandidateSearch, found: Candidate) -> bool:
    """Tell whether a body leaves hardly anything over of the picture."""
    return scene.over_limits(found) <= scene.settings.most_over_limits_alone


def _traced_ways(scene: CandidateSearch) -> list[tuple[float, BodyPath]]:
    """Return how a body may lie, no two alike: traced, or one step from there.

    And what each leaves over as it is, squared widths: to slide one takes long.
    """
    model, settings, mask = scene.model, scene.settings, scene.seen.mask
    ways = list[BodyPath]()
    for line in traced_bodies(mask, model.width, model.length, settings.traced):
        way = path_of(as_points(line), None, model.width)
        if add_if_new(ways, way, model.width, settings.other_ways):
            for other in other_ways(way, mask, model.width, settings.doubt, settings.other_ways):
                add_if_new(ways, other, model.width, settings.other_ways)
    return [_as_it_fits(scene, way) for way in ways]


def _as_it_fits(scene: CandidateSearch, way: BodyPath) -> tuple[float, BodyPath]:
    """Return what a way leaves over, with its ends in the order that leaves less.

    Else in the order that is nearer to the last.
    """
    turned, settings = way.turned_round(), scene.settings
    left, left_turned = (
        _left_over(scene.scored(path, scene.model.widths)) for path in (way, turned)
    )
    if abs(left - left_turned) > settings.least_gain_of_order_widths2:
        return (left, way) if left < left_turned else (left_turned, turned)
    is_reversed = is_nearer_reversed(way.points, scene.last.points)
    return (left_turned, turned) if is_reversed else (left, way)


def _left_over(found: Candidate) -> float:
    return found.unexplained.total
