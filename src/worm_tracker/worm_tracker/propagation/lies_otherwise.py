"""Finds how a body lies that was followed, and no longer explains its picture."""

from dataclasses import replace

from worm_tracker.midline.led_out import led_out
from worm_tracker.midline.other_ways import add_if_new, other_ways
from worm_tracker.midline.path import BodyPath, sharpest_turn
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.laid_anew import followed_body, keeps_loop
from worm_tracker.propagation.laid_by_marks import with_loops_by_marks
from worm_tracker.propagation.laid_by_signal import with_ends_by_signal
from worm_tracker.propagation.laid_by_skin import with_ends_by_skin
from worm_tracker.propagation.laid_by_widths import with_loop_by_widths


def followed_or_otherwise(scene: CandidateSearch) -> Candidate | None:
    """Return the last body slid along itself; or laid otherwise, where only that explains all.

    Or one step from there, where that explains far more.
    """
    found = followed_body(scene)
    if found is not None and scene.over_limits(found) > 1 and is_due(scene):
        found = _lies_otherwise(scene, found)
    elif found is not None and is_doubted(scene, found):
        found = _lies_better(scene, found)
    if found is None:
        return None
    found = with_ends_by_skin(scene, with_ends_by_signal(scene, found))
    by_marks = with_loops_by_marks(scene, found)
    return scene.turned_round(with_loop_by_widths(scene, by_marks))


def is_doubted(scene: CandidateSearch, found: Candidate) -> bool:
    """Tell whether a body leaves so much over that another may lie there: darker overlaps tell.

    On a skin with marks, which are told less well, much is left over in picture after picture: once
    another body was looked for it is only where more is.
    """
    over, before = scene.over_limits(found), scene.body.over_limits
    settings = scene.settings
    if scene.seen.dark is None or over <= settings.doubted_over_limits:
        return False
    was_doubted = scene.model.is_marked and before > settings.doubted_over_limits
    return not was_doubted or over > before + settings.least_more_over_limits_of_marked


def is_due(scene: CandidateSearch) -> bool:
    """Tell whether other bodies are tried in this picture: at first in each, then now and then."""
    unexplained, settings = scene.body.frames_unexplained, scene.settings
    at_first = unexplained <= settings.most_frames_unexplained
    return at_first or unexplained % settings.tried_again_frames == 0


def _lies_otherwise(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return the way of a body, at most two steps from where it is, that explains most.

    The body itself where none explains all, or so much more that it is plainly another one.
    """
    settings = scene.settings
    ways = [found.path]
    one_step = _added(scene, ways, found.path)
    best = _best_of(scene, one_step, settings.most_kink_rad)
    if best is None or scene.over_limits(best) > 1:
        best = _better_of(best, _led_out(scene, found))
    if best is None or scene.over_limits(best) > 1:
        two_steps = [way for path in one_step for way in _added(scene, ways, path)]
        few = _few_of(scene, found, two_steps, settings.most_ways_slid)
        best = _better_of(best, _best_of(scene, few, settings.most_kink_rad))
    if best is None:
        return found
    gain = found.unexplained.total - best.unexplained.total
    if scene.over_limits(best) > 1 and gain < settings.least_gain_of_other_way_widths2:
        return found
    return replace(best, was_exchanged=True)


def _led_out(scene: CandidateSearch, found: Candidate) -> Candidate | None:
    """Return the body with an end led to the piece that it leaves over, if that may be so."""
    settings, model = scene.settings, scene.model
    ways = led_out(
        found.path, found.unexplained.wanted, model.width, model.length, settings.led_out
    )
    few = _few_of(scene, found, ways, settings.most_ways_led_out)
    return _best_of(scene, few, settings.most_kink_led_out_rad)


def _few_of(
    scene: CandidateSearch, found: Candidate, ways: list[BodyPath], most: int
) -> list[BodyPath]:
    """Return those ways that as they are leave least unexplained: to slide one takes long.

    None that leaves far more than the body does.
    """
    most_left = found.unexplained.total + scene.settings.most_more_left_by_way_widths2
    left = [_left(scene, way) for way in ways]
    best = sorted(range(len(ways)), key=lambda k: left[k])[:most]
    return [ways[k] for k in best if left[k] < most_left]


def _better_of(one: Candidate | None, other: Candidate | None) -> Candidate | None:
    """Return the body that leaves less unexplained, of those that there are."""
    both = [found for found in (one, other) if found is not None]
    return min(both, key=lambda found: found.unexplained.total, default=None)


def _lies_better(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return the way of a body that explains its picture, one step away, if it explains far more.

    Two strands that lie beside each other with an end may be taken for each other: little is left
    over of that.
    """
    ways = _added(scene, [found.path], found.path)
    otherwise = [way for way in ways if not keeps_loop(scene, found, way)]
    best = _best_of(scene, otherwise, scene.settings.most_kink_rad)
    most = scene.settings.most_over_limits_of_better_way * scene.over_limits(found)
    if best is None or scene.over_limits(best) > most:
        return found
    return replace(best, was_exchanged=True)


def _added(scene: CandidateSearch, ways: list[BodyPath], path: BodyPath) -> list[BodyPath]:
    """Return the ways that are one step from a path and new, and add them to those known."""
    settings, width = scene.settings, scene.model.width
    return [
        way
        for way in other_ways(path, scene.seen.mask, width, settings.doubt, settings.other_ways)
        if add_if_new(ways, way, width, settings.other_ways)
    ]


def _best_of(
    scene: CandidateSearch, ways: list[BodyPath], most_kink_rad: float
) -> Candidate | None:
    """Return the body slid along one of some ways that leaves least unexplained.

    Without a leap, and without a kink that it did not have: that explains what it should not. It
    may turn by so much more sharply than the body did.
    """
    before = sharpest_turn(scene.last, scene.model.width)
    most_turn = max(scene.settings.most_turn_rad_per_width, before + most_kink_rad)
    slid = [one for way in ways if (one := scene.slid(way)) is not None]
    sound = [
        one
        for one in slid
        if not scene.leaps(one) and sharpest_turn(one.path, scene.model.width) < most_turn
    ]
    return min(sound, key=lambda one: one.unexplained.total, default=None)


def _left(scene: CandidateSearch, way: BodyPath) -> float:
    """Return what a way leaves unexplained as it is, squared widths."""
    return scene.scored(way, scene.model.widths).unexplained.total
