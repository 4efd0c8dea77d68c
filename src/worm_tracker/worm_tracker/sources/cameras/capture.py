"""Opens devices, streams and video files with OpenCV, without a word on stderr."""

import os
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_tracker.sources.cameras.camera_address import Kind

# Causes are told in our one line; FFmpeg's own go to stderr past Python, with the address and its
# password in them. (-8 is AV_LOG_QUIET.)
os.environ["OPENCV_FFMPEG_LOGLEVEL"] = "-8"

OPEN_TIMEOUT_S = 5.0


def open_capture(address: str, kind: Kind, stall_s: float) -> Any | None:
    """Return an opened `cv2.VideoCapture`, or None; a read that gives nothing fails in `stall_s`.

    OpenCV's own words, which may hold the address, are turned off for good.
    """
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    if kind is Kind.DEVICE:
        path = f"/dev/video{address}" if address.isdecimal() else address
        capture = cv2.VideoCapture(path, cv2.CAP_V4L2)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the driver is not to queue either
    else:
        timeouts = [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
            int(OPEN_TIMEOUT_S * 1000),
            cv2.CAP_PROP_READ_TIMEOUT_MSEC,
            int(stall_s * 1000),
        ]
        capture = cv2.VideoCapture(address, cv2.CAP_FFMPEG, timeouts)
    if not capture.isOpened():
        return None
    if _is_grey_jpeg(capture):
        capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)  # 1.4 ms a megapixel for the same levels thrice
    return capture


def _is_grey_jpeg(capture: Any) -> bool:
    """Tell whether pictures are grey as they come: of JPEG alone such levels are from 0 to 255."""
    asked = (cv2.CAP_PROP_FOURCC, cv2.CAP_PROP_CODEC_PIXEL_FORMAT)
    codec, pixels = (int(capture.get(what)).to_bytes(8, "little", signed=True) for what in asked)
    return codec[:4] == b"MJPG" and pixels[:4] in (b"Y800", b"GREY")


def grey(picture: NDArray[Any]) -> NDArray[np.uint8]:
    """Return the picture's grey levels."""
    if picture.ndim == 2:
        return np.ascontiguousarray(picture, np.uint8)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
