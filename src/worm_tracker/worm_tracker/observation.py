"""What one picture says of the worm, before anyone knows which end is the head."""

from dataclasses import dataclass, field, replace

import numpy as np

from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.detection import Detection


@dataclass(frozen=True, eq=False, slots=True)
class Observation:
    """What one picture says of the worm, before anyone knows which end is the head.

    Attributes
    ----------
    status : Status
    u, v : float
        Centroid of the body's area, pixels; NaN where there is none.
    points, widths : ndarray
        Midline (TRACKED_POINTS, 2) and widths (TRACKED_POINTS,); empty where there is none.
    confidence : float
        How well the body explains the picture, 0 to 1.
    width : float
        Mean distance of the half-height edges over the middle half; NaN where there is no midline.
    occluded : tuple of int
        How many points at the midline's first, and last, end were not seen but supposed.
    appearance : ndarray, shape (n,), or None
        How the first half of an open body differs in width and darkness from the last one.
    end_sd_px : tuple of float
        How surely the ends of a folded body are where they are said to be, pixels.
    seen_end_sd_px : tuple of float
        The same by what is seen of them and their way alone: how well the worm keeps its length,
        which is all that tells an end on a body of one shade, is not counted.
    broad_ends : tuple of bool
        Of each end whether the object is broader there than the body: it is bent back, maybe, and
        not where it is supposed.
    in_doubt : tuple of int
        From which of the midline's points to before which it lies in loops that may be passed
        either way round; (0, 0) where there are none.
    unresolved : Detection or None
        Where the body is coiled, or folded with a hidden end: what a later frame needs to tell how
        it lay.
    kept : Detection or None
        What was seen of a body that is not known well yet: it may turn out not to be the worm's.
    followed : Observation or None
        Where the body was followed into a coil, but does not explain all of it: how it may lie.
        Not told, but which end is which is carried on by it.
    over_limits : float
        What its midline leaves over of the object, over what it may.
    overlaps_tell : bool
        Whether overlaps are known to be darker, so that they show what lies in them.
    by_marks : bool
        Whether marks alone tell of some loop which way round it is passed.
    order_known : bool
        Whether its widths or its marks tell that its ends come in the order of the body model.
    path_number : int
        Of the path that the body is slid along, from 1 on, or from -1 down on a way back; 0 where
        it is not. Midlines of one path have the same order of the ends, however near to itself the
        body lies.
    """

    status: Status
    u: float = float("nan")
    v: float = float("nan")
    points: Floats = field(default_factory=lambda: np.empty((0, 2)))
    widths: Floats = field(default_factory=lambda: np.empty(0))
    confidence: float = 0.0
    width: float = float("nan")
    occluded: tuple[int, int] = (0, 0)
    appearance: Floats | None = None
    end_sd_px: tuple[float, float] = (0.0, 0.0)
    seen_end_sd_px: tuple[float, float] = (0.0, 0.0)
    broad_ends: tuple[bool, bool] = (False, False)
    in_doubt: tuple[int, int] = (0, 0)
    unresolved: Detection | None = None
    kept: Detection | None = None
    followed: "Observation | None" = None
    over_limits: float = 0.0
    overlaps_tell: bool = False
    by_marks: bool = False
    order_known: bool = False
    path_number: int = 0

    @property
    def has_midline(self) -> bool:
        """Whether the body was resolved."""
        return len(self.points) > 0

    @property
    def loops_known(self) -> bool:
        """Whether it is known which way round the loops of a folded body are passed."""
        return self.in_doubt == (0, 0)

    @property
    def may_lie_as(self) -> "Observation | None":
        """How the body may lie, where that is not known for all of it between its ends."""
        return self.followed if self.loops_known else self

    @property
    def shown_points(self) -> Mask:
        """Which of the midline's points are at no hidden end, shape (n,)."""
        first, last = self.occluded
        shown = np.ones(len(self.points), bool)
        shown[:first] = shown[len(shown) - last :] = False
        return shown

    @property
    def told_points(self) -> Mask:
        """Which of the midline's points are told: neither hidden nor in doubt, shape (n,)."""
        told = self.shown_points
        told[slice(*self.in_doubt)] = False
        return told

    @property
    def shows_all(self) -> bool:
        """Whether all of its midline is told."""
        return self.loops_known and not any(self.occluded)

    @property
    def shows_pose(self) -> bool:
        """Whether it gives a pose, and all of the midline."""
        return self.status.has_pose and self.shows_all

    @property
    def is_mostly_hidden(self) -> bool:
        """Whether nothing is told of it, or, with a hidden end, less than a quarter."""
        told = self.told_points
        return not told.any() or (any(self.occluded) and bool(told.sum() < len(told) / 4))

    @property
    def explains(self) -> bool:
        """Whether what its midline leaves over of the object is within limits."""
        return self.over_limits <= 1

    @property
    def seen(self) -> Detection | None:
        """What was kept of its picture, for whatever reason."""
        return self.unresolved or self.kept

    def on_path(self, number: int) -> "Observation":
        """Return the observation, and what was followed in it, with the number of its path."""
        followed = self.followed and replace(self.followed, path_number=number)
        return replace(self, path_number=number, followed=followed)

    def contradicts(self, other: "Observation") -> bool:
        """Tell whether both explain a picture, but at most one is right to a width."""
        explain = self.explains and other.explains
        return explain and self.apart_px(other) > 2 * other.width

    def apart_px(self, other: "Observation") -> float:
        """Return how far apart two midlines of a picture are, in either order; 0 without both.

        By what both tell, if that is a quarter of the body or more: a loop in doubt may be passed
        as the other has it.
        """
        if not (self.has_midline and other.has_midline):
            return 0.0
        away = np.inf
        for one in (self, self.reversed()):
            told = one.told_points & other.told_points
            if told.sum() < len(told) / 4:
                told = one.shown_points & other.shown_points
            apart = np.hypot(*(one.points[told] - other.points[told]).T)
            away = min(away, float(apart.max(initial=0.0)))
        return away

    def reversed(self) -> "Observation":
        """Return the observation with its midline the other way round."""
        return replace(
            self,
            points=self.points[::-1],
            widths=self.widths[::-1],
            occluded=self.occluded[::-1],
            broad_ends=self.broad_ends[::-1],
            in_doubt=self._in_doubt_reversed(),
            end_sd_px=self.end_sd_px[::-1],
            seen_end_sd_px=self.seen_end_sd_px[::-1],
            appearance=None if self.appearance is None else -self.appearance,
        )

    def _in_doubt_reversed(self) -> tuple[int, int]:
        if self.loops_known:
            return self.in_doubt
        first, behind = self.in_doubt
        return len(self.points) - behind, len(self.points) - first
