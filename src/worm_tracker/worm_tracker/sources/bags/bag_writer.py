"""Writes pictures as they come into a rosbag2 directory that a crash leaves readable."""

import math
import shlex
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import yaml
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.picture_file import PictureFile


class PictureRecorder:
    """A rosbag2 directory (mcap) of one topic, in one file or in several.

    A picture goes to the disk as soon as it is written, so that a crash of the program costs the
    last one at most; what is left can be saved by `worm repair`.

    Parameters
    ----------
    directory : Path
        Made if it is not there; it must be empty.
    topic, message_type : str
        Name of the topic, such as ``/image_raw``, and type, such as ``sensor_msgs/msg/Image``.
    split_bytes, split_s : float
        A file that is larger, or holds more seconds of stamps, is followed by another one.
    sync_s : float
        A power cut costs no picture that was written longer ago; it takes some milliseconds each
        time.
    notes : mapping of str to str
        What metadata.yaml is to say in ``custom_data``.

    Raises
    ------
    BadInput
        The directory holds something, or cannot be written.
    """

    def __init__(
        self,
        directory: Path,
        topic: str,
        message_type: str,
        *,
        split_bytes: float = math.inf,
        split_s: float = math.inf,
        sync_s: float = math.inf,
        notes: Mapping[str, str] | None = None,
    ) -> None:
        self._directory = Path(directory)
        self._topic, self._type, self._notes = topic, message_type, notes
        self._split_bytes, self._split_s, self._sync_s = split_bytes, split_s, sync_s
        self._files: list[PictureFile] = []
        self._synced_s = time.monotonic()
        self._closed = False
        try:
            self._made = not self._directory.exists()
            self._directory.mkdir(parents=True, exist_ok=True)
            if any(self._directory.iterdir()):
                raise BadInput(f"{directory}: holds files already; name a new directory to record")
            self._next_file()
        except OSError as error:
            raise BadInput(f"{directory}: cannot be recorded into: {error.strerror}") from None

    @property
    def count(self) -> int:
        """Number of pictures written."""
        return sum(file.count for file in self._files)

    @property
    def bytes_on_disk(self) -> int:
        """Length of the files so far."""
        return sum(file.bytes_on_disk for file in self._files)

    @property
    def duration_s(self) -> float:
        """Seconds from the first picture to the last."""
        return (self._files[-1].last_ns - self._files[0].first_ns) / NS_PER_S

    def write(self, stamp_ns: int, raw: bytes) -> None:
        """Append one serialised picture; the stamp is also its time of recording.

        Raises
        ------
        BadInput
            The disk is full, or cannot be written for another reason; the picture is part of the
            record nonetheless if `close` succeeds.
        """
        try:
            file = self._files[-1]
            is_full = file.bytes_on_disk >= self._split_bytes or file.duration_s >= self._split_s
            if is_full and file.count:
                file.finish()
                file = self._next_file()
            file.write(stamp_ns, raw)
            if time.monotonic() - self._synced_s >= self._sync_s:
                file.sync()
                self._synced_s = time.monotonic()
        except OSError as error:
            raise self._failure(error) from error

    def _next_file(self) -> PictureFile:
        name = f"{self._directory.resolve().name}_{len(self._files)}.mcap"
        self._files.append(PictureFile(self._directory / name, self._topic, self._type))
        return self._files[-1]

    def close(self) -> None:
        """Write the index and metadata.yaml: from now on it is a whole bag.

        A record without pictures is removed.
        """
        if self._closed:
            return
        self._closed = True
        try:
            last = self._files[-1]
            if last.count == 0:
                last.remove()
                self._files.pop()
            else:
                last.finish()
            if not self._files:
                self._remove_directory()
                return
            metadata = self._directory / "metadata.yaml"
            metadata.write_text(_dump(self._metadata()), encoding="utf-8")
        except OSError as error:
            raise self._failure(error) from error

    def _remove_directory(self) -> None:
        if self._made:
            with suppress(OSError):
                self._directory.rmdir()

    def _failure(self, error: OSError) -> BadInput:
        return BadInput(
            f"{self._files[-1].path}: cannot be written ({error.strerror}) after {self.count} "
            "pictures; make room, and save what is there with "
            f"`worm repair {shlex.quote(str(self._directory))}`"
        )

    def _metadata(self) -> object:
        """Return rosbag2's metadata, version 9, in the form that its own recorder writes."""
        duration = {"nanoseconds": self._files[-1].last_ns - self._files[0].first_ns}
        topic = {
            "name": self._topic,
            "type": self._type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [],
            "type_description_hash": get_typestore(Stores.ROS2_JAZZY).hash_rihs01(self._type),
        }
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            "duration": duration,
            "starting_time": {"nanoseconds_since_epoch": self._files[0].first_ns},
            "message_count": self.count,
            "topics_with_message_count": [{"topic_metadata": topic, "message_count": self.count}],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file.path.name for file in self._files],
            "files": [
                {
                    "path": file.path.name,
                    "starting_time": {"nanoseconds_since_epoch": file.first_ns},
                    "duration": {"nanoseconds": file.last_ns - file.first_ns},
                    "message_count": file.count,
                }
                for file in self._files
            ],
            "custom_data": dict(self._notes) if self._notes else None,
            "ros_distro": "jazzy",
        }
        return {"rosbag2_bagfile_information": information}


class _NoAliases(yaml.SafeDumper):
    def ignore_aliases(self, data: object) -> bool:
        return True


def _dump(document: object) -> str:
    return yaml.dump(document, Dumper=_NoAliases, sort_keys=False)
