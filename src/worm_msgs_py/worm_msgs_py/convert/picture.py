"""A picture as `sensor_msgs/Image`, and a file of one as `sensor_msgs/CompressedImage`."""

import array

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CompressedImage, Image

from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.convert.stamp import header


def picture_to_msg(picture: NDArray[np.uint8], stamp_ns: int, frame_id: str = CAMERA) -> Image:
    """Write a grey picture, shape (height, width), as mono8.

    `array.array` is what the generated message takes without a copy a byte at a time: half a
    millisecond a megapixel, where an ndarray takes sixty.
    """
    height, width = picture.shape
    data = array.array("B")
    data.frombytes(picture.tobytes())
    return Image(
        header=header(stamp_ns, frame_id),
        height=int(height),
        width=int(width),
        encoding="mono8",
        is_bigendian=0,
        step=int(width),
        data=data,
    )


def compressed_to_msg(
    file: bytes, form: str, stamp_ns: int, frame_id: str = CAMERA
) -> CompressedImage:
    """Write a JPEG or PNG file; `form` as image_transport names it, such as ``jpeg``."""
    data = array.array("B")
    data.frombytes(file)
    return CompressedImage(header=header(stamp_ns, frame_id), format=str(form), data=data)
