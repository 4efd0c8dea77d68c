"""Writes pictures as they come into a rosbag2 directory that a crash leaves readable."""

from contextlib import suppress
from pathlib import Path

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.errors import BadInput


class PictureRecorder:
    """A rosbag2 directory (mcap, zstd chunks with checksums) of one topic.

    A chunk goes to the disk as soon as it is full (a megabyte), so that a crash costs the frames
    of one chunk; what is left can be saved by `worm_tracker.bag_repair`.

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
        self._on_disk = 0
        try:
            self._directory.mkdir(parents=True, exist_ok=True)
            if any(self._directory.iterdir()):
                raise BadInput(f"{directory}: holds files already; name a new directory to record")
            self._stream = self._file.open("xb")
        except OSError as error:
            raise BadInput(f"{directory}: cannot be recorded into: {error.strerror}") from None
        store = get_typestore(Stores.ROS2_JAZZY)
        definition, _ = store.generate_msgdef(message_type, ros_version=2)
        self._digest = store.hash_rihs01(message_type)
        self._writer = Writer(self._stream, compression=CompressionType.ZSTD, enable_crcs=True)
        self._writer.start(profile="ros2", library="worm-escape")
        schema = self._writer.register_schema(message_type, "ros2msg", definition.encode())
        metadata = {"offered_qos_profiles": "", "topic_type_hash": self._digest}
        self._channel = self._writer.register_channel(topic, "cdr", schema, metadata)

    @property
    def count(self) -> int:
        """Number of pictures written."""
        return self._count

    def write(self, stamp_ns: int, raw: bytes) -> None:
        """Append one serialised picture; the stamp is also its time of recording.

        Raises
        ------
        BadInput
            The disk is full, or cannot be written for another reason.
        """
        try:
            self._writer.add_message(self._channel, stamp_ns, raw, stamp_ns, self._count)
            if self._stream.tell() != self._on_disk:
                self._stream.flush()
                self._on_disk = self._stream.tell()
        except OSError as error:
            raise self._failure(error) from error
        self._first_ns = stamp_ns if self._count == 0 else self._first_ns
        self._last_ns = stamp_ns
        self._count += 1

    def close(self) -> None:
        """Write the index and metadata.yaml: from now on it is a whole bag."""
        if self._stream.closed:
            return
        try:
            self._writer.finish()
            self._stream.close()
            (self._directory / "metadata.yaml").write_text(self._metadata(), encoding="utf-8")
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> BadInput:
        with suppress(OSError):
            self._stream.close()
        return BadInput(
            f"{self._file}: cannot be written ({error.strerror}) after {self._count} pictures; "
            "make room, and save what is there with "
            f"`python -m worm_tracker.bag_repair {self._file} REPAIRED.mcap`"
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
