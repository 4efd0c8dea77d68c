"""Turns a grey picture into a serialised sensor_msgs/CompressedImage: PNG, or JPEG where asked."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE

_PNG_SPEED = [cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE]
"""Half the time of the fastest deflate, and a smaller file, on pictures with a camera's noise."""
_TYPESTORE = get_typestore(Stores.ROS2_JAZZY)


def compressed_message(picture: NDArray[Any], stamp_ns: int, jpeg_quality: int | None) -> bytes:
    """Return a serialised CompressedImage: a PNG, or a JPEG of a quality.

    Raises
    ------
    BadInput
        A JPEG of 16 bits is asked for, or the picture cannot be encoded.
    """
    if jpeg_quality is None:
        done, data = cv2.imencode(".png", picture, _PNG_SPEED)
    else:
        if picture.dtype != np.uint8:
            raise BadInput("JPEG holds 8 bits and the pictures have 16; leave --jpeg-quality out")
        done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, jpeg_quality])
    if not done:
        height, width = picture.shape
        raise BadInput(f"a picture of {width} × {height} pixels cannot be encoded")
    seconds, nanoseconds = divmod(stamp_ns, NS_PER_S)
    time = _TYPESTORE.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    header = _TYPESTORE.types["std_msgs/msg/Header"](stamp=time, frame_id=CAMERA)
    kind = "png" if jpeg_quality is None else "jpeg"
    message = _TYPESTORE.types[COMPRESSED_TYPE](
        header=header, format=kind, data=np.asarray(data, np.uint8).ravel()
    )
    return bytes(_TYPESTORE.serialize_cdr(message, COMPRESSED_TYPE))
