"""From an observation, its head and the rig to what the tracker says of a frame."""

from math import atan2, isfinite

import numpy as np

from worm_msgs_py.body import BodyState, Keypoint, Midline, TrackedFrame
from worm_msgs_py.chamber import Chamber, Geometry
from worm_msgs_py.frames import CAMERA, CHAMBER_A, Where
from worm_tracker.following import Observation
from worm_tracker.outline import Floats, arc_length

NAN = float("nan")
PASSAGE_SLACK = 1.2
"""How much wider than the exit the stretch is that counts as the passage: the head is a point on
the body's edge, and W is known to a pixel."""


def tracked_frame(
    frame: int,
    stamp_ns: int,
    seen: Observation,
    head_first: bool,
    head_certainty: float,
    geometry: Geometry | None,
    px_per_mm: float = NAN,
) -> TrackedFrame:
    """Put together all that is said of one frame.

    Parameters
    ----------
    frame, stamp_ns : int
        Number and stamp of the frame.
    seen : Observation
        What the picture says.
    head_first : bool
        Whether the midline's first point is the head.
    head_certainty : float
        How sure that is, 0.5 to 1.
    geometry : Geometry or None
        The rig; None where it has not been found yet.
    px_per_mm : float
        Scale of pictures without a chamber; NaN where it is not known.
    """
    points = seen.points if head_first else seen.points[::-1]
    widths = seen.widths if head_first else seen.widths[::-1]
    anchor = points[0] if len(points) else np.array([seen.u, seen.v])
    chamber = _nearest(geometry, anchor)
    scale = 1e3 * px_per_mm if chamber is None else chamber.px_per_m
    body = len(points) > 0
    length = float(arc_length(points)[-1]) if body else NAN
    head, tail = (Keypoint(), Keypoint())
    if body:
        head = _keypoint(points[0], points[0] - _along(points, 0.1), chamber, scale)
        tail = _keypoint(points[-1], _along(points, 0.9) - points[-1], chamber, scale)
    centre = np.array([seen.u, seen.v])
    heading = points[0] - centre if body else np.full(2, NAN)
    state = BodyState(
        frame=frame,
        stamp_ns=stamp_ns,
        frame_id=chamber.name if chamber else CAMERA,
        where=_where(chamber, anchor) if body else Where.UNKNOWN,
        status=seen.status,
        geometry=geometry.version if chamber and geometry else 0,
        confidence=seen.confidence,
        head_certainty=head_certainty if body else 0.5,
        head=head,
        centroid=_keypoint(centre, heading, chamber, scale),
        tail=tail,
        length_px=length,
        width_px=seen.width,
        length_m=length / scale,
        width_m=seen.width / scale,
    )
    if not body:
        return TrackedFrame(state, Midline.empty())
    x, y = _metres(points[:, 0], points[:, 1], chamber, scale)
    u, v = np.ascontiguousarray(points.T)
    return TrackedFrame(state, Midline(u, v, x, y, arc_length(points), widths.copy()))


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


def _along(points: Floats, part: float) -> Floats:
    """Return the point at a part of the length; the points are at equal steps."""
    at = part * (len(points) - 1)
    k = min(int(at), len(points) - 2)
    return np.asarray(points[k] + (at - k) * (points[k + 1] - points[k]))


def _nearest(geometry: Geometry | None, point: Floats) -> Chamber | None:
    """Return the chamber whose centre is nearest, ``chamber_a`` where there is no point."""
    if geometry is None or not geometry.chambers:
        return None
    if not isfinite(point[0]):
        return geometry.chambers[0]
    return min(
        geometry.chambers,
        key=lambda c: float(np.hypot(point[0] - c.centre_u_px, point[1] - c.centre_v_px)),
    )


def _where(chamber: Chamber | None, head: Floats) -> Where:
    """Return the part of the rig that holds the head."""
    if chamber is None:
        return Where.UNKNOWN
    x, y = chamber.to_metres(float(head[0]), float(head[1]))
    beyond = x > 0 and float(np.hypot(x, y)) > chamber.radius_m
    if beyond and abs(y) < PASSAGE_SLACK * chamber.exit_width_m / 2:
        return Where.PASSAGE
    return Where.CHAMBER_A if chamber.name == CHAMBER_A else Where.CHAMBER_B
