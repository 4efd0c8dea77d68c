"""Transforms and annotations as ROS messages of packages that have no wheel, in serialised form.

`tf2_msgs` comes with rosbags' types. The annotations are Foxglove's: their fields are those of
`foxglove_msgs` (https://github.com/foxglove/foxglove-sdk, schemas/ros2, MIT), written down here.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from worm_bringup.overlay.shapes import Circle, Ink, Polyline, Shapes
from worm_msgs_py import convert, topics
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.camera_view import CAMERA_OVER_RIG, Pinhole, RigidTransform
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.serialized_images import with_stamp

TF_TYPE = "tf2_msgs/msg/TFMessage"
ANNOTATIONS_TYPE = "foxglove_msgs/msg/ImageAnnotations"
CAMERA_INFO_TYPE = "sensor_msgs/msg/CameraInfo"
TYPE_OF_TOPIC = {
    topics.CAMERA_INFO: CAMERA_INFO_TYPE,
    topics.TF_STATIC: TF_TYPE,
    topics.TF: TF_TYPE,
    topics.WORM_ANNOTATIONS: ANNOTATIONS_TYPE,
}
"""Of what is laid over the picture."""

_DEFINITIONS = {
    "Point2": "float64 x\nfloat64 y",
    "Color": "float64 r\nfloat64 g\nfloat64 b\nfloat64 a",
    "CircleAnnotation": "builtin_interfaces/Time timestamp\nfoxglove_msgs/Point2 position\n"
    "float64 diameter\nfloat64 thickness\nfoxglove_msgs/Color fill_color\n"
    "foxglove_msgs/Color outline_color",
    "PointsAnnotation": "uint8 UNKNOWN=0\nuint8 POINTS=1\nuint8 LINE_LOOP=2\nuint8 LINE_STRIP=3\n"
    "uint8 LINE_LIST=4\nbuiltin_interfaces/Time timestamp\nuint8 type\n"
    "foxglove_msgs/Point2[] points\nfoxglove_msgs/Color outline_color\n"
    "foxglove_msgs/Color[] outline_colors\nfoxglove_msgs/Color fill_color\nfloat64 thickness",
    "TextAnnotation": "builtin_interfaces/Time timestamp\nfoxglove_msgs/Point2 position\n"
    "string text\nfloat64 font_size\nfoxglove_msgs/Color text_color\n"
    "foxglove_msgs/Color background_color",
    "ImageAnnotations": "foxglove_msgs/CircleAnnotation[] circles\n"
    "foxglove_msgs/PointsAnnotation[] points\nfoxglove_msgs/TextAnnotation[] texts",
}
_LINE_STRIP = 3
_TO_CORNER_PX = 0.5
"""Foxglove counts from the corner of the upper left pixel, we from its centre."""
_TEXT_PX, _TEXT_AT_PX = 16.0, (6.0, 22.0)


def _types() -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, definition in _DEFINITIONS.items():
        store.register(get_types_from_msg(definition, f"foxglove_msgs/msg/{name}"))
    return store


TYPES = _types()
"""The type store that knows all messages of a bag."""
_OF = TYPES.types
_TIME, _HEADER = _OF["builtin_interfaces/msg/Time"], _OF["std_msgs/msg/Header"]
_VECTOR, _QUATERNION = _OF["geometry_msgs/msg/Vector3"], _OF["geometry_msgs/msg/Quaternion"]
_TRANSFORM = _OF["geometry_msgs/msg/Transform"]
_STAMPED = _OF["geometry_msgs/msg/TransformStamped"]
_POINT, _COLOR = _OF["foxglove_msgs/msg/Point2"], _OF["foxglove_msgs/msg/Color"]
_CIRCLE, _POLYLINE, _TEXT = (
    _OF[f"foxglove_msgs/msg/{name}Annotation"] for name in ("Circle", "Points", "Text")
)
_NO_COLOR = _COLOR(r=0.0, g=0.0, b=0.0, a=0.0)


def warm_up() -> None:
    """Let rosbags write the code that serialises, as it does with a type's first message."""
    ink = Ink("#000000")
    shapes = Shapes((Circle(0.0, 0.0, 1.0, ink), Polyline(np.zeros((2, 2)), ink)), "warm")
    shapes_to_cdr(shapes, 0)
    transforms_to_cdr([CAMERA_OVER_RIG], 0)


def camera_to_cdr(camera: Pinhole, stamp_ns: int) -> bytes:
    """Serialise a camera as one `sensor_msgs/CameraInfo`."""
    return with_stamp(_camera(camera), stamp_ns)


@lru_cache(maxsize=4)
def _camera(camera: Pinhole) -> bytes:
    raw = convert.camera_info_to_cdr(camera, 0)
    message = TYPES.deserialize_cdr(raw, CAMERA_INFO_TYPE)
    return bytes(TYPES.serialize_cdr(message, CAMERA_INFO_TYPE))  # rclpy leaves padding as it was


def transforms_to_cdr(transforms: Iterable[RigidTransform], stamp_ns: int) -> bytes:
    """Serialise transforms as one `tf2_msgs/TFMessage`."""
    time = _TIME(*divmod(stamp_ns, NS_PER_S))
    items = [
        _STAMPED(
            header=_HEADER(stamp=time, frame_id=item.parent),
            child_frame_id=item.child,
            transform=_TRANSFORM(
                translation=_VECTOR(item.x_m, item.y_m, item.z_m),
                rotation=_QUATERNION(*item.quaternion),
            ),
        )
        for item in transforms
    ]
    return bytes(TYPES.serialize_cdr(_OF[TF_TYPE](transforms=items), TF_TYPE))


def shapes_to_cdr(shapes: Shapes, stamp_ns: int) -> bytes:
    """Serialise what is drawn over a picture as one `foxglove_msgs/ImageAnnotations`.

    One message has all of a frame, so that nothing of the frame before stays.
    """
    time = _TIME(*divmod(stamp_ns, NS_PER_S))
    texts = [_text(shapes.text, time)] if shapes.text else []
    message = _OF[ANNOTATIONS_TYPE](
        circles=[_circle_msg(circle, time) for circle in shapes.circles],
        points=[_polyline_msg(line, time) for line in shapes.lines],
        texts=texts,
    )
    return bytes(TYPES.serialize_cdr(message, ANNOTATIONS_TYPE))


def _circle_msg(circle: Circle, time: Any) -> Any:
    colour = _colour(circle.ink)
    return _CIRCLE(
        timestamp=time,
        position=_point(circle.u_px, circle.v_px),
        diameter=2 * float(circle.radius_px),
        thickness=circle.thick_px,
        fill_color=colour if circle.filled else _NO_COLOR,
        outline_color=colour,
    )


def _polyline_msg(line: Polyline, time: Any) -> Any:
    return _POLYLINE(
        timestamp=time,
        type=_LINE_STRIP,
        points=_point_msgs(line.points_px),
        outline_color=_colour(line.ink),
        outline_colors=[],
        fill_color=_NO_COLOR,
        thickness=line.thick_px,
    )


def _text(text: str, time: Any) -> Any:
    return _TEXT(
        timestamp=time,
        position=_point(*_TEXT_AT_PX),
        text=text,
        font_size=_TEXT_PX,
        text_color=_COLOR(r=1.0, g=1.0, b=1.0, a=1.0),
        background_color=_COLOR(r=0.0, g=0.0, b=0.0, a=0.7),
    )


@lru_cache(maxsize=64)
def _colour(ink: Ink) -> Any:
    red, green, blue = (part / 255 for part in bytes.fromhex(ink.colour[1:]))
    return _COLOR(r=red, g=green, b=blue, a=ink.opacity)


def _point(u_px: float, v_px: float) -> Any:
    return _POINT(float(u_px) + _TO_CORNER_PX, float(v_px) + _TO_CORNER_PX)


def _point_msgs(points_px: Floats) -> list[Any]:
    return [_POINT(u, v) for u, v in (np.asarray(points_px) + _TO_CORNER_PX).tolist()]
