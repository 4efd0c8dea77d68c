"""One storage file of a bag of pictures: each picture is there whole, or not at all."""

from pathlib import Path

import mcap.writer
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore
from zstandard import ZstdCompressionParameters, ZstdCompressor

from worm_msgs_py.files.record_file import RecordFile
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.image_decoder import IMAGE_TYPE

_A_PICTURE_A_CHUNK = 1
_INDEX_BYTES = 512
"""More than the index needs for a chunk."""
_END_BYTES = 64 << 10
"""More than schema, statistics, footer and metadata.yaml need."""
_QUICK = ZstdCompressionParameters.from_level(1, min_match=6)
"""Of a megapixel with noise 3 ms and 54 % of its size, where zstd's level 3 takes 8 ms for 49 %."""


class _QuickZstd:
    """What mcap's writer compresses chunks with, which cannot be told a level."""

    @staticmethod
    def compress(data: bytes) -> bytes:
        return ZstdCompressor(compression_params=_QUICK).compress(data)


mcap.writer.zstandard = _QuickZstd


class PictureFile:
    """An .mcap file of one topic, a chunk with checksum a picture; raw pictures are compressed.

    Room for the index is kept on the disk all the while: a file that fills it can still be closed
    whole.

    Parameters
    ----------
    path : Path
        The file to make.
    topic, message_type : str
        As for `PictureRecorder`.

    Raises
    ------
    OSError
        It cannot be made.
    """

    def __init__(self, path: Path, topic: str, message_type: str) -> None:
        self.path = path
        self.count, self.first_ns, self.last_ns = 0, 0, 0
        self._largest = 0
        self._failed: OSError | None = None
        self._stream = RecordFile(path)
        self._stream.keep_room(self._needed_at_the_end())
        store = get_typestore(Stores.ROS2_JAZZY)
        definition, _ = store.generate_msgdef(message_type, ros_version=2)
        raw = message_type == IMAGE_TYPE
        self._writer = Writer(
            self._stream,
            chunk_size=_A_PICTURE_A_CHUNK,
            compression=CompressionType.ZSTD if raw else CompressionType.NONE,
            enable_crcs=True,
        )
        self._writer.start(profile="ros2", library="worm-escape")
        schema = self._writer.register_schema(message_type, "ros2msg", definition.encode())
        metadata = {
            "offered_qos_profiles": "",
            "topic_type_hash": store.hash_rihs01(message_type),
        }
        self._channel = self._writer.register_channel(topic, "cdr", schema, metadata)
        self._stream.commit()

    @property
    def bytes_on_disk(self) -> int:
        """Length of the file so far."""
        return self._stream.committed

    @property
    def duration_s(self) -> float:
        """Seconds from the first picture to the last."""
        return (self.last_ns - self.first_ns) / NS_PER_S

    def write(self, stamp_ns: int, raw: bytes) -> None:
        """Append one serialised picture; OSError where it does not fit.

        It is part of the file nonetheless if `finish` succeeds.
        """
        self._writer.add_message(self._channel, stamp_ns, raw, stamp_ns, self.count)
        self.first_ns = stamp_ns if self.count == 0 else self.first_ns
        self.last_ns = stamp_ns
        self.count += 1
        self._largest = max(self._largest, len(raw))
        self._stream.keep_room(self._needed_at_the_end())
        self._stream.commit()

    def sync(self) -> None:
        """See what was written onto the medium."""
        self._stream.sync()

    def _needed_at_the_end(self) -> int:
        """Return more bytes than a last picture or two, the index and metadata.yaml need."""
        return 2 * ((1 << 20) + self._largest) + self.count * _INDEX_BYTES + _END_BYTES

    def finish(self) -> None:
        """Write the index; the file is closed whether that succeeds or not."""
        if not self._stream.closed:
            try:
                self._stream.give_room()
                self._writer.finish()
                self._stream.commit()
                self._stream.sync()
            except OSError as error:
                self._failed = error
            finally:
                self._stream.close()
        if self._failed is not None:
            raise self._failed

    def remove(self) -> None:
        """Close and remove the file."""
        self._stream.close()
        self.path.unlink()
