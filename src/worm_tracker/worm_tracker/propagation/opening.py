"""What is told of a frame within a fold, once one after it shows how the body lay.

The body was followed into the fold, and back from the frame that opens it: two ways that come from
elsewhere and see the same picture.
"""

from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from worm_msgs_py.contract.status import Status
from worm_tracker.observation import Observation
from worm_tracker.propagation.contradictions import ContradictionSettings


@dataclass(frozen=True, slots=True)
class AgreementSettings:
    """When two ways of following a body confirm each other: forwards, and back from a later frame.

    Of 255 midlines that did, in twenty-four films of six worms that fold, none was more than a
    width off; of those up to half a width apart 2 of 287 were, and of those whose ends were less
    sure, up to 0.55 widths, 10 of 59.
    """

    most_apart_widths: float = 0.3
    """How far apart any of their points may be."""
    most_end_sd_widths: float = 0.5
    most_end_sd_of_doubted_widths: float = 0.42
    """How unsure an end may be by what is seen where one of them knows its loops; and where both
    pass the straighter way, so that they may go wrong alike."""
    most_apart_in_darker_widths: float = 0.7
    most_end_sd_in_darker_widths: float = 0.5
    """Where overlaps are darker, which show what lies in them, they may lie farther apart, and one
    of them has to see an end. Of 400 frames more of 44 films that are told so 7 were more than a
    width off, by up to 0.7; of one shade 209 of 692 would have been."""
    most_apart_unsure_widths: float = 0.4
    most_end_sd_unsure_widths: float = 0.6
    """The same where neither sees an end so well, but both do to that: of 289 frames none was."""
    most_end_sd_of_marked_widths: float = 0.42
    most_end_sd_unsure_of_marked_widths: float = 0.55
    """The same where marks alone tell how a loop is passed, and where neither is surer: what lies
    at the ends is told less well by them. Of 1312 such bodies, loops known and not, 15 were more
    than a width off, of 149 less sure 13."""
    coinciding_ends_widths: float = 0.5
    most_end_sd_of_coinciding_widths: float = 0.2
    """Where both ends lie as near to each other, what is seen of one may be the other for both
    ways alike: nothing is confirmed unless one of them sees either as surely as that."""
    most_over_limits_in_darker: float = 3.0
    """How many times what may be left over may be there: both left it over."""
    most_frames_unexplained: int = 5
    """Most pictures in a row that a body may leave unexplained and still be the one followed."""
    most_over_limits_elsewhere: float = 0.3
    most_over_limits_more: float = 0.1
    """What a body may leave over that lies otherwise than one that explains the picture, too: so
    much of what may be, and no more than that other one but for what light and noise make of it."""
    contradictions: ContradictionSettings = field(default_factory=ContradictionSettings)
    """When they contradict each other."""
    least_seen: float = 0.5
    """Part of the body that must be seen by both for one to be known by the other."""


def told_of_fold(
    there: Observation, back: Observation, agreement: AgreementSettings
) -> Observation:
    """Return what is told of a frame within a fold.

    Where the body that was followed into it is the one that the later frame tells of, it is told,
    but for loops that neither way knows.
    Else, of a fold that was followed into with an end hidden, the surer of both midlines is kept.
    Where neither tells a midline, which end is which is carried on as the later frame has it: a
    worm that opens shows how it lay.

    Parameters
    ----------
    there, back : Observation
        What is known of it on the way into the fold, and on the way back.
    agreement : AgreementSettings
    """
    confirmed = _confirmed(body_of(there), body_of(back), agreement)
    has_pose = there.status.has_pose or back.status.has_pose
    if confirmed is not None and (confirmed.loops_known or not has_pose):
        return confirmed
    if tells_more(back, there):
        return back
    if not there.has_midline and back.followed is not None:
        return replace(there, followed=back.followed)
    return there


def tells_more(one: Observation, other: Observation) -> bool:
    """Tell whether one of two observations of a frame tells more of the body."""
    return one.has_midline and _unsure(one) < _unsure(other)


def supersedes(one: Observation, other: Observation, settings: AgreementSettings) -> bool:
    """Tell whether a body may be told where another one explains the picture, too.

    It lies as that does, hidden ends and all, but for loops in doubt; or it leaves less over.
    """
    most = min(
        settings.most_over_limits_elsewhere, other.over_limits + settings.most_over_limits_more
    )
    if one.over_limits < most:
        return True
    for way in (one, one.reversed()):
        certain = np.ones(len(way.points), bool)
        certain[slice(*way.in_doubt)] = certain[slice(*other.in_doubt)] = False
        apart = np.hypot(*(way.points[certain] - other.points[certain]).T) / other.width
        away, end_sd = float(apart.max(initial=0.0)), max(one.seen_end_sd_px) / one.width
        sees_ends = one.overlaps_tell and end_sd < settings.most_end_sd_in_darker_widths
        most = settings.most_apart_in_darker_widths if sees_ends else settings.most_apart_widths
        if away < most:
            return True
    return False


def body_of(observation: Observation) -> Observation | None:
    """Return what has an observation's midline, told or only followed; None without one."""
    return observation if observation.has_midline else observation.followed


def _confirmed(
    there: Observation | None, back: Observation | None, settings: AgreementSettings
) -> Observation | None:
    """Return the body that both ways agree on; None where they do not.

    It lies midway between both: where an end lies on the body they err apart.
    """
    if there is None or back is None or not (there.has_midline and back.has_midline):
        return None
    for way in (back, back.reversed()):
        in_doubt = _doubted_of_same(there, way, settings)
        if in_doubt is None:
            continue
        is_open = Status.TRACKED in (there.status, way.status)
        seen_as = Status.TRACKED if is_open else Status.FOLDED
        sds = zip(there.seen_end_sd_px, way.seen_end_sd_px, strict=True)
        first, last = (min(both) for both in sds)
        points = (there.points + way.points) / 2
        apart_px = float(np.hypot(*(points[0] - points[-1])))
        coincide = apart_px < settings.coinciding_ends_widths * there.width
        if coincide and max(first, last) > settings.most_end_sd_of_coinciding_widths * there.width:
            return None
        return replace(
            there,
            status=seen_as if in_doubt == (0, 0) else Status.LOOP_IN_DOUBT,
            points=points,
            confidence=(there.confidence + way.confidence) / 2,
            occluded=(0, 0),
            end_sd_px=(first, last),
            in_doubt=in_doubt,
            order_known=there.order_known or (way is back and back.order_known),
            unresolved=None,
        )
    return None


def _doubted_of_same(
    one: Observation, other: Observation, settings: AgreementSettings
) -> tuple[int, int] | None:
    """Return what stays in doubt of two bodies that are the same one, so that both are right.

    What is in doubt of a body that was followed for long (a strand that it may have changed over
    to, an end that lies on the body) would have led the other, which comes from elsewhere, to
    another place. Which way round a loop is passed is not told so where neither knows it: both take
    the straighter way; nor where an end is that is bent back onto its flank: both take the bend for
    it. None where they are not known to be the same.
    """
    apart = np.hypot(*(one.points - other.points).T) / one.width
    doubts = [each.in_doubt for each in (one, other) if not each.loops_known]
    most = _most_apart_widths(one, other, settings.most_end_sd_widths, settings)
    if len(doubts) < 2 and apart.max() < most:
        return 0, 0
    if not doubts:
        return None
    told, in_doubt = np.ones(len(apart), bool), (min(doubts)[0], max(end for _, end in doubts))
    told[slice(*in_doubt)] = False
    most = _most_apart_widths(one, other, settings.most_end_sd_of_doubted_widths, settings)
    return in_doubt if told.any() and apart[told].max() < most else None


def _most_apart_widths(
    one: Observation, other: Observation, most_end_sd_widths: float, settings: AgreementSettings
) -> float:
    """Return how far apart two bodies may be that are the same one; 0 where nothing tells.

    With ends as unsure as that at most where overlaps are no darker.
    """
    if any(one.broad_ends) or any(other.broad_ends):
        return 0.0
    over = max(one.over_limits, other.over_limits)
    sds = np.array([one.seen_end_sd_px, other.seen_end_sd_px]) / one.width
    if one.overlaps_tell and other.overlaps_tell:
        if over > settings.most_over_limits_in_darker:
            return 0.0
        if one.by_marks or other.by_marks:
            told = sds.min(axis=0).max() < settings.most_end_sd_of_marked_widths
            told &= sds.max() < settings.most_end_sd_unsure_of_marked_widths
            return settings.most_apart_in_darker_widths if told else 0.0
        if sds.min(axis=0).max() < settings.most_end_sd_in_darker_widths:
            return settings.most_apart_in_darker_widths
        unsure = sds.max() < settings.most_end_sd_unsure_widths
        return settings.most_apart_unsure_widths if unsure else 0.0
    return settings.most_apart_widths if sds.max() < most_end_sd_widths and over <= 1 else 0.0


def _unsure(observation: Observation) -> tuple[bool, bool, float]:
    """Return how little is told of a body: first that both ends are, then its loops count."""
    if not observation.has_midline:
        return True, True, inf
    ends_hidden = any(observation.occluded)
    return ends_hidden, not observation.loops_known, max(observation.end_sd_px)
