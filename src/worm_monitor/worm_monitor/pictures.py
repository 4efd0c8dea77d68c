"""Which picture is shown next, with the pose that was found in it, and how it is made small."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.errors import MalformedMessage

MOST_A_SECOND = 12.0
WAIT_FOR_POSE_S = 0.6
"""A picture whose pose is held back for longer is shown without one."""
WIDEST_PX = 1280
SHOWN_JPEG_QUALITY = 80
_CHANNELS = {"mono8": 1, "8UC1": 1, "mono16": 1, "16UC1": 1, "bgr8": 3, "rgb8": 3, "8UC3": 3}


@dataclass(frozen=True, slots=True)
class Waiting:
    """A picture that was taken to be shown.

    Attributes
    ----------
    stamp_ns : int
    message
        As it came; it is decoded once it is to be shown.
    came_s : float
        When.
    """

    stamp_ns: int
    message: Any
    came_s: float


class NextPicture:
    """Holds one picture at most, and only while someone waits for one."""

    def __init__(self) -> None:
        self._waiting: Waiting | None = None
        self._shown_s = -float("inf")

    def is_wanted(self, now_s: float) -> bool:
        """Tell whether the next picture that comes would be taken."""
        return self._waiting is None and now_s - self._shown_s >= 1.0 / MOST_A_SECOND

    def offer(self, picture: Waiting) -> None:
        """Take a picture."""
        self._waiting = picture

    def take(self, now_s: float, pose: Callable[[int], Any | None]) -> Waiting | None:
        """Return the picture once its pose is there, or has not come for too long."""
        waiting = self._waiting
        if waiting is None:
            return None
        if pose(waiting.stamp_ns) is None and now_s - waiting.came_s < WAIT_FOR_POSE_S:
            return None
        self._waiting = None
        self._shown_s = now_s
        return waiting

    def forget(self) -> None:
        """Let go of a picture that nobody waits for any more."""
        self._waiting = None


def as_jpeg(message: Any) -> tuple[bytes, float]:
    """Return a picture as JPEG, no wider than is shown, and by how much it was made smaller.

    Parameters
    ----------
    message : sensor_msgs/Image or sensor_msgs/CompressedImage

    Returns
    -------
    jpeg : bytes
    scale : float
        Pixels of the JPEG to one of the picture's.

    Raises
    ------
    MalformedMessage
        Where it is no picture.
    """
    try:
        return shown_jpeg(_decoded(message))
    except (cv2.error, KeyError, ValueError) as error:
        raise MalformedMessage(f"no picture: {error}") from None


def with_head(head: Mapping[str, Any], jpeg: bytes) -> bytes:
    """Return a picture as pages take it: four bytes with the length of a head in JSON, it, a JPEG.

    Parameters
    ----------
    head : mapping
        Time of the picture ``t`` (s), its ``scale``, and its ``pose`` or None.
    """
    text = json.dumps(head, allow_nan=False).encode()
    return len(text).to_bytes(4, "little") + text + jpeg


def shown_jpeg(picture: NDArray[np.uint8]) -> tuple[bytes, float]:
    """Return a picture's levels as JPEG, as `as_jpeg` does."""
    scale = min(1.0, WIDEST_PX / picture.shape[1])
    if scale < 1.0:
        size = (WIDEST_PX, max(1, round(picture.shape[0] * scale)))
        smaller = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    else:
        smaller = picture
    _, jpeg = cv2.imencode(".jpg", smaller, [cv2.IMWRITE_JPEG_QUALITY, SHOWN_JPEG_QUALITY])
    return jpeg.tobytes(), scale


def _decoded(message: Any) -> NDArray[np.uint8]:
    """Return a picture's levels in eight bits, shape (height, width) or (height, width, 3)."""
    if not hasattr(message, "encoding"):
        data = np.frombuffer(message.data, np.uint8)
        found = cv2.imdecode(data, cv2.IMREAD_ANYDEPTH | cv2.IMREAD_GRAYSCALE)
        if found is None:
            raise ValueError("it is neither JPEG nor PNG")
        return _eight_bits(found)
    channels = _CHANNELS[message.encoding]
    kind = np.dtype(np.uint16 if "16" in message.encoding else np.uint8)
    kind = kind.newbyteorder(">" if message.is_bigendian else "<")
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    width = message.width * channels * kind.itemsize
    picture = np.ascontiguousarray(rows[:, :width]).view(kind)
    if channels == 3:
        picture = picture.reshape(message.height, message.width, 3)
        if message.encoding == "rgb8":
            picture = np.ascontiguousarray(picture[:, :, ::-1])
    return _eight_bits(picture)


def _eight_bits(picture: NDArray[Any]) -> NDArray[np.uint8]:
    """Return the levels in eight bits; of more bits, those that the picture uses."""
    if picture.dtype == np.uint8:
        return picture
    bits = max(8, int(picture.max()).bit_length())
    return (picture >> (bits - 8)).astype(np.uint8)
