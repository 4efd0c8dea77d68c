"""Geometry as the numbers in a `sensor_msgs/JointState`, and as markers for viewers."""

from dataclasses import asdict
from math import asin, cos, isfinite, pi, sin

from geometry_msgs.msg import Point
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.convert.joints import by_prefix, joints_from_msg, joints_to_msg
from worm_msgs_py.convert.message_checks import strict, whole
from worm_msgs_py.convert.stamp import header, stamp_to_ns

_WHOLE = ("version", "picture_width_px", "picture_height_px")
_REAL = ("depth_m", "passage_length_m")
_WALL_POINTS = 180
_WALL_THICKNESS_M = 1e-4


def geometry_to_msg(geometry: Geometry) -> JointState:
    """Write a geometry; a chamber's numbers are named ``chamber_a/centre_u_px`` and so on."""
    values = {name: float(getattr(geometry, name)) for name in (*_WHOLE, *_REAL)}
    for chamber in geometry.chambers:
        for name, value in asdict(chamber).items():
            if name != "name":
                values[f"{chamber.name}/{name}"] = value
        values[f"{chamber.name}/px_per_m"] = chamber.px_per_m
    return joints_to_msg(values, geometry.stamp_ns, CAMERA)


@strict
def geometry_from_msg(msg: JointState) -> Geometry:
    """Read a geometry; MalformedMessage where a number is missing."""
    values = joints_from_msg(msg)
    version, picture_width_px, picture_height_px = (whole(values.pop(name)) for name in _WHOLE)
    depth_m, passage_length_m = (values.pop(name) for name in _REAL)
    chambers = []
    for name, numbers in by_prefix(values):
        numbers.pop("px_per_m", None)
        chamber = Chamber(name=name, **numbers)
        if not (chamber.radius_m > 0.0 and isfinite(chamber.radius_m)):
            raise ValueError(f"{name} has no radius")
        chambers.append(chamber)
    return Geometry(
        version=version,
        stamp_ns=stamp_to_ns(msg.header.stamp),
        picture_width_px=picture_width_px,
        picture_height_px=picture_height_px,
        chambers=tuple(chambers),
        depth_m=depth_m,
        passage_length_m=passage_length_m,
    )


def geometry_to_markers(geometry: Geometry) -> MarkerArray:
    """Draw each chamber's wall, with its exit left open, as a line in the chamber's own frame."""
    return MarkerArray(
        markers=[
            _wall(chamber, index, geometry.stamp_ns)
            for index, chamber in enumerate(geometry.chambers)
        ]
    )


def _wall(chamber: Chamber, index: int, stamp_ns: int) -> Marker:
    has_exit = chamber.exit_width_m > 0
    half = asin(min(1.0, chamber.exit_width_m / (2 * chamber.radius_m))) if has_exit else 0.0
    step = (2 * pi - 2 * half) / _WALL_POINTS
    angles = [half + step * k for k in range(_WALL_POINTS + 1)]
    marker = Marker(
        header=header(stamp_ns, chamber.name),
        ns="chamber",
        id=int(index),
        type=Marker.LINE_STRIP,
        action=Marker.ADD,
        points=[
            Point(x=chamber.radius_m * cos(a), y=chamber.radius_m * sin(a), z=0.0) for a in angles
        ],
        color=ColorRGBA(r=0.2, g=0.2, b=0.2, a=1.0),
    )
    marker.scale.x = _WALL_THICKNESS_M
    marker.pose.orientation.w = 1.0
    return marker
