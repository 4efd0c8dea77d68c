"""Links midlines from frame to frame: which end is which, how surely, and how the body moved."""

from dataclasses import dataclass, field, replace

import numpy as np

from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.contract.status import Status
from worm_tracker.head_tail.certainty import certainty_before_link
from worm_tracker.head_tail.chain_order import (
    ChainOrder,
    KnownAgain,
    OrderByWidthsSettings,
)
from worm_tracker.head_tail.order_by_place import (
    EndsInPlaceSettings,
    ends_in_place,
    ends_nearer,
    mean_distance,
    nearer_is_right,
    points_in_order,
    slid,
)
from worm_tracker.midline.body_model import BodyModelSettings
from worm_tracker.midline.curve import as_complex, length_of, tangents
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
    ends_in_place: EndsInPlaceSettings = field(default_factory=EndsInPlaceSettings)
    ends_seen_reliability: float = 0.9999
    """How surely ends are the same that are seen a frame later where they were."""
    most_frames_unexplained: int = 5
    """Most pictures in a row that it may have left unexplained meanwhile."""
    lost_reliability: float = 0.6
    """The most that a link is trusted to a body that explains its picture from one that left more
    pictures than that unexplained: it may have lain elsewhere, the other way round."""
    widths: OrderByWidthsSettings = field(default_factory=OrderByWidthsSettings)
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
    own_reliability : float
        Probability, 0.5 to 1, that its own ends are in that order: less than 1 where its widths say
        otherwise, but the way is surer.
    """

    observation: Observation
    reliability: float
    motion: BodyMotion | None
    is_new_body: bool = False
    decision: LinkDecision | None = None
    known_again: KnownAgain | None = None
    own_reliability: float = 1.0


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
        self._order = ChainOrder()
        self._in_order: Mask = np.empty(0, bool)

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
            self._in_order = self._in_order[::-1]
            self._order = self._order.reversed(frames)

    def push(self, observation: Observation) -> Link:
        """Link the next midline, which may be either way round."""
        last, settings = self._track.linked, self._settings
        if last is None:
            self._take(observation)
            self._bodies_begun = self._track.bodies_begun
            told = self._order_told(observation)
            self._order = ChainOrder().then(observation, False, told, 1.0)
            return Link(observation, 1.0, None)
        is_reversed, reliability = self._by_way(observation, last)
        new_body = self._track.bodies_begun != self._bodies_begun
        self._bodies_begun = self._track.bodies_begun
        if new_body:
            self._order = replace(self._order, model_reversed=None)
        widths, kept = settings.widths, certainty_before_link(self._order.kept, reliability)
        told = self._order_told(observation)
        way_is_surer = self._order.contradicts(told, is_reversed) and kept > widths.reliability
        told = 0 if way_is_surer else told
        known_again = self._order.known_again(told, is_reversed, kept, widths)
        way_was_wrong = known_again is not None and known_again.way_was_wrong
        is_reversed ^= way_was_wrong
        self._order = self._order.then(observation, is_reversed, told, kept)
        if way_is_surer and observation.status is Status.TRACKED:
            self._order = self._order.then_contradicted(widths)
            if not self._order.contradicted:
                reliability = widths.given_up_reliability
        observation = observation.reversed() if is_reversed else observation
        motion = self._motion(observation.points, last)
        lies_on_itself = any(observation.end_sd_px) and observation.status is not Status.TRACKED
        if lies_on_itself or way_was_wrong:
            motion = None  # it hides how its parts move
        poor = observation.confidence < settings.least_confidence
        self._frames_unsure = self._frames_unsure + self._gap if poor else 0
        self._gap = 1
        self._take(observation)
        if new_body:
            return Link(observation, 0.5, motion, new_body)
        own = widths.contradicted_reliability if way_is_surer else 1.0
        return Link(observation, reliability, motion, known_again=known_again, own_reliability=own)

    def _take(self, observation: Observation) -> None:
        """Remember a midline, in the chain's order, as the last one."""
        self._track.link(observation.points)
        self._in_order = points_in_order(observation)

    def _by_way(self, observation: Observation, last: Floats) -> tuple[bool, float]:
        """Tell by the way from the last midline which way round the next is, and how surely."""
        order, settings = self._order, self._settings
        in_order = points_in_order(observation)
        straight = mean_distance(observation.points, last, in_order & self._in_order)
        turned = mean_distance(observation.points[::-1], last, in_order[::-1] & self._in_order)
        same_path = order.path_number == observation.path_number != 0
        same_path &= order.frames_unexplained <= settings.most_frames_unexplained
        is_reversed = order.is_reversed if same_path else turned < straight
        by_ends = self._by_ends_seen(observation, last)
        is_reversed = is_reversed if by_ends is None else by_ends
        ends_stay = ends_nearer(observation, last)
        ends_differ = not same_path and ends_stay is not None and ends_stay == is_reversed
        seen = observation.reversed() if is_reversed else observation
        near, far = sorted((straight, turned))
        reliability = self._reliability(seen, last, near, far)
        if by_ends is not None:
            reliability = max(reliability, settings.ends_seen_reliability)
        elif ends_differ or self._is_leap(seen.points, last, seen.width):
            reliability = min(reliability, settings.leap_reliability)
        elif same_path:
            reliability = max(reliability, settings.same_path_reliability)
        if seen.explains and order.frames_unexplained > settings.most_frames_unexplained:
            reliability = min(reliability, settings.lost_reliability)
        if any(seen.occluded):
            reliability = min(reliability, ends_kept(seen.points, seen.end_sd_px))
        return is_reversed, reliability

    def _by_ends_seen(self, observation: Observation, last: Floats) -> bool | None:
        """Tell by ends that were seen, and are, whether a midline comes reversed; None if unseen.

        No end goes to where the other was from one frame to the next.
        """
        is_sure = observation.confidence >= self._settings.least_confidence
        if not is_sure or not self._order.ends_seen or self._gap + self._frames_unsure > 1:
            return None
        stay = ends_in_place(observation, last, self._settings.ends_in_place)
        return None if stay is None else not stay

    def _order_told(self, observation: Observation) -> int:
        """Return 1 where a midline's widths tell that it comes in the model's order, -1, or 0."""
        model = self._track.model
        if observation.order_known or model is None or observation.appearance is None:
            return int(observation.order_known)
        return model.order_told(observation.widths)  # as they were measured on an open body

    def _reliability(self, seen: Observation, last: Floats, near: float, far: float) -> float:
        """Return the probability that the nearer of two ways round is the right one."""
        settings = self._settings
        frames = self._gap + self._frames_unsure
        if frames == 1:
            self._mean_step += (near - self._mean_step) / settings.step_memory_frames
        # A body not seen for long may be anywhere. Where even the better way is far off, only the
        # ratio of the two says anything.
        gone = self._mean_step * (frames - 1)
        sd = settings.point_step_sd_widths * seen.width
        reliability = nearer_is_right(near, far, sd**2 * self._gap + gone**2)
        if frames == 1 and reliability < settings.slid_below_reliability:
            # In a coil the turns lie near each other: what counts is the way from where it slid to.
            in_order = points_in_order(seen) & self._in_order
            near = min(near, mean_distance(seen.points, slid(last, self._forward), in_order))
            reliability = nearer_is_right(near, far, sd**2)
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
