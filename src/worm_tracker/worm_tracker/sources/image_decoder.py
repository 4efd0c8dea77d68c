"""Turns the pictures that cameras and bags hold into grey ones of eight bits."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.errors import BadInput, BadPicture
from worm_msgs_py.limits import Limit
from worm_tracker.sources.jpeg_png import JPEG, PNG, size_of_whole

Grey = NDArray[np.uint8]

IMAGE_TYPE = "sensor_msgs/msg/Image"
COMPRESSED_TYPE = "sensor_msgs/msg/CompressedImage"

MEGAPIXELS = Limit(1e-3, 1e4, "megapixels")
MAX_MEGAPIXELS = 64.0
"""Largest picture that is decoded where nothing else is asked for."""

ENCODINGS = ("mono8", "mono16", "bgr8", "rgb8")
"""What is read of `sensor_msgs/Image`."""
FORMATS = ("jpeg", "png")
"""What is read of `sensor_msgs/CompressedImage`."""

_BYTES_PER_PIXEL = {"mono8": 1, "mono16": 2, "bgr8": 3, "rgb8": 3}
_MAGIC = {"jpeg": JPEG, "png": PNG}
_DEPTHS = (8, 10, 12, 14, 16)
# A grey picture of the depth that the file has, never turned by what a camera wrote into EXIF:
# pixel coordinates are those of the sensor.
_DECODE_FLAGS = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION


class PictureDecoder:
    """Decodes the messages of one source.

    A decoder belongs to one source because `mono16` does not say how many of its bits carry light
    (a 12-bit camera fills 0 to 4095). The first picture that is not all black decides: the
    smallest of 8, 10, 12, 14 and 16 bits that holds its maximum. Later pictures are scaled alike,
    and saturate, so that the grey levels of a recording depend on the recording alone.

    Parameters
    ----------
    max_megapixels : float
        Larger pictures are refused before they are decoded.
    """

    def __init__(self, max_megapixels: float = MAX_MEGAPIXELS) -> None:
        self._bits: int | None = None
        self._max_megapixels = max_megapixels

    @property
    def significant_bits(self) -> int | None:
        """Bits that carry light in 16-bit pictures; None until one was seen."""
        return self._bits

    def decode(self, message: Any) -> Grey:
        """Return the picture of a message.

        Parameters
        ----------
        message : sensor_msgs.msg.Image or sensor_msgs.msg.CompressedImage
            Or anything with the same attributes, such as what `rosbags` reads.

        Returns
        -------
        ndarray, shape (h, w), uint8
            Grey levels. Colours are weighed as ITU-R BT.601 does. May share the message's memory.

        Raises
        ------
        BadInput
            The encoding is not one of those that are read.
        BadPicture
            The message does not hold the pixels that it promises, or too many.
        """
        check_readable(message)
        check_whole(message, self._max_megapixels)
        picture = _raw(message) if hasattr(message, "encoding") else _compressed(message)
        return self._to_8_bits(picture)

    def _to_8_bits(self, picture: NDArray[Any]) -> Grey:
        if picture.dtype == np.uint8:
            return picture
        if self._bits is None:
            brightest = int(picture.max())
            if brightest == 0:
                return np.zeros(picture.shape, np.uint8)
            self._bits = next(bits for bits in _DEPTHS if brightest < 2**bits)
        shifted = picture >> np.uint16(self._bits - 8)
        return np.asarray(np.minimum(shifted, 255), np.uint8)


def check_readable(message: Any) -> None:
    """Raise BadInput where the message is of an encoding that is not read; look at no pixel."""
    if hasattr(message, "encoding"):
        if message.encoding not in ENCODINGS:
            raise BadInput(
                f"pictures are encoded as {message.encoding!r}, which is not read; "
                f"read are {', '.join(ENCODINGS)}: convert them to one of these"
            )
    elif _compression(message) is None:
        raise BadInput(
            f"pictures are compressed as {message.format!r}, which is not read; "
            f"read are {' and '.join(FORMATS)}: convert them to one of these"
        )


def check_whole(message: Any, max_megapixels: float = MAX_MEGAPIXELS) -> None:
    """Raise BadPicture where a message of a readable encoding is cut, empty or too large.

    No pixel is decoded: OpenCV would make grey of what is missing, and fill the memory with a
    small file of a vast picture.
    """
    if hasattr(message, "encoding"):
        width, height = int(message.width), int(message.height)
        _check_size(width, height, max_megapixels)
        row = width * _BYTES_PER_PIXEL[message.encoding]
        step, size = int(message.step), len(message.data)
        if step < row or size < step * (height - 1) + row:
            raise BadPicture(
                f"the picture of {width} × {height} pixels ({message.encoding}) needs "
                f"{row} bytes a row; it has {size} bytes in rows of {step}"
            )
    else:
        data = message.data if isinstance(message.data, bytes) else memoryview(message.data)
        try:
            width, height = size_of_whole(data)
        except BadPicture as error:
            raise BadPicture(
                f"the {message.format!r} picture of {len(data)} bytes cannot be decoded: {error}"
            ) from None
        _check_size(width, height, max_megapixels)


def _check_size(width: int, height: int, max_megapixels: float) -> None:
    if height == 0 or width == 0:
        raise BadPicture(f"the picture is empty ({width} × {height} pixels)")
    if width * height > max_megapixels * 1e6:
        raise BadPicture(
            f"the picture has {width} × {height} pixels, more than the {max_megapixels:g} "
            "megapixels that max_megapixels allows"
        )


def _compression(message: Any) -> str | None:
    """Return how the message is compressed: its first bytes say so, else its format field."""
    head = bytes(message.data[:8])
    for name, magic in _MAGIC.items():
        if head.startswith(magic):
            return name
    words = message.format.lower().replace("jpg", "jpeg").replace(";", " ").split()
    # "16UC1; compressedDepth png" is not a PNG file: a header of its own comes first.
    if "compresseddepth" in words:
        return None
    return next((name for name in FORMATS if name in words), None)


def _raw(message: Any) -> NDArray[Any]:
    """Return the pixels of an Image, grey, of their own depth."""
    height, width, step = int(message.height), int(message.width), int(message.step)
    row = width * _BYTES_PER_PIXEL[message.encoding]
    data = np.frombuffer(message.data, np.uint8)
    if data.size < step * height:  # the last row may come without its padding
        data = np.concatenate([data, np.zeros(step * height - data.size, np.uint8)])
    rows = data[: step * height].reshape(height, step)[:, :row]
    if message.encoding == "mono8":
        return rows
    if message.encoding == "mono16":
        order = ">u2" if message.is_bigendian else "<u2"
        return np.ascontiguousarray(rows).view(order).astype(np.uint16, copy=False)
    code = cv2.COLOR_BGR2GRAY if message.encoding == "bgr8" else cv2.COLOR_RGB2GRAY
    return cv2.cvtColor(rows.reshape(height, width, 3), code)


def _compressed(message: Any) -> NDArray[Any]:
    """Return the pixels of a CompressedImage, grey, of their own depth."""
    data = np.frombuffer(message.data, np.uint8)
    try:
        picture = cv2.imdecode(data, _DECODE_FLAGS) if data.size else None
    except cv2.error:
        picture = None
    if picture is None or picture.dtype not in (np.uint8, np.uint16):
        raise BadPicture(f"the {message.format!r} picture of {data.size} bytes cannot be decoded")
    return picture
