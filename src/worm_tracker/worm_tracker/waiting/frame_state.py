"""From an observation, its head and the rig to what the tracker says of a frame."""

from dataclasses import dataclass, replace
from math import atan2, hypot, inf, isfinite, nan

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import BodyState, Keypoint, Midline, TrackedFrame
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.frames import CAMERA, CHAMBER_A, Where
from worm_msgs_py.contract.locating import is_in_passage
from worm_msgs_py.contract.status import Status
from worm_msgs_py.units import MM_PER_M
from worm_tracker.frame_intervals import AT_ONCE, Elapsed
from worm_tracker.head_tail.certainty import LEAST_CERTAINTY
from worm_tracker.midline.curve import arc_length
from worm_tracker.observation import Observation

_UNKNOWN = np.full(2, nan)
END_PART = 0.1
"""Part of the midline over which the direction of either end is taken."""


@dataclass(eq=False, slots=True)
class PendingFrame:
    """A frame that waits.

    Attributes
    ----------
    frame, stamp_ns : int
    observation : Observation
        What its picture says; in the chain's order once it has been linked.
    geometry : Geometry or None
        The rig in it.
    elapsed : Elapsed
        What lies between it and the frame before.
    reliability : float
        Of its link to the frame before, 0.5 to 1.
    own_reliability : float
        How surely its own ends are in the order of the frames linked, 0.5 to 1: what lies before
        and behind it does not hang on that.
    first_is_head : float
        How probable it is that its first end is the head by what was known when it was linked;
        0.5 where that is no longer believed.
    """

    frame: int
    stamp_ns: int
    observation: Observation
    geometry: Geometry | None
    elapsed: Elapsed = AT_ONCE
    reliability: float = 1.0
    own_reliability: float = 1.0
    first_is_head: float = LEAST_CERTAINTY

    @property
    def is_open(self) -> bool:
        """Whether it shows all of the body."""
        return self.observation.has_midline and self.observation.unresolved is None

    def turn_round(self) -> None:
        """Put its midline in the other order: it was linked the wrong way round."""
        self.observation = self.observation.reversed()
        self.first_is_head = 1 - self.first_is_head


def tracked_frame(
    pending: PendingFrame,
    head_first: bool,
    head_certainty: float,
    px_per_mm: float = nan,
    home: str = "",
) -> TrackedFrame:
    """Put together all that is said of one frame.

    Parameters
    ----------
    pending : PendingFrame
    head_first : bool
        Whether its midline's first point is the head.
    head_certainty : float
        How sure that is, 0.5 to 1.
    px_per_mm : float
        Scale of pictures without a chamber; NaN where it is not known.
    home : str
        `frame_id` of the frame before, the chamber that a head in the passage came from; empty
        for the first frame.
    """
    seen = pending.observation if head_first else pending.observation.reversed()
    geometry = pending.geometry
    points, body, centre = seen.points, seen.has_midline, np.array([seen.u, seen.v])
    chamber, where = locate(geometry, points[0] if body else centre, home)
    scale = MM_PER_M * px_per_mm if chamber is None else chamber.px_per_m
    length = float(arc_length(points)[-1]) if body and not any(seen.occluded) else nan
    head_seen = body and not seen.occluded[0]
    head, tail = _tips(seen, chamber, scale)
    state = BodyState(
        frame=pending.frame,
        stamp_ns=pending.stamp_ns,
        frame_id=chamber.name if chamber else CAMERA,
        where=where if head_seen else Where.UNKNOWN,
        status=seen.status,
        geometry=geometry.version if chamber and geometry else 0,
        confidence=seen.confidence,
        head_certainty=head_certainty if body else 0.5,
        head=head,
        centroid=_keypoint(centre, points[0] - centre if head_seen else _UNKNOWN, chamber, scale),
        tail=tail,
        length_px=length,
        width_px=seen.width,
        length_m=length / scale,
        width_m=seen.width / scale,
        head_sd_m=seen.end_sd_px[0] / scale if head_seen else 0.0,
    )
    midline = _midline(seen, chamber, scale) if body else Midline.empty()
    return TrackedFrame(state, midline, geometry)


def taken_back(frame: TrackedFrame) -> TrackedFrame:
    """Return a frame without its pose: how the body lies is not known."""
    state = replace(
        frame.state,
        status=Status.COILED,
        where=Where.UNKNOWN,
        confidence=0.0,
        head_certainty=0.5,
        head=Keypoint(),
        centroid=replace(frame.state.centroid, yaw_rad=nan),
        tail=Keypoint(),
        length_px=nan,
        width_px=nan,
        length_m=nan,
        width_m=nan,
        head_sd_m=0.0,
    )
    return replace(frame, state=state, midline=Midline.empty())


def _tips(seen: Observation, chamber: Chamber | None, scale: float) -> tuple[Keypoint, Keypoint]:
    """Return head and tail of an observation, head first; without coordinates if not seen.

    Without a direction where the midline beside them may be another.
    """
    points, head, tail = seen.points, Keypoint(), Keypoint()
    last = len(points) - 1
    first_in_doubt, behind = (last, 0) if seen.loops_known else seen.in_doubt
    if seen.has_midline and not seen.occluded[0]:
        ahead = points[0] - _point_at(points, END_PART)
        ahead = ahead if first_in_doubt > END_PART * last else _UNKNOWN
        head = _keypoint(points[0], ahead, chamber, scale)
    if seen.has_midline and not seen.occluded[1]:
        ahead = _point_at(points, 1 - END_PART) - points[-1]
        ahead = ahead if behind - 1 < (1 - END_PART) * last else _UNKNOWN
        tail = _keypoint(points[-1], ahead, chamber, scale)
    return head, tail


def _midline(seen: Observation, chamber: Chamber | None, scale: float) -> Midline:
    """Return the midline of an observation, head first; NaN where it was not seen."""
    points, widths = seen.points, seen.widths.copy()
    s = arc_length(points)
    if not seen.shows_all:
        unseen = ~seen.told_points
        points, s[unseen], widths[unseen] = points.copy(), nan, nan
        points[unseen] = nan
    x, y = _metres(points[:, 0], points[:, 1], chamber, scale)
    u, v = np.ascontiguousarray(points.T)
    return Midline(u, v, x, y, s, widths)


def _keypoint(point: Floats, direction: Floats, chamber: Chamber | None, scale: float) -> Keypoint:
    """Return a point of the body, in the picture and in its frame."""
    u, v = float(point[0]), float(point[1])
    x, y = _metres(u, v, chamber, scale)
    if chamber is None:
        yaw = atan2(direction[1], direction[0])  # y down: clockwise as seen
    else:
        yaw = chamber.yaw(atan2(-direction[1], direction[0]))
    return Keypoint(u, v, x, y, float(yaw))


def _metres(u, v, chamber: Chamber | None, scale: float):  # type: ignore[no-untyped-def]
    """Return metric coordinates in the chamber's frame, or in the camera's where there is none."""
    if chamber is None:
        return u / scale, v / scale
    return chamber.to_metres(u, v)


def _point_at(points: Floats, part: float) -> Floats:
    """Return the point at a part of the length; the points are at equal steps."""
    at = part * (len(points) - 1)
    k = min(int(at), len(points) - 2)
    return np.asarray(points[k] + (at - k) * (points[k + 1] - points[k]))


def locate(geometry: Geometry | None, head: Floats, home: str = "") -> tuple[Chamber | None, Where]:
    """Tell which part of the rig holds a head, and in whose frame its coordinates are given.

    Parameters
    ----------
    geometry : Geometry or None
        The rig.
    head : ndarray, shape (2,)
        (u, v); NaN where nothing is known.
    home : str
        The chamber that the head was in last; empty where that is not known.

    Returns
    -------
    chamber : Chamber or None
        The one that holds the head; for a head in the passage the one it came from (the nearest
        where that is not known); None without a rig.
    where : Where
    """
    if geometry is None or not geometry.chambers:
        return None, Where.UNKNOWN
    chambers = geometry.chambers
    known = next((chamber for chamber in chambers if chamber.name == home), None)
    if not isfinite(head[0]):
        return known or chambers[0], Where.UNKNOWN
    out = [
        float(hypot(head[0] - c.centre_u_px, head[1] - c.centre_v_px)) / c.radius_px
        for c in chambers
    ]
    nearest = chambers[out.index(min(out))]
    if any(_in_passage(chamber, geometry, head, min(out)) for chamber in chambers):
        return known or nearest, Where.PASSAGE
    return nearest, Where.CHAMBER_A if nearest.name == CHAMBER_A else Where.CHAMBER_B


def _in_passage(chamber: Chamber, geometry: Geometry, head: Floats, out: float) -> bool:
    x, y = chamber.to_metres(float(head[0]), float(head[1]))
    length_m = geometry.passage_length_m if len(geometry.chambers) > 1 else inf
    return bool(is_in_passage(x, y, out, chamber.radius_m, chamber.exit_width_m, length_m))
