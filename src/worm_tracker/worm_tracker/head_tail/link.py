"""Links midlines from frame to frame: which end is which, how surely, and how the body moved."""

from dataclasses import dataclass, field, replace
from math import exp

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.status import Status
from worm_tracker.head_tail.certainty import both_say, certainty_before_link
from worm_tracker.midline.body_model import BodyModelSettings
from worm_tracker.midline.curve import (
    as_complex,
    as_points,
    complex_arc_length,
    length_of,
    tangents,
)
from worm_tracker.midline.self_cover import ends_kept
from worm_tracker.observation import Observation
from worm_tracker.worm_track import WormTrack


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """How reliable a link is."""

    point_step_sd_widths: float = 0.15
    """Typical distance of a body's points from where they were a frame before."""
    step_memory_frames: float = 30.0
    """Memory of how far a body's points move in a frame."""
    leap_over_farthest: float = 0.85
    """Part of the farthest way of an end from which on it casts doubt on the link."""
    leap_reliability: float = 0.75
    """The most that a link with such a leap is trusted: the certainty falls, whatever it was."""
    least_confidence: float = 0.8
    """A body that explains the picture less well does not tell where the ends are."""
    slid_below_reliability: float = 0.9999
    """A link less reliable than this is looked at again, the body slid along itself."""
    same_path_reliability: float = 0.9999
    """How surely a body that was slid along itself has kept its ends."""
    most_frames_unexplained: int = 5
    """Most pictures in a row that it may have left unexplained meanwhile."""
    lost_reliability: float = 0.6
    """The most that a link is trusted to a body that explains its picture from one that left more
    pictures than that unexplained: it may have lain elsewhere, the other way round."""
    order_reliability: float = 0.998
    turned_reliability: float = 0.98
    """How surely the widths of a body tell which of its ends is which; and where they tell another
    order than its way from the last body of which they told it."""
    most_frames_of_motion: int = 3
    """Frames between two midlines beyond which their difference is no motion."""
    body: BodyModelSettings = field(default_factory=BodyModelSettings)


@dataclass(frozen=True, eq=False, slots=True)
class BodyMotion:
    """How a body moved between two midlines.

    Attributes
    ----------
    forward_lengths : float
        How far along itself, towards its first end, in lengths.
    """

    forward_lengths: float


@dataclass(frozen=True, slots=True)
class LinkDecision:
    """What the appearance of the ends says of a link that was in doubt.

    Attributes
    ----------
    frames : int
        How many frames before this one it led to.
    was_reversed : bool
        Whether it was the wrong way round: what came after it is turned round.
    reliability : float
        Probability, 0.5 to 1, of that.
    """

    frames: int
    was_reversed: bool
    reliability: float


@dataclass(frozen=True, slots=True)
class KnownAgain:
    """A midline whose widths tell the order of its ends, as those of an earlier one did.

    Attributes
    ----------
    frames_between : int
        How many frames lie between the two.
    way_was_wrong : bool
        Whether the links between them say the contrary: one of them was the wrong way round.
    reliability : float
        Probability, 0.5 to 1, that the two are in the same order.
    """

    frames_between: int
    way_was_wrong: bool
    reliability: float


@dataclass(frozen=True, eq=False, slots=True)
class Link:
    """An observation linked to those before it.

    Attributes
    ----------
    observation : Observation
        Its midline in the order of the chain, which is the same for all linked midlines.
    reliability : float
        Probability, 0.5 to 1, that the link to the one before is not the wrong way round.
    motion : BodyMotion or None
        Since the one before; None where that was too long ago.
    is_new_body : bool
        Whether the body has been learned anew since: what was held to be the worm was not.
    decision : LinkDecision or None
        On an earlier link, where this frame's appearance has decided it.
    known_again : KnownAgain or None
        Where its widths tell the order of its ends, and have told it before.
    """

    observation: Observation
    reliability: float
    motion: BodyMotion | None
    is_new_body: bool = False
    decision: LinkDecision | None = None
    known_again: KnownAgain | None = None


@dataclass(frozen=True, slots=True)
class _Order:
    """How the order in which midlines come, that of the body model, is to the chain's.

    Attributes
    ----------
    is_reversed : bool
        Whether the last midline had to be turned round.
    model_reversed : bool or None
        Whether the body model would have to be, by the last midline whose widths told its order;
        None where none has.
    path_number : int
        Of the last one.
    frames_unexplained : int
        Since one explained its picture.
    frames_unknown : int
        Since the widths of one told its order.
    kept : float
        Probability that the order has been kept since then, by the links alone.
    loops_known : bool
        Whether the last midline's loops were known to be passed as they were.
    """

    is_reversed: bool = False
    model_reversed: bool | None = None
    path_number: int = 0
    frames_unexplained: int = 0
    frames_unknown: int = 0
    kept: float = 1.0
    loops_known: bool = True

    def then(
        self, observation: Observation, is_reversed: bool, reliability: float, told: int
    ) -> "_Order":
        """Return the order after one midline more; `told` as of `Chain._order_told`."""
        return _Order(
            is_reversed,
            is_reversed != (told < 0) if told else self.model_reversed,
            observation.path_number,
            0 if observation.explains else self.frames_unexplained + 1,
            0 if told else self.frames_unknown + 1,
            1.0 if told else certainty_before_link(self.kept, reliability),
            observation.loops_known,
        )

    def missed(self) -> "_Order":
        """Return the order after a frame without a midline."""
        return replace(
            self,
            path_number=0,
            frames_unexplained=self.frames_unexplained + 1,
            frames_unknown=self.frames_unknown + 1,
        )

    def reversed(self, frames: int) -> "_Order":
        """Return the order where the chain is turned round from so many frames ago on."""
        order = replace(self, is_reversed=not self.is_reversed)
        if self.model_reversed is None or self.frames_unknown > frames:
            return order
        return replace(order, model_reversed=not self.model_reversed)


class Chain:
    """Puts each midline in the order of the ends of those before; the last is the track's.

    Parameters
    ----------
    track : WormTrack
    settings : LinkSettings

    Notes
    -----
    Midlines come in the order of the body model, whose widths tell the ends apart, save where a
    fold was followed the wrong way round. That order and the chain's are the same or opposite;
    where it is found again, it tells more than where the body was.
    """

    def __init__(self, track: WormTrack, settings: LinkSettings) -> None:
        self._track = track
        self._settings = settings
        self._bodies_begun = track.bodies_begun
        self._gap = 1
        self._frames_unsure = 0
        self._mean_step = 0.0
        self._forward = 0.0
        self._order = _Order()

    @property
    def begun(self) -> bool:
        """Whether there is a body to speak of."""
        return self._track.linked is not None

    @property
    def is_known(self) -> bool:
        """Whether the widths of the last midline told which of its ends is which."""
        return self._order.model_reversed is not None and not self._order.frames_unknown

    def skip(self, frames: int) -> None:
        """Note that frames are missing: the next link is over a longer time."""
        self._gap += frames

    def miss(self) -> None:
        """Note a frame without a midline: the next link is less sure."""
        self._gap += 1
        self._order = self._order.missed()

    @property
    def frames_unknown(self) -> int:
        """How many frames ago a midline's widths last told which of its ends is which."""
        return self._order.frames_unknown

    def reverse(self, frames: int) -> None:
        """Turn the last midlines round, since so many frames ago: they were linked wrong."""
        if self._track.linked is not None:
            self._track.link(self._track.linked[::-1])
            self._order = self._order.reversed(frames)

    def push(self, observation: Observation) -> Link:
        """Link the next midline, which may be either way round."""
        last = self._track.linked
        if last is None:
            self._track.link(observation.points)
            self._bodies_begun = self._track.bodies_begun
            told = self._order_told(observation)
            self._order = _Order().then(observation, False, 1.0, told)
            return Link(observation, 1.0, None)
        is_reversed, reliability = self._by_way(observation, last)
        new_body = self._track.bodies_begun != self._bodies_begun
        self._bodies_begun = self._track.bodies_begun
        if new_body:
            self._order = replace(self._order, model_reversed=None)
        told = self._order_told(observation)
        known_again = self._known_again(told, is_reversed, reliability)
        way_was_wrong = known_again is not None and known_again.way_was_wrong
        is_reversed ^= way_was_wrong
        self._order = self._order.then(observation, is_reversed, reliability, told)
        observation = observation.reversed() if is_reversed else observation
        motion = self._motion(observation.points, last)
        lies_on_itself = any(observation.end_sd_px) and observation.status is not Status.TRACKED
        if lies_on_itself or way_was_wrong:
            motion = None  # it hides how its parts move
        poor = observation.confidence < self._settings.least_confidence
        self._frames_unsure = self._frames_unsure + self._gap if poor else 0
        self._gap = 1
        self._track.link(observation.points)
        if new_body:
            return Link(observation, 0.5, motion, new_body)
        return Link(observation, reliability, motion, known_again=known_again)

    def _by_way(self, observation: Observation, last: Floats) -> tuple[bool, float]:
        """Tell by the way from the last midline which way round the next is, and how surely."""
        straight = _mean_distance(observation.points, last)
        turned = _mean_distance(observation.points[::-1], last)
        order, settings = self._order, self._settings
        same_path = order.path_number == observation.path_number != 0
        same_path &= order.frames_unexplained <= settings.most_frames_unexplained
        is_reversed = order.is_reversed if same_path else turned < straight
        ends_stay = _ends_stay(observation, last)
        ends_differ = not same_path and ends_stay is not None and ends_stay == is_reversed
        if ends_differ and not (order.loops_known and observation.loops_known):
            is_reversed, ends_differ = not is_reversed, False
        seen = observation.reversed() if is_reversed else observation
        near, far = sorted((straight, turned))
        reliability = self._reliability(seen.points, last, seen.width, near, far)
        if ends_differ or self._is_leap(seen.points, last, seen.width):
            reliability = min(reliability, settings.leap_reliability)
        elif same_path:
            reliability = max(reliability, settings.same_path_reliability)
        if seen.explains and order.frames_unexplained > settings.most_frames_unexplained:
            reliability = min(reliability, settings.lost_reliability)
        if any(seen.occluded):
            reliability = min(reliability, ends_kept(seen.points, seen.end_sd_px))
        return is_reversed, reliability

    def _order_told(self, observation: Observation) -> int:
        """Return 1 where a midline's widths tell that it comes in the model's order, -1, or 0."""
        model = self._track.model
        if observation.order_known or model is None or observation.appearance is None:
            return int(observation.order_known)
        return model.order_told(observation.widths)  # as they were measured on an open body

    def _known_again(self, told: int, is_reversed: bool, reliability: float) -> KnownAgain | None:
        """Return what the widths of a midline say, together with the way to it."""
        order, settings = self._order, self._settings
        if not told or order.model_reversed is None:
            return None
        if (is_reversed != (told < 0)) != order.model_reversed:
            return KnownAgain(order.frames_unknown, True, settings.turned_reliability)
        kept = certainty_before_link(order.kept, reliability)
        surely = both_say(kept, settings.order_reliability)
        return KnownAgain(order.frames_unknown, False, surely)

    def _reliability(
        self, points: Floats, last: Floats, width: float, near: float, far: float
    ) -> float:
        """Return the probability that the nearer of two ways round is the right one."""
        settings = self._settings
        frames = self._gap + self._frames_unsure
        if frames == 1:
            self._mean_step += (near - self._mean_step) / settings.step_memory_frames
        # A body not seen for long may be anywhere. Where even the better way is far off, only the
        # ratio of the two says anything.
        gone = self._mean_step * (frames - 1)
        sd = settings.point_step_sd_widths * width
        reliability = _nearer_is_right(near, far, sd**2 * self._gap + gone**2)
        if frames == 1 and reliability < settings.slid_below_reliability:
            # In a coil the turns lie near each other: what counts is the way from where it slid to.
            near = min(near, _mean_distance(points, _slid(last, self._forward)))
            reliability = _nearer_is_right(near, far, sd**2)
        return reliability

    def _is_leap(self, points: Floats, last: Floats, width: float) -> bool:
        """Tell whether an end is nearly farther from where it was than an end can have got."""
        far = self._settings.body.most_end_step_px(width, length_of(last))
        moved = np.abs(as_complex(points[[0, -1]]) - as_complex(last[[0, -1]]))
        return float(moved.max()) > self._settings.leap_over_farthest * far * self._gap

    def _motion(self, points: Floats, last: Floats) -> BodyMotion | None:
        """Return how the body moved since the last midline."""
        if self._gap > self._settings.most_frames_of_motion:
            return None
        line = as_complex(last)
        # Along the tangent towards the first end.
        moved = (as_complex(points) - line) * -tangents(line).conj()
        n = len(points)
        self._forward = float(moved.real[n // 8 : n - n // 8].mean())
        return BodyMotion(self._forward / length_of(last))


def _nearer_is_right(near: float, far: float, variance: float) -> float:
    """Return the probability of the nearer of two ways, of mean distances in pixels."""
    spread = variance + near**2
    return float(1 / (1 + exp(-min((far**2 - near**2) / (2 * spread), 30.0))))


def _ends_stay(observation: Observation, last: Floats) -> bool | None:
    """Tell whether both ends are where they were, or each where the other was; None where neither.

    What lies between them tells nothing where a loop that is most of a body is passed the other
    way: most of it is then in the other order.
    """
    if any(observation.occluded):
        return None
    ends, were = observation.points[[0, -1]], last[[0, -1]]
    stay, change = (float(np.hypot(*(ends - at).T).sum()) for at in (were, were[::-1]))
    if max(stay, change) < 2 * min(stay, change) + observation.width:
        return None
    return stay < change


def _mean_distance(a: Floats, b: Floats) -> float:
    """Return the mean distance of corresponding points."""
    return float(np.abs(as_complex(a - b)).mean())


def _slid(points: Floats, forward: float) -> Floats:
    """Return a midline slid along itself by a length, towards its first end."""
    line = as_complex(points)
    s = complex_arc_length(line)
    at = s - forward
    slid = np.interp(at, s, line)
    slid += np.minimum(at, 0.0) * (line[1] - line[0]) / max(s[1], 1e-9)
    slid += np.maximum(at - s[-1], 0.0) * (line[-1] - line[-2]) / max(s[-1] - s[-2], 1e-9)
    return as_points(slid)
