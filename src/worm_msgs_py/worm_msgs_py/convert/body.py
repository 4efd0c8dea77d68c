"""BodyState as `sensor_msgs/JointState`, and its keypoints as `geometry_msgs/PoseStamped`."""

from dataclasses import fields
from math import cos, sin

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from sensor_msgs.msg import JointState

from worm_msgs_py.contract.body import KEYPOINTS, BodyState, Keypoint
from worm_msgs_py.contract.frames import Where
from worm_msgs_py.contract.status import Status
from worm_msgs_py.convert.joints import joints_from_msg
from worm_msgs_py.convert.message_checks import strict, whole
from worm_msgs_py.convert.stamp import header, stamp_to_ns

_KEYPOINT_FIELDS = tuple(field.name for field in fields(Keypoint))
_WHOLE = ("frame", "geometry")
_REAL = (
    "confidence",
    "head_certainty",
    "length_px",
    "width_px",
    "length_m",
    "width_m",
    "head_sd_m",
)
_JOINT_NAMES = [
    *_WHOLE,
    "where",
    "status",
    *_REAL,
    *(f"{point}_{name}" for point in KEYPOINTS for name in _KEYPOINT_FIELDS),
]


def body_state_to_msg(state: BodyState) -> JointState:
    """Write a state; names are the dataclass's fields, a keypoint's prefixed by its own name."""
    position = [float(getattr(state, name)) for name in _WHOLE]
    position += (float(state.where), float(state.status))
    position += [float(getattr(state, name)) for name in _REAL]
    for point in (state.head, state.centroid, state.tail):
        position += (
            float(point.u_px),
            float(point.v_px),
            float(point.x_m),
            float(point.y_m),
            float(point.yaw_rad),
        )
    return JointState(
        header=header(state.stamp_ns, state.frame_id), name=_JOINT_NAMES, position=position
    )


@strict
def body_state_from_msg(msg: JointState) -> BodyState:
    """Read a state; MalformedMessage where a name is missing, others are left.

    `head_sd_m` may be missing: trackers of others need not say it.
    """
    values = joints_from_msg(msg)
    head, centroid, tail = (
        Keypoint(*(values[f"{point}_{name}"] for name in _KEYPOINT_FIELDS)) for point in KEYPOINTS
    )
    return BodyState(
        frame=whole(values["frame"]),
        stamp_ns=stamp_to_ns(msg.header.stamp),
        frame_id=str(msg.header.frame_id),
        where=Where(whole(values["where"])),
        status=Status(whole(values["status"])),
        geometry=whole(values["geometry"]),
        confidence=values["confidence"],
        head_certainty=values["head_certainty"],
        head=head,
        centroid=centroid,
        tail=tail,
        length_px=values["length_px"],
        width_px=values["width_px"],
        length_m=values["length_m"],
        width_m=values["width_m"],
        head_sd_m=values.get("head_sd_m", 0.0),
    )


def keypoint_to_pose(state: BodyState, keypoint: Keypoint) -> PoseStamped:
    """Write one of a state's keypoints as a pose in the state's frame; z = 0, yaw = heading."""
    half = float(keypoint.yaw_rad) / 2.0
    return PoseStamped(
        header=header(state.stamp_ns, state.frame_id),
        pose=Pose(
            position=Point(x=float(keypoint.x_m), y=float(keypoint.y_m), z=0.0),
            orientation=Quaternion(x=0.0, y=0.0, z=sin(half), w=cos(half)),
        ),
    )
