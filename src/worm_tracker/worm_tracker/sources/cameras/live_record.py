"""The record of a live trial, written beside the tracking; ended well where its disk is full."""

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from threading import BoundedSemaphore

from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit
from worm_tracker.sources.bags.bag_writer import PictureRecorder
from worm_tracker.sources.bags.compressed_message import compressed_message
from worm_tracker.sources.bags.serialized_images import empty_picture
from worm_tracker.sources.cameras.disk_space import DiskSpace
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE, IMAGE_TYPE

_MOST_BEHIND = 30
"""Pictures that wait to be written; then whoever films waits, and skips are counted there."""
_SYNC_S = 0.5
SPLIT_MIB, SPLIT_MIN = Limit(0.1, 1e6, "MiB", or_zero=True), Limit(0.01, 1e5, "min", or_zero=True)
GOOD_QUALITY = 90


class RecordAs(StrEnum):
    """How pictures are compressed; all but jpeg without a loss."""

    ZSTD = "zstd"
    PNG = "png"
    JPEG = "jpeg"


@dataclass(frozen=True)
class RecordForm:
    """What a record is to be.

    Attributes
    ----------
    recorded_as : RecordAs
        Of a megapixel with noise, on one core: zstd 3 ms and 0.54 of its size, png 13 ms and 0.4,
        jpeg of quality 90 2 ms and 0.1.
    jpeg_quality : int
        1 to 100.
    split_mib, split_min : float
        A file that is larger or lasts longer is followed by another one; 0: never.
    """

    recorded_as: RecordAs = RecordAs.ZSTD
    jpeg_quality: int = GOOD_QUALITY
    split_mib: float = 4096.0
    split_min: float = 30.0

    @property
    def quality(self) -> int | None:
        """The quality where it is JPEG."""
        return self.jpeg_quality if self.recorded_as is RecordAs.JPEG else None

    @property
    def notes(self) -> dict[str, str]:
        """What the record says of itself."""
        quality = {} if self.quality is None else {"jpeg_quality": str(self.quality)}
        return {"recorded_as": str(self.recorded_as), **quality}


class LiveRecord:
    """Records what is sent until it is closed or its disk is nearly full, whichever is first.

    Pictures are compressed and written by a thread of its own; whoever sends them waits only where
    it is far behind. A crash of the program costs what waits there, a power cut half a second more.

    Parameters
    ----------
    directory : Path
        A new directory.
    topic : str
        Name of the topic of raw pictures; compressed ones have the one beside it.
    form : RecordForm
        How they are written.

    Raises
    ------
    BadInput
        As `PictureRecorder`.

    Attributes
    ----------
    complaint : str
        What is wrong, for `/diagnostics`; empty where nothing is.
    """

    def __init__(self, directory: Path, topic: str, form: RecordForm | None = None) -> None:
        self._directory, self._form = directory, form or RecordForm()
        raw = self._form.recorded_as is RecordAs.ZSTD
        self._recorder = PictureRecorder(
            directory,
            topic if raw else f"{topic}/compressed",
            IMAGE_TYPE if raw else COMPRESSED_TYPE,
            split_bytes=self._form.split_mib * 2**20 or float("inf"),
            split_s=self._form.split_min * 60.0 or float("inf"),
            sync_s=_SYNC_S,
            notes=self._form.notes,
        )
        self._room = DiskSpace(directory)
        self._warnings: deque[str] = deque()
        self._stopped: deque[str] = deque()
        self._first_bytes = 0
        self._closed = False
        self.complaint = ""
        self._free = BoundedSemaphore(_MOST_BEHIND)
        self._writer = ThreadPoolExecutor(1, "record")

    @property
    def count(self) -> int:
        """Number of pictures recorded."""
        return self._recorder.count

    def write(self, frame: CapturedFrame, raw: bytes) -> None:
        """Record one picture, soon; `raw` is its message, serialised. It must not change."""
        self._free.acquire()
        self._writer.submit(self._write, frame, raw)

    def take_stopped(self) -> str:
        """Return why the record has ended before its time, once; empty where it has not."""
        return self._stopped.popleft() if self._stopped else ""

    def _write(self, frame: CapturedFrame, raw: bytes) -> None:
        try:
            if not self._closed:
                self._put(frame, raw)
        except BadInput as error:
            self._stop(str(error).partition(";")[0])
        finally:
            self._free.release()

    def _put(self, frame: CapturedFrame, raw: bytes) -> None:
        if self._form.recorded_as is not RecordAs.ZSTD:
            raw = (
                empty_picture(frame.stamp_ns, COMPRESSED_TYPE)
                if frame.why_bad
                else compressed_message(frame.picture, frame.stamp_ns, self._form.quality)
            )
        self._recorder.write(frame.stamp_ns, raw)
        if self._recorder.count == 1:
            self._first_bytes = self._recorder.bytes_on_disk
        grown = self._recorder.bytes_on_disk - self._first_bytes  # in the time since the first
        warning = self._room.warning(grown, self._recorder.duration_s)
        if warning:
            self.complaint = warning
            self._warnings.append(warning)
        if self._room.used_up:
            self._stop(f"{self._directory}: the disk is nearly full")

    def close(self) -> None:
        """Write what waits, and close the record; `take_stopped` says where it is not whole."""
        self._writer.shutdown()
        self._finish()

    def _finish(self) -> str:
        """Close the record; return why it is not whole where it is not."""
        if self._closed:
            return ""
        self._closed = True
        try:
            self._recorder.close()
        except BadInput as error:
            self._warnings.append(str(error))
            self._stopped.append(str(error))
            self.complaint = str(error)
            return str(error)
        return ""

    def take_warnings(self) -> list[str]:
        """Return the lines to be said since the last time."""
        said = []
        while self._warnings:
            said.append(self._warnings.popleft())
        return said

    def counts(self) -> dict[str, str]:
        """Return what `/diagnostics` shows of the record."""
        return {
            "frames recorded": str(self.count),
            "record (MB)": f"{self._recorder.bytes_on_disk / 1e6:.1f}",
            "disk lasts (minutes)": f"{self._room.minutes_left:.0f}",
        }

    def _stop(self, why: str) -> None:
        """End the record here."""
        if self._finish():
            return
        whole = f"the first {self.count} frames are a whole bag"
        self.complaint = f"{why}; recording has stopped, tracking goes on; {whole}"
        self._warnings.append(self.complaint)
        self._stopped.append(self.complaint)
