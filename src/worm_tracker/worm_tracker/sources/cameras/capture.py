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
    return capture if capture.isOpened() else None


def grey(picture: NDArray[Any]) -> NDArray[np.uint8]:
    """Return the picture's grey levels."""
    if picture.ndim == 2:
        return np.ascontiguousarray(picture, np.uint8)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
