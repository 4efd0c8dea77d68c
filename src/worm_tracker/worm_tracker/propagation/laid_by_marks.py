"""Lays the loops of a body as the marks of its skin say that they are passed."""

from dataclasses import replace

from worm_tracker.midline.path import BodyPath
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate

_MOST_LOOPS = 4
"""How many loops of a body are turned round in a picture: few bodies have more."""


def with_loops_by_marks(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body with the loops turned round of which marks say that they are passed otherwise.

    Where that explains the picture as well, and nothing else tells how they are passed.
    """
    if not _may_be_passed_otherwise(scene, found):
        return found
    way = found.path
    for _ in range(_MOST_LOOPS):
        turned = _one_turned(scene, way)
        if turned is None:
            break
        way = turned
    slid = None if way is found.path else scene.slid(way)
    most_over = scene.over_limits(found) + scene.settings.most_over_limits_more_by_marks
    if slid is None or scene.over_limits(slid) > most_over:
        return found
    return replace(slid, path=replace(slid.path, ways=found.path.ways), was_exchanged=True)


def _may_be_passed_otherwise(scene: CandidateSearch, found: Candidate) -> bool:
    """Tell whether a body was lost, is lost or had a loop in doubt."""
    body = scene.body
    was_lost = body.frames_unexplained > 0 or body.was_turned
    return was_lost or body.doubt_by_bends is not None or scene.over_limits(found) > 1


def _one_turned(scene: CandidateSearch, path: BodyPath) -> BodyPath | None:
    """Return a path with the loop turned round that marks say most against; None without one."""
    loops = scene.marked_loops(path)
    worst = min(loops, key=lambda each: each.log_odds, default=None)
    if worst is None or worst.log_odds > -scene.settings.marks.least_log_odds:
        return None
    return worst.otherwise
