"""Writes pictures as they come into a rosbag2 directory that a crash leaves readable."""

import shlex
from contextlib import suppress
from pathlib import Path

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.record_file import RecordFile
from worm_msgs_py.units import NS_PER_S

_CHUNK_BYTES = 1 << 20
_INDEX_BYTES = 256
"""More than the index needs for a chunk."""
_END_BYTES = 64 << 10
"""More than schema, statistics, footer and metadata.yaml need."""


class PictureRecorder:
    """A rosbag2 directory (mcap, zstd chunks with checksums) of one topic.

    A chunk goes to the disk as soon as it is full (a megabyte), so that a crash costs the frames
    of one chunk; what is left can be saved by `worm repair`. Room for the last chunk
    and the index is kept on the disk all the while: a record that fills it can still be closed
    whole.

    Parameters
    ----------
    directory : Path
        Made if it is not there; it must be empty.
    topic, message_type : str
        Name of the topic, such as ``/image_raw``, and type, such as ``sensor_msgs/msg/Image``.

    Raises
    ------
    BadInput
        The directory holds something, or cannot be written.
    """

    def __init__(self, directory: Path, topic: str, message_type: str) -> None:
        self._directory = Path(directory)
        self._topic, self._type = topic, message_type
        self._file = self._directory / f"{self._directory.resolve().name}_0.mcap"
        self._count, self._first_ns, self._last_ns = 0, 0, 0
        self._chunks, self._largest = 0, 0
        try:
            self._made = not self._directory.exists()
            self._directory.mkdir(parents=True, exist_ok=True)
            if any(self._directory.iterdir()):
                raise BadInput(f"{directory}: holds files already; name a new directory to record")
            self._stream = RecordFile(self._file)
            self._stream.keep_room(self._needed_at_the_end())
        except OSError as error:
            raise BadInput(f"{directory}: cannot be recorded into: {error.strerror}") from None
        store = get_typestore(Stores.ROS2_JAZZY)
        definition, _ = store.generate_msgdef(message_type, ros_version=2)
        self._digest = store.hash_rihs01(message_type)
        self._writer = Writer(
            self._stream,
            chunk_size=_CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_crcs=True,
        )
        self._writer.start(profile="ros2", library="worm-escape")
        schema = self._writer.register_schema(message_type, "ros2msg", definition.encode())
        metadata = {"offered_qos_profiles": "", "topic_type_hash": self._digest}
        self._channel = self._writer.register_channel(topic, "cdr", schema, metadata)
        self._stream.commit()

    @property
    def count(self) -> int:
        """Number of pictures written."""
        return self._count

    @property
    def bytes_on_disk(self) -> int:
        """Length of the file so far."""
        return self._stream.committed

    @property
    def duration_s(self) -> float:
        """Seconds from the first picture to the last."""
        return (self._last_ns - self._first_ns) / NS_PER_S

    def write(self, stamp_ns: int, raw: bytes) -> None:
        """Append one serialised picture; the stamp is also its time of recording.

        Raises
        ------
        BadInput
            The disk is full, or cannot be written for another reason; the picture is part of the
            record nonetheless if `close` succeeds.
        """
        self._writer.add_message(self._channel, stamp_ns, raw, stamp_ns, self._count)
        self._first_ns = stamp_ns if self._count == 0 else self._first_ns
        self._last_ns = stamp_ns
        self._count += 1
        self._largest = max(self._largest, len(raw))
        if self._stream.waiting == 0:
            return
        try:
            self._chunks += 1
            self._stream.keep_room(self._needed_at_the_end())
            self._stream.commit()
        except OSError as error:
            raise self._failure(error) from error

    def _needed_at_the_end(self) -> int:
        """Return more bytes than a last chunk or two, the index and metadata.yaml need."""
        last = 2 * (_CHUNK_BYTES + self._largest)
        return last + self._chunks * _INDEX_BYTES * 2 + _END_BYTES

    def close(self) -> None:
        """Write the index and metadata.yaml: from now on it is a whole bag.

        A record without pictures is removed.
        """
        if self._stream.closed:
            return
        try:
            self._stream.give_room()
            if self._count == 0:
                self._remove()
                return
            self._writer.finish()
            self._stream.commit()
            (self._directory / "metadata.yaml").write_text(self._metadata(), encoding="utf-8")
        except OSError as error:
            raise self._failure(error) from error
        finally:
            self._stream.close()

    def _remove(self) -> None:
        self._file.unlink()
        if self._made:
            with suppress(OSError):
                self._directory.rmdir()

    def _failure(self, error: OSError) -> BadInput:
        return BadInput(
            f"{self._file}: cannot be written ({error.strerror}) after {self._count} pictures; "
            "make room, and save what is there with "
            f"`worm repair {shlex.quote(str(self._directory))}`"
        )

    def _metadata(self) -> str:
        """Return rosbag2's metadata, version 9, in the form that its own recorder writes."""
        duration = {"nanoseconds": self._last_ns - self._first_ns}
        start = {"nanoseconds_since_epoch": self._first_ns}
        topic = {
            "name": self._topic,
            "type": self._type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [],
            "type_description_hash": self._digest,
        }
        file = {
            "path": self._file.name,
            "starting_time": start,
            "duration": duration,
            "message_count": self._count,
        }
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            "duration": duration,
            "starting_time": start,
            "message_count": self._count,
            "topics_with_message_count": [{"topic_metadata": topic, "message_count": self._count}],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self._file.name],
            "files": [file],
            "custom_data": None,
            "ros_distro": "jazzy",
        }
        return _dump({"rosbag2_bagfile_information": information})


class _NoAliases(yaml.SafeDumper):
    def ignore_aliases(self, data: object) -> bool:
        return True


def _dump(document: object) -> str:
    return yaml.dump(document, Dumper=_NoAliases, sort_keys=False)
