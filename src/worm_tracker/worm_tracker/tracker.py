"""The tracker: pictures in, one `TrackedFrame` per picture out, in order."""

from collections import Counter, deque
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.body import TrackedFrame
from worm_msgs_py.chamber import Geometry
from worm_msgs_py.errors import NoChamberFound
from worm_msgs_py.status import Status
from worm_tracker.calibration.rig_monitor import Change, RigKeeper
from worm_tracker.detection.detector import Sight
from worm_tracker.follower import Follower
from worm_tracker.frame_state import tracked_frame
from worm_tracker.head_tail import Exchange, ExchangeKind, HeadTail, Verdict, certainty, chained
from worm_tracker.observation import Observation
from worm_tracker.parameters import Polarity, TrackerParameters

Picture = NDArray[np.uint8]
CHECK_STRIDE = 32
"""A picture is judged good or bad by every so many-th pixel of every so many-th row."""


@dataclass(eq=False, slots=True)
class _Held:
    """A frame that waits.

    First, if it is a coil, for a frame after it that tells how the worm lay; `sight` is what must
    be kept for that. Then for the decision which end is the head: its observation is in the
    chain's order now, and its link to the one before has a reliability.
    """

    frame: int
    stamp_ns: int
    seen: Observation
    geometry: Geometry | None
    sight: Sight | None = None
    marks: NDArray[np.float64] | None = None
    reliability: float = 1.0


class Tracker:
    """Tracks one worm.

    Parameters
    ----------
    parameters : TrackerParameters

    Attributes
    ----------
    geometry : Geometry or None
        The rig, once it has been found; a new version whenever it is found again.
    changes : list of Change
        Every later version of the geometry, and why.
    exchanges : list of Exchange
        Each time that head and tail were exchanged, by the tracker or by an operator.
    statuses : Counter
        Frames given so far, by status.

    Examples
    --------
    >>> tracker = Tracker(TrackerParameters(no_chamber=True))
    >>> for picture, stamp_ns in pictures:  # doctest: +SKIP
    ...     for tracked in tracker.push(picture, stamp_ns):
    ...         print(tracked.state.head)
    """

    def __init__(self, parameters: TrackerParameters) -> None:
        self._parameters = parameters
        self.geometry: Geometry | None = None
        self.changes: list[Change] = []
        self.statuses: Counter[Status] = Counter()
        self._follower: Follower | None = None
        self._rig: RigKeeper | None = None
        self._identity = HeadTail()
        self._coiled: deque[_Held] = deque()
        self._held: deque[_Held] = deque()
        self.exchanges: list[Exchange] = []
        self._head_first: bool | None = None
        self._home = ""
        self._frames = 0
        self._failures = 0
        self._last_ns = 0
        self._shape: tuple[int, ...] | None = None

    @property
    def swaps(self) -> int:
        """Times that the tracker has exchanged head and tail from one given frame to the next."""
        return sum(exchange.kind is ExchangeKind.SWAP for exchange in self.exchanges)

    @property
    def held(self) -> int:
        """Frames taken that have not been given yet."""
        return len(self._held) + len(self._coiled)

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Height and width that every picture must have; None until the rig is known."""
        return self._shape

    def push(self, picture: Picture, stamp_ns: int) -> list[TrackedFrame]:
        """Take the next picture.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
            Grey levels.
        stamp_ns : int
            Time of capture.

        Returns
        -------
        list of TrackedFrame
            Frames that are ready, in order; none while which end is the head is being decided.

        Raises
        ------
        NoChamberFound
            Where the first pictures show no chamber (and `no_chamber` was not set).
        """
        frame, self._frames = self._frames, self._frames + 1
        self._last_ns = stamp_ns
        seen = self._observe(picture, stamp_ns)
        held = _Held(frame, stamp_ns, seen, self.geometry)
        if seen.status is Status.COILED and self._follower is not None:
            held.sight = self._follower.sight()
            self._coiled.append(held)
        else:
            held.marks = None if self._follower is None else self._follower.marks(seen)
            self._settle(held)
        return self._release()

    def _settle(self, opened: _Held) -> None:
        """Take the coils before a frame, as that frame tells them, and the frame itself."""
        if self._follower is not None and self._coiled and len(opened.seen.points):
            sights = [held.sight for held in reversed(self._coiled) if held.sight is not None]
            settled = self._follower.settle(opened.seen, sights)
            for held, seen in zip(reversed(self._coiled), settled, strict=False):
                held.seen = seen
        self._link(len(self._coiled))
        self._take(opened)

    def _link(self, count: int) -> None:
        """Take the oldest of the coils as they are now."""
        for _ in range(count):
            self._take(self._coiled.popleft())

    def _take(self, held: _Held) -> None:
        """Link a frame to those before it."""
        held.sight = None
        if len(held.seen.points):
            seen = held.seen
            linked = self._identity.push(seen.points, seen.width, held.marks, seen.confidence)
            held.reliability = linked.reliability
            if linked.flipped:
                held.seen = _turned(seen)
            if linked.verdict is not None:
                self._mend(linked.verdict)
        else:
            self._identity.miss()
        self._held.append(held)

    def _mend(self, verdict: Verdict) -> None:
        """Mend a link that was in doubt, as far as its frames are held: those given are told."""
        after = len(self._held) - verdict.frames
        if after >= 0 and verdict.frames:
            self._held[after].reliability = verdict.reliability
        if not verdict.wrong:
            return
        for k in range(max(after, 0), len(self._held)):
            self._held[k].seen = _turned(self._held[k].seen)
        if after < 0 and self._head_first is not None:
            self._head_first = not self._head_first

    def swap_head(self) -> Exchange | None:
        """Exchange head and tail on an operator's word, for the rest of the trial.

        Returns
        -------
        Exchange or None
            What it applies to: the frames held back and all that come. None where no worm has been
            seen that could be turned round.
        """
        if not self._identity.begun:
            return None
        self._identity.correct()
        oldest = next(iter([*self._held, *self._coiled]), None)
        exchange = Exchange(
            ExchangeKind.CORRECTION,
            oldest.frame if oldest else self._frames,
            oldest.stamp_ns if oldest else self._last_ns,
            certainty(self._identity.log_odds),
        )
        self.exchanges.append(exchange)
        self._head_first = None
        return exchange

    def finish(self) -> list[TrackedFrame]:
        """Return the frames that are still held back; the film is over.

        Raises
        ------
        NoChamberFound
            Where pictures came, but none with a chamber.
        """
        if self._follower is None and self._failures:
            self._give_up()
        self._link(len(self._coiled))
        return self._give(len(self._held))

    def _observe(self, picture: Picture, stamp_ns: int) -> Observation:
        """Return what the picture says, calibrating first."""
        bad = not _well_formed(picture) or (
            self._shape is not None and picture.shape != self._shape
        )
        if bad:
            return Observation(Status.BAD_IMAGE)
        if self._parameters.polarity is Polarity.BRIGHT:
            picture = np.asarray(cv2.bitwise_not(picture), np.uint8)
        if self._follower is None or self._rig is None:
            return self._begin(picture, stamp_ns)
        if not _informative(picture):
            return Observation(Status.BAD_IMAGE)
        change = self._rig.check(picture, stamp_ns, self._follower.outline)
        if change is not None:
            self._link(len(self._coiled))  # they lie where the rig was
            self._follower.move(picture, self._rig.supposed, change.motion)
            self.geometry = change.geometry
            self.changes.append(change)
        return self._follower.push(picture)

    def _begin(self, picture: Picture, stamp_ns: int) -> Observation:
        """Calibrate on one of the first pictures and start to follow the worm."""
        if self._parameters.no_chamber and not _informative(picture):
            return Observation(Status.BAD_IMAGE)
        try:
            self._rig = RigKeeper(picture, self._parameters, stamp_ns)
        except NoChamberFound as error:
            self._failures += 1
            self._why = error
            if self._failures >= self._parameters.calibration_frames:
                self._give_up()
            return Observation(Status.NO_CHAMBER if _informative(picture) else Status.BAD_IMAGE)
        self._shape = picture.shape
        self._follower = Follower(picture, self._rig.supposed)
        seen = self._follower.push(picture)
        self._rig.doubt(self._follower.outline)
        self.geometry = self._rig.geometry
        return seen

    def _give_up(self) -> None:
        raise NoChamberFound(str(self._why))

    def _release(self) -> list[TrackedFrame]:
        """Return the frames that need not wait any longer."""
        over = self.held - self._parameters.hold_back_frames
        self._link(min(len(self._coiled), over - len(self._held)))
        if self._identity.certain:
            return self._give(len(self._held))
        free = 0
        for held in self._held:
            if len(held.seen.points):
                break
            free += 1
        return self._give(max(free, min(over, len(self._held))))

    def _give(self, count: int) -> list[TrackedFrame]:
        """Return the oldest frames with the head as it is known by now."""
        if count <= 0:
            return []
        odds = self._identity.log_odds
        sure = certainty(odds)
        certainties = []
        for held in reversed(self._held):
            certainties.append(sure)
            sure = chained(sure, held.reliability)
        certainties.reverse()
        given = []
        for k in range(count):
            held = self._held.popleft()
            if len(held.seen.points):
                self._note_exchange(odds >= 0, held, certainties[k])
            tracked = tracked_frame(
                held.frame,
                held.stamp_ns,
                held.seen,
                odds >= 0,
                certainties[k],
                held.geometry,
                self._parameters.px_per_mm,
                self._home,
            )
            self._home = tracked.state.frame_id
            given.append(tracked)
            self.statuses[held.seen.status] += 1
        return given

    def _note_exchange(self, head_first: bool, held: _Held, sure: float) -> None:
        """Note where a frame is given whose head is the end that was the tail before it."""
        if self._head_first is not None and head_first != self._head_first:
            self.exchanges.append(Exchange(ExchangeKind.SWAP, held.frame, held.stamp_ns, sure))
        self._head_first = head_first


def _turned(seen: Observation) -> Observation:
    """Return an observation with its midline the other way round."""
    return replace(
        seen, points=seen.points[::-1], widths=seen.widths[::-1], hidden=seen.hidden[::-1]
    )


def _well_formed(picture: Picture) -> bool:
    """Tell whether this is a grey picture large enough to hold a worm."""
    return (
        isinstance(picture, np.ndarray)
        and picture.ndim == 2
        and picture.dtype == np.uint8
        and min(picture.shape) >= 16
    )


def _informative(picture: Picture) -> bool:
    """Tell whether a picture is neither black, nor saturated, nor of one grey level."""
    stride = max(1, min(CHECK_STRIDE, min(picture.shape) // 16))
    sparse = picture[::stride, ::stride]
    low, high = int(sparse.min()), int(sparse.max())
    return high > low and high > 3 and low < 252
