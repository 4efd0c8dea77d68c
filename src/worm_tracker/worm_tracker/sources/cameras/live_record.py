"""The record of a live trial: it ends in good order when its disk is full; the trial goes on."""

from pathlib import Path

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_writer import PictureRecorder
from worm_tracker.sources.cameras.disk_room import DiskRoom
from worm_tracker.sources.image_decoder import IMAGE_TYPE


class LiveRecord:
    """Records what is sent until it is closed or its disk is nearly full, whichever is first.

    Parameters
    ----------
    directory : Path
        A new directory.
    topic : str
        Name of the topic of the pictures.

    Raises
    ------
    BadInput
        As `PictureRecorder`.

    Attributes
    ----------
    complaint : str
        What is wrong, for `/diagnostics`; empty where nothing is.
    """

    def __init__(self, directory: Path, topic: str) -> None:
        self._directory = directory
        self._recorder = PictureRecorder(directory, topic, IMAGE_TYPE)
        self._room = DiskRoom(directory)
        self._warnings: list[str] = []
        self._seen_bytes = 0
        self._closed = False
        self.complaint = ""

    @property
    def count(self) -> int:
        """Number of pictures recorded."""
        return self._recorder.count

    def write(self, stamp_ns: int, raw: bytes) -> str:
        """Record one picture; return why the record has ended where it ends here."""
        if self._closed:
            return ""
        try:
            self._recorder.write(stamp_ns, raw)
        except BadInput as error:
            return self._stop(str(error).partition(";")[0])
        if self._recorder.bytes_on_disk == self._seen_bytes:
            return ""
        self._seen_bytes = self._recorder.bytes_on_disk
        warning = self._room.warning(self._seen_bytes, self._recorder.duration_s)
        if warning:
            self.complaint = warning
            self._warnings.append(warning)
        if self._room.used_up:
            return self._stop(f"{self._directory}: the disk is nearly full")
        return ""

    def close(self) -> str:
        """Close the record; return why it is not whole where it is not."""
        if self._closed:
            return ""
        self._closed = True
        try:
            self._recorder.close()
        except BadInput as error:
            self._warnings.append(str(error))
            return str(error)
        return ""

    def take_warnings(self) -> list[str]:
        """Return the lines to be said since the last time."""
        said, self._warnings = self._warnings, []
        return said

    def counts(self) -> dict[str, str]:
        """Return what `/diagnostics` shows of the record."""
        return {
            "frames recorded": str(self.count),
            "record (MB)": f"{self._seen_bytes / 1e6:.1f}",
            "disk lasts (minutes)": f"{self._room.minutes_left:.0f}",
        }

    def _stop(self, why: str) -> str:
        failed = self.close()
        if not failed:
            whole = f"the first {self.count} frames are a whole bag"
            self._warnings.append(f"{why}; recording has stopped, tracking goes on; {whole}")
            self.complaint = self._warnings[-1]
            return self.complaint
        self.complaint = failed
        return failed
