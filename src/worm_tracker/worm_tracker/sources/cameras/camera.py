"""Captures from a camera, an address or a video file in real time."""

import atexit
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2

from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.cameras.camera_address import HIDDEN, Kind, kind_of, shown_address
from worm_tracker.sources.cameras.camera_settings import CameraSettings
from worm_tracker.sources.cameras.capture import OPEN_TIMEOUT_S, grey, open_capture
from worm_tracker.sources.cameras.film_pace import FilmPace
from worm_tracker.sources.cameras.outages import LONGEST_PAUSE_S, Outage, OutageWatch
from worm_tracker.sources.cameras.steady_clock import SteadyClock
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame, WaitingFrames


@dataclass(frozen=True, slots=True)
class CaptureCounts:
    """What became of the frames; ``captured == taken + skipped + waiting`` at any time.

    `age_s` is the time since the last capture, NaN before the first. `lost` are frames that the
    camera made and that never came, as far as that is known.
    """

    captured: int
    taken: int
    skipped: int
    waiting: int
    reconnections: int
    age_s: float
    lost: int = 0


class Camera:
    """Captures in a thread of its own, which whoever takes frames never holds up.

    A tracker that is slower than the camera gets the newest frame (`WaitingFrames`). Frames count
    from `begin` on: before, a device or stream is read so that nothing stale is left in it.

    Parameters
    ----------
    address : str
        A V4L2 device (``/dev/video0`` or ``0``), an HTTP (MJPEG) or RTSP address, or a video file,
        which is played at the pace that its container gives.
    reconnect_s : float
        How long a device or stream that has stopped is opened anew before it counts as lost.
    reconnect_delay_s : float
        Pause before the first of these attempts; it doubles up to `LONGEST_PAUSE_S`.
    stall_s : float
        What gives nothing for so long has stopped.
    on_change : callable, optional
        Called from the capturing thread when a frame has come, and when capturing has stopped,
        goes on or has ended.
    capture : callable, optional
        Opens something else that films, with the methods of `cv2.VideoCapture`; the address is
        then shown alone.
    keep_on : callable, optional
        Asked again and again while it is being opened: False gives up, with KeyboardInterrupt.
    settings : CameraSettings, optional
        What it is asked to film like, each time that it is opened.

    Attributes
    ----------
    not_accepted : list of str
        What of that it did not take when it was opened last.

    Raises
    ------
    BadInput
        No such camera, it cannot be opened, or a video that does not tell its frame rate.

    Notes
    -----
    Frames are stamped as `grab` returns with a `SteadyClock`, and never less than a nanosecond
    after the one before. The first few frames of a stream are captured while it is being probed
    and bear the time at which probing ended. Frames of a file bear the time at which it was
    started plus their own time in it.
    """

    def __init__(
        self,
        address: str,
        *,
        reconnect_s: float = 600.0,
        reconnect_delay_s: float = 0.5,
        stall_s: float = 5.0,
        on_change: Callable[[], None] | None = None,
        capture: Callable[[], Any] | None = None,
        keep_on: Callable[[], bool] = lambda: True,
        settings: CameraSettings | None = None,
    ) -> None:
        self.shown_address = shown_address(address)
        self.kind = kind_of(address) if capture is None else Kind.STREAM
        self._capture_instead = capture
        self.why_lost = ""
        self._address = address
        self._settings = settings or CameraSettings()
        self._asked: float | None = None
        self.not_accepted: list[str] = []
        self.reconnect_s, self._stall_s = reconnect_s, stall_s
        self._on_change = on_change or (lambda: None)
        self._stop = threading.Event()
        self._frames = WaitingFrames()
        self._ended = False
        self._failure: Exception | None = None
        self._clock = SteadyClock()
        self._began_ns = self._clock.now_ns()
        gap_s = math.inf if self.kind is Kind.FILE else stall_s
        self._watch = OutageWatch(reconnect_s, reconnect_delay_s, gap_s, self._began_ns)
        self._capture = _in_a_thread(self._open, keep_on)
        if self._capture is None:
            raise BadInput(
                f"{self.shown_address}: the {self.kind.value} cannot be opened; {self._hint()}"
            )
        self.fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        if self.kind is Kind.FILE and not (math.isfinite(self.fps) and self.fps > 0):
            raise BadInput(
                f"{address}: the video does not tell its frame rate; "
                f"turn it into a bag with `worm import {address} --out BAG`"
            )
        self.pace = FilmPace(self.fps) if self.kind is Kind.FILE else None
        self._thread = threading.Thread(target=self._run, name="capture", daemon=True)

    def _hint(self) -> str:
        if self.shown_address.endswith(f"://{HIDDEN}"):
            return "write @, /, ? and # in a password as %40, %2F, %3F and %23"
        return _HINTS[self.kind]

    def start(self) -> None:
        """Begin to read what goes on by itself: a device, a stream."""
        if self._capture_instead is None and self.kind is not Kind.FILE:
            self._start()

    def begin(self) -> None:
        """Begin to keep what comes: all that takes frames is ready."""
        self._frames.begin()
        if self._thread.ident is None:
            self._start()

    def _start(self) -> None:
        self._began_ns = self._watch.last_ns = self._clock.now_ns()
        self._thread.start()

    def stop(self) -> None:
        """End capturing; the oldest frames that wait can still be taken."""
        self._stop.set()
        self._frames.end()
        if self._thread.is_alive():
            self._thread.join(timeout=_STOP_S)
        if self._thread.is_alive():
            # A dead stream holds it for longer, and it may not wake up in a dying interpreter.
            atexit.register(self._thread.join, OPEN_TIMEOUT_S + self._stall_s)
        self._ended = True

    def take(self) -> CapturedFrame | None:
        """Return the oldest frame that waits, or None; raise what ended the capture."""
        frame = self._frames.take()
        if frame is None and self._failure is not None:
            raise self._failure
        return frame

    def expose(self, exposure_ms: float) -> None:
        """Ask for another exposure; the capturing thread does before its next frame."""
        self._asked = exposure_ms

    def take_outages(self) -> list[Outage]:
        """Return the outages that have ended since the last time."""
        return self._watch.take_over()

    @property
    def waiting(self) -> bool:
        """Whether there is a frame to take."""
        return self._frames.waiting

    @property
    def ended(self) -> bool:
        """Whether no frame will come any more."""
        limit_s = self._stall_s + self.reconnect_s + OPEN_TIMEOUT_S + LONGEST_PAUSE_S
        if not self._ended and self.kind is not Kind.FILE and self.silent_s > limit_s:
            self._give_up()  # the capturing thread hangs in a read that does not end
            self._stop.set()
            self._ended = True
        return self._ended

    @property
    def silent_s(self) -> float:
        """Seconds since the last frame, or since the start."""
        return self._watch.silent_s(self._clock.now_ns())

    @property
    def outage(self) -> Outage | None:
        """The outage that goes on now; None where frames come."""
        return self._watch.outage(self._clock.now_ns())

    @property
    def counts(self) -> CaptureCounts:
        """What became of the frames so far."""
        counts = self._frames.counts()
        age_s = self.silent_s if counts[0] else math.nan
        lost = int(getattr(self._capture, "lost", 0))  # of a rig that is simulated
        return CaptureCounts(*counts, self._watch.reconnections, age_s, lost)

    def _open(self) -> Any | None:
        if self._capture_instead is not None:
            capture = self._capture_instead()
        else:
            capture = open_capture(self._address, self.kind, self._stall_s)
        if capture is not None:
            self.not_accepted = self._settings.apply(capture, self.kind)
        return capture

    def _run(self) -> None:
        try:
            self._capture_all()
        except Exception as error:  # it must come out where frames are taken, not die here
            self._failure = error
        finally:
            self._ended = True
            self._on_change()

    def _ask_anew(self) -> None:
        """Ask the device for what was asked meanwhile; all other wishes it has heard."""
        asked, self._asked = self._asked, None
        if asked is not None and self._capture is not None:
            self._settings = replace(self._settings, exposure_ms=asked)
            self.not_accepted = CameraSettings(exposure_ms=asked).apply(self._capture, self.kind)

    def _capture_all(self) -> None:
        while not self._stop.is_set():
            self._ask_anew()
            if self._capture is not None and self._capture.grab():
                stamp_ns = max(self._due_ns(), self._watch.last_ns + 1)
                done, picture = self._capture.retrieve()
                if done and not self._stop.is_set():
                    self._put(CapturedFrame(grey(picture), stamp_ns))
            elif self.kind is Kind.FILE or not self._reconnect():
                return

    def _due_ns(self) -> int:
        """Return the stamp of the frame that was grabbed; wait for it where it is of a file."""
        if self.pace is None or self._capture is None:
            return self._clock.now_ns()
        container_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3
        due_ns = self._began_ns + round(NS_PER_S * self.pace.due_s(container_s))
        self._stop.wait(max(0.0, (due_ns - self._clock.now_ns()) / NS_PER_S))
        return due_ns

    def _put(self, frame: CapturedFrame) -> None:
        self._watch.frame_came(frame.stamp_ns)  # first: an outage is told before the frame after it
        self._frames.put(frame)
        self._on_change()

    def _reconnect(self) -> bool:
        """Try once to open anew what has stopped, after a pause; return False to give up."""
        if self._capture is not None:
            self._capture.release()
        self._capture = None
        if not self._watch.stopped:
            self._watch.stop()
            self._on_change()
        pause_s = self._watch.pause_s()
        if pause_s is None:
            self._give_up()
            return False
        if self._stop.wait(pause_s):
            return False
        self._watch.attempts += 1
        self._capture = self._open()
        self._watch.reconnections += self._capture is not None
        return True

    def _give_up(self) -> None:
        self.why_lost = (
            f"no frame has come from {self.shown_address} for {self.silent_s:.0f} s "
            f"({self._watch.attempts} attempts to reconnect)"
        )


def _in_a_thread(opens: Callable[[], Any], keep_on: Callable[[], bool]) -> Any:
    """Return what is opened; a camera that does not answer keeps nobody from ending."""
    found: list[Any] = []

    def run() -> None:
        try:
            found.append(opens())
        except BaseException as error:
            found.append(error)

    thread = threading.Thread(target=run, name="capture", daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(_ASKED_EVERY_S)
        if not keep_on():
            raise KeyboardInterrupt
    if isinstance(found[0], BaseException):
        raise found[0]
    return found[0]


_STOP_S, _ASKED_EVERY_S = 0.5, 0.05
_HINTS = {
    Kind.DEVICE: "is it plugged in, free, and may you read it?",
    Kind.STREAM: "does its address open in a browser or a player?",
    Kind.FILE: "is it a video?",
}
