"""The pictures of a camera driver that is not ours, as they come on its topic."""

import math
from collections import deque
from dataclasses import replace
from typing import Any

import numpy as np

from worm_msgs_py.errors import BadInput, BadPicture
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.cameras.camera import CaptureCounts
from worm_tracker.sources.cameras.camera_address import Kind
from worm_tracker.sources.cameras.outages import Outage, OutageWatch
from worm_tracker.sources.cameras.steady_clock import SteadyClock
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame, WaitingFrames
from worm_tracker.sources.image_decoder import PictureDecoder

_NOTHING = np.empty((0, 0), np.uint8)


class TopicCamera:
    """Takes a driver's messages; stands beside `Camera` and has what a camera node asks of it.

    Frames bear the stamps that the driver gives them, which have to grow; whether the driver has
    stopped is told by when they come. What did not come is known by the numbers that DDS gives the
    messages of a publisher. One that begins anew is followed without a loss.

    Parameters
    ----------
    topic : str
        Its name, to be shown.
    reconnect_s : float
        How long a driver that has stopped is waited for.
    stall_s : float
        What gives nothing for so long has stopped.
    max_megapixels : float
        Larger pictures are bad ones.
    """

    kind = Kind.STREAM
    fps = math.nan

    def __init__(
        self, topic: str, reconnect_s: float, stall_s: float, max_megapixels: float
    ) -> None:
        self.shown_address = topic
        self.reconnect_s, self._stall_s = reconnect_s, stall_s
        self._clock = SteadyClock()
        self._watch = OutageWatch(reconnect_s, 0.0, stall_s, self._clock.now_ns())
        self._frames = WaitingFrames()
        self._decoder = PictureDecoder(max_megapixels)
        self._stamp_ns = 0  # of the last frame, by the driver's clock
        self._outages: deque[Outage] = deque()
        self._next_number: int | None = None
        self._any_decoded = self._stopped = False
        self.lost = 0
        self.why_lost = ""
        self.not_accepted: list[str] = []

    def take_message(self, message: Any, number: int) -> None:
        """Take a message with the number that DDS gives it among those of its publisher.

        Raises
        ------
        BadInput
            Not one picture so far was of an encoding that is read, or it bears no stamp.
        """
        if self._stopped:
            return
        if self._next_number is not None:
            self.lost += max(0, number - self._next_number)
        self._next_number = number + 1
        stamp = message.header.stamp
        stamp_ns = int(stamp.sec) * NS_PER_S + int(stamp.nanosec)
        if stamp_ns <= 0:
            raise BadInput(
                f"{self.shown_address}: the pictures bear no stamp; let the driver set it"
            )
        if stamp_ns <= self._stamp_ns:
            self.lost += 1  # a second picture of one moment, or of an earlier one
            return
        now_ns = self._clock.now_ns()
        outage = self._watch.outage(now_ns)
        if outage is not None and self._stamp_ns:
            self._outages.append(replace(outage, since_ns=self._stamp_ns))
        self._watch.frame_came(now_ns)
        self._stamp_ns = stamp_ns
        self._frames.put(self._decoded(message, stamp_ns))

    def _decoded(self, message: Any, stamp_ns: int) -> CapturedFrame:
        try:
            picture = self._decoder.decode(message)
        except (BadPicture, BadInput) as error:
            if isinstance(error, BadInput) and not self._any_decoded:
                raise BadInput(f"{self.shown_address}: {error}") from None
            return CapturedFrame(_NOTHING, stamp_ns, str(error))
        self._any_decoded = True
        return CapturedFrame(picture, stamp_ns)

    def start(self) -> None:
        """Do nothing: messages come by themselves."""

    def begin(self) -> None:
        """Begin to keep what comes: all that takes frames is ready.

        What those took to get ready is no silence of the driver.
        """
        self._frames.begin()
        self._watch.last_ns = self._clock.now_ns()
        self.lost = 0

    def stop(self) -> None:
        """Take no more; the oldest frames that wait can still be taken."""
        self._stopped = True
        self._frames.end()

    def take(self) -> CapturedFrame | None:
        """Return the oldest frame that waits, or None."""
        return self._frames.take()

    def take_outages(self) -> list[Outage]:
        """Return the outages that have ended since the last time."""
        over = list(self._outages)
        self._outages.clear()
        return over

    @property
    def waiting(self) -> bool:
        """Whether there is a frame to take."""
        return self._frames.waiting

    @property
    def ended(self) -> bool:
        """Whether no frame will come any more."""
        silent_s = self._watch.silent_s(self._clock.now_ns())
        if not self._stopped and silent_s > self._stall_s + self.reconnect_s:
            self.why_lost = f"no frame has come on {self.shown_address} for {silent_s:.0f} s"
            self._stopped = True
        return self._stopped

    @property
    def outage(self) -> Outage | None:
        """The outage that goes on now; None where frames come."""
        outage = self._watch.outage(self._clock.now_ns())
        return outage and replace(outage, since_ns=self._stamp_ns or outage.since_ns)

    @property
    def counts(self) -> CaptureCounts:
        """What became of the frames so far."""
        counts = self._frames.counts()
        age_s = self._watch.silent_s(self._clock.now_ns()) if counts[0] else math.nan
        return CaptureCounts(*counts, reconnections=0, age_s=age_s, lost=self.lost)
