"""Captures from a camera, an address or a video file in real time; the latest frame wins."""

import math
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.errors import BadInput

# Causes are told in our one line; FFmpeg's own go to stderr past Python. (-8 is AV_LOG_QUIET.)
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")

OPEN_TIMEOUT_S = 5.0


class Kind(Enum):
    """What an address leads to."""

    DEVICE = "device"
    STREAM = "stream"
    FILE = "file"


@dataclass(frozen=True, slots=True, eq=False)
class CapturedFrame:
    """One frame: grey, shape (h, w) uint8, and when it was captured, nanoseconds since 1970."""

    picture: NDArray[np.uint8]
    stamp_ns: int


@dataclass(frozen=True, slots=True)
class CaptureCounts:
    """What became of the frames; ``captured == taken + skipped + waiting`` at any time.

    `age_s` is the time since the last capture, NaN before the first.
    """

    captured: int
    taken: int
    skipped: int
    waiting: int
    reconnections: int
    age_s: float


class Camera:
    """Captures in a thread of its own into a box that holds one frame.

    A frame that nobody has taken when the next one comes is overwritten, and counted. So whoever
    takes frames gets the newest one and no queue builds up before it.

    Parameters
    ----------
    address : str
        A V4L2 device (``/dev/video0`` or ``0``), an HTTP (MJPEG) or RTSP address, or a video file,
        which is played at the pace that its container claims.
    reconnections : int
        How many times in a row a stream that has stopped is opened anew before it counts as ended.
    reconnect_delay_s : float
        Pause before each of them.
    stall_s : float
        A stream that gives nothing for so long has stopped.
    on_change : callable, optional
        Called from the capturing thread when a frame has come and when the stream has ended.

    Raises
    ------
    BadInput
        No such camera, it cannot be opened, or a video that does not tell its frame rate.

    Notes
    -----
    Frames are stamped with the wall clock as `grab` returns, and never less than a nanosecond
    after the one before. The first few frames of a stream are captured while it is being probed
    and bear the time at which probing ended.
    """

    def __init__(
        self,
        address: str,
        *,
        reconnections: int = 5,
        reconnect_delay_s: float = 1.0,
        stall_s: float = 5.0,
        on_change: Callable[[], None] | None = None,
    ) -> None:
        self.address = address
        self.shown_address = without_password(address)
        self.kind = kind_of(address)
        self._reconnections_allowed = reconnections
        self._reconnect_delay_s = reconnect_delay_s
        self._stall_s = stall_s
        self._on_change = on_change or (lambda: None)
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._box: CapturedFrame | None = None
        self._captured = self._taken = self._skipped = self._reconnections = 0
        self._attempts = 0  # to reconnect, since the last frame
        self._last_ns = 0
        self._ended = False
        self._failure: Exception | None = None
        self._capture = self._open()
        if self._capture is None:
            raise BadInput(
                f"{self.shown_address}: the {self.kind.value} cannot be opened; {_HINTS[self.kind]}"
            )
        self.fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        if self.kind is Kind.FILE and not (math.isfinite(self.fps) and self.fps > 0):
            raise BadInput(
                f"{address}: the video does not tell its frame rate; "
                f"turn it into a bag with `worm import {address} --out BAG`"
            )
        self._thread = threading.Thread(target=self._run, name="capture", daemon=True)

    def start(self) -> None:
        """Begin to capture."""
        self._thread.start()

    def stop(self) -> None:
        """End capturing; a frame that waits can still be taken."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)  # a dead stream may hold it for longer; it is a daemon
        self._ended = True

    def take(self) -> CapturedFrame | None:
        """Return the newest frame that was not taken yet, or None; raise what ended the capture."""
        with self._lock:
            frame, self._box = self._box, None
            self._taken += frame is not None
        if frame is None and self._failure is not None:
            raise self._failure
        return frame

    @property
    def waiting(self) -> bool:
        """Whether there is a frame to take."""
        return self._box is not None

    @property
    def ended(self) -> bool:
        """Whether no frame will come any more."""
        return self._ended

    @property
    def counts(self) -> CaptureCounts:
        """What became of the frames so far."""
        with self._lock:
            age_s = (time.time_ns() - self._last_ns) / 1e9 if self._captured else math.nan
            return CaptureCounts(
                self._captured,
                self._taken,
                self._skipped,
                int(self._box is not None),
                self._reconnections,
                age_s,
            )

    def _open(self) -> Any | None:
        quiet = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        try:
            capture = _open_capture(self.address, self.kind, self._stall_s)
        finally:
            cv2.utils.logging.setLogLevel(quiet)
        return capture if capture.isOpened() else None

    def _run(self) -> None:
        try:
            self._capture_all()
        except Exception as error:  # it must come out where frames are taken, not die here
            self._failure = error
        finally:
            self._ended = True
            self._on_change()

    def _capture_all(self) -> None:
        began_s, number = time.monotonic(), 0
        while not self._stop.is_set():
            if self.kind is Kind.FILE:
                self._stop.wait(max(0.0, began_s + number / self.fps - time.monotonic()))
            if self._capture is not None and self._capture.grab():
                stamp_ns = max(time.time_ns(), self._last_ns + 1)
                done, picture = self._capture.retrieve()
                if done:
                    self._put(CapturedFrame(_grey(picture), stamp_ns))
                number += 1
            elif not self._reconnect():
                return

    def _put(self, frame: CapturedFrame) -> None:
        with self._lock:
            self._skipped += self._box is not None
            self._box = frame
            self._captured += 1
            self._attempts = 0
            self._last_ns = frame.stamp_ns
        self._on_change()

    def _reconnect(self) -> bool:
        """Open a stream anew that has stopped; return whether there is one."""
        if self._capture is not None:
            self._capture.release()
        self._capture = None
        if self.kind is not Kind.STREAM:
            return False
        while self._attempts < self._reconnections_allowed:
            self._attempts += 1
            if self._stop.wait(self._reconnect_delay_s):
                return False
            self._capture = self._open()
            if self._capture is not None:
                self._reconnections += 1
                return True
        return False


_HINTS = {
    Kind.DEVICE: "is it plugged in, free, and may you read it?",
    Kind.STREAM: "does its address open in a browser or a player?",
    Kind.FILE: "is it a video?",
}


def kind_of(address: str) -> Kind:
    """Tell what an address leads to; BadInput where it leads nowhere."""
    if address.isdecimal() or address.startswith("/dev/video"):
        return Kind.DEVICE
    if urlsplit(address).scheme in ("http", "https", "rtsp", "rtsps"):
        return Kind.STREAM
    if Path(address).is_file():
        return Kind.FILE
    raise BadInput(
        f"{address}: no such camera; give a device (/dev/video0), an http or rtsp address, "
        "or a video file"
    )


def without_password(address: str) -> str:
    """Return the address as it may be shown and logged."""
    parts = urlsplit(address)
    if "@" not in parts.netloc:
        return address
    return parts._replace(netloc="…@" + parts.netloc.rpartition("@")[2]).geturl()


def _open_capture(address: str, kind: Kind, stall_s: float) -> Any:
    if kind is Kind.DEVICE:
        path = f"/dev/video{address}" if address.isdecimal() else address
        capture = cv2.VideoCapture(path, cv2.CAP_V4L2)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the driver is not to queue either
        return capture
    timeouts = [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
        int(OPEN_TIMEOUT_S * 1000),
        cv2.CAP_PROP_READ_TIMEOUT_MSEC,
        int(stall_s * 1000),
    ]
    return cv2.VideoCapture(address, cv2.CAP_FFMPEG, timeouts)


def _grey(picture: NDArray[Any]) -> NDArray[np.uint8]:
    if picture.ndim == 2:
        return np.ascontiguousarray(picture, np.uint8)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
