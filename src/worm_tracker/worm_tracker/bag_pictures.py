"""Reads the pictures of a recording: a rosbag2 directory, an .mcap or a .db3 file."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.errors import BadInput
from worm_tracker.bag_faults import no_bag_there, unreadable, why_not_a_bag
from worm_tracker.cdr import stamp_of, with_stamp
from worm_tracker.pictures import COMPRESSED_TYPE, IMAGE_TYPE, check_readable

REORDERED = 8
"""Pictures that are held back to put those into order that were recorded out of it."""

_TYPES = (IMAGE_TYPE, COMPRESSED_TYPE)


@dataclass(frozen=True, slots=True, order=True)
class BagPicture:
    """One picture as it lies in the bag.

    Attributes
    ----------
    stamp_ns : int
        Time of capture: the header's stamp, or the time of recording where that is 0.
    index : int
        Place among the bag's pictures in the order of recording; it tells equal stamps apart.
    raw : bytes
        The message in CDR form, its header's stamp set to `stamp_ns`.
    """

    stamp_ns: int
    index: int
    raw: bytes


class BagPictures:
    """The pictures of one topic of a bag, open for reading; a context manager.

    Opening it finds every fault that can be found without reading all of it, so that nothing is
    written before the bag is known to be good.

    Parameters
    ----------
    path : Path
        A rosbag2 directory, an .mcap file or a .db3 file.
    topic : str, optional
        The topic of the pictures, with or without the leading slash. None: the only one.
    start_offset_s : float
        Leave out what was recorded in the first seconds after the first picture.
    playback_duration_s : float, optional
        Stop this long (seconds of recording) after `start_offset_s`. None: read to the end.

    Attributes
    ----------
    topic : str
        The topic that is read.
    message_type : str
        `IMAGE_TYPE` or `COMPRESSED_TYPE`.
    count : int
        Number of pictures on the topic.
    expected : int
        Number of pictures that will be read: `count`, or a guess from the recorded times where
        only a part is read.

    Raises
    ------
    BadInput
        No such bag, not a bag, cut or damaged, no pictures, several topics of pictures and none
        chosen, an encoding that is not read, nothing left after the offset. One line each.
    """

    def __init__(
        self,
        path: Path,
        topic: str | None = None,
        *,
        start_offset_s: float = 0.0,
        playback_duration_s: float | None = None,
    ) -> None:
        self.path = Path(path)
        _check_range(start_offset_s, playback_duration_s)
        self._reader = _open(self.path)
        try:
            self._connections = _choose(self.path, self._reader.connections, topic)
            self.topic = self._connections[0].topic
            self.message_type = self._connections[0].msgtype
            self.count = sum(connection.msgcount for connection in self._connections)
            first_ns, raw = self._first()
            self._check_encoding(raw)
            self._start_ns = first_ns + round(start_offset_s * 1e9)
            self._stop_ns: int | None = None
            if playback_duration_s is not None:
                self._stop_ns = self._start_ns + round(playback_duration_s * 1e9)
            self._whole = start_offset_s == 0.0 and self._stop_ns is None
            self.expected = self.count if self._whole else self._guess(first_ns)
        except BaseException:
            self.close()
            raise

    def _first(self) -> tuple[int, bytes]:
        """Return the time of recording, and the bytes, of the first picture."""
        for _, log_ns, raw in self._messages(None, None):
            return log_ns, raw
        raise BadInput(f"{self.path}: no picture on {self.topic}, though the index counts some")

    def _check_encoding(self, raw: bytes) -> None:
        try:
            typestore = get_typestore(Stores.ROS2_JAZZY)
            message = typestore.deserialize_cdr(raw, self.message_type)
        except Exception as error:  # whatever a damaged message provokes in the parser
            raise BadInput(
                f"{self.path}: the first message on {self.topic} is not a {self.message_type} "
                f"({error or type(error).__name__})"
            ) from error
        try:
            check_readable(message)
        except BadInput as error:
            raise BadInput(f"{self.path}, topic {self.topic}: {error}") from None

    def _guess(self, first_ns: int) -> int:
        end_ns = self._reader.end_time
        stop_ns = end_ns if self._stop_ns is None else min(self._stop_ns, end_ns)
        share = max(0, stop_ns - self._start_ns) / max(1, end_ns - first_ns)
        if share == 0.0:
            raise BadInput(
                f"{self.path}: nothing is left to play; the bag lasts "
                f"{(end_ns - first_ns) / 1e9:.3f} s: choose a smaller --start-offset"
            )
        return max(1, min(self.count, round(share * self.count)))

    @property
    def duration_s(self) -> float:
        """Length of the recording, seconds, other topics included."""
        return self._reader.duration / 1e9

    def _messages(
        self, start_ns: int | None, stop_ns: int | None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        try:
            yield from self._reader.messages(self._connections, start_ns, stop_ns)
        except Exception as error:  # damage shows itself in as many ways as there are parsers
            raise unreadable(self.path, error) from error

    def __iter__(self) -> Iterator[BagPicture]:
        """Yield the pictures in the order of their stamps.

        Recorders write what arrives when it arrives; pictures that were recorded out of order by
        fewer than `REORDERED` places are put right.

        Raises
        ------
        BadInput
            The bag is damaged further on, or holds fewer pictures than its index counts.
        """
        held: list[BagPicture] = []
        start_ns = None if self._whole else self._start_ns
        index = -1
        for index, (_, log_ns, raw) in enumerate(self._messages(start_ns, self._stop_ns)):
            heapq.heappush(held, _picture(self.path, index, log_ns, raw))
            if len(held) > REORDERED:
                yield heapq.heappop(held)
        if self._whole and index + 1 < self.count:
            raise BadInput(
                f"{self.path}: holds {index + 1} pictures where its index counts {self.count}; "
                "it is incomplete: copy it again, or rebuild its index with `ros2 bag reindex`"
            )
        while held:
            yield heapq.heappop(held)

    def close(self) -> None:
        """Close the files."""
        if self._reader.is_open:
            self._reader.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _check_range(start_offset_s: float, playback_duration_s: float | None) -> None:
    if not start_offset_s >= 0.0:
        raise BadInput(f"--start-offset is {start_offset_s} s; it must be 0 or more")
    if playback_duration_s is not None and not playback_duration_s > 0.0:
        raise BadInput(f"--playback-duration is {playback_duration_s} s; it must be more than 0")


def _open(path: Path) -> Reader:
    if not path.exists():
        raise no_bag_there(path)
    fault = why_not_a_bag(path)
    if fault is not None:
        raise fault
    try:
        reader = Reader(path)
        reader.open()
    except Exception as error:  # as above: damaged files fail in many ways
        raise unreadable(path, error) from error
    return reader


def _choose(path: Path, connections: list[Connection], topic: str | None) -> list[Connection]:
    """Return the connections of the topic that is to be read."""
    pictures = [connection for connection in connections if connection.msgtype in _TYPES]
    listed = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in connections})) or "nothing"
    if topic is not None:
        name = "/" + topic.lstrip("/")
        chosen = [c for c in pictures if "/" + c.topic.lstrip("/") == name]
        if not chosen:
            raise BadInput(f"{path}: no pictures on the topic {topic}; the bag holds {listed}")
    else:
        chosen = [c for c in pictures if c.msgcount > 0]
    if not pictures:
        raise BadInput(f"{path}: no topic of pictures ({' or '.join(_TYPES)}); it holds {listed}")
    if not sum(connection.msgcount for connection in chosen):
        raise BadInput(f"{path}: the bag holds no picture; it may have been recorded too late")
    topics = sorted({connection.topic for connection in chosen})
    if len(topics) > 1:
        raise BadInput(
            f"{path}: several topics hold pictures ({', '.join(topics)}); "
            f"choose one, such as --topic {topics[0]}"
        )
    if len({connection.msgtype for connection in chosen}) > 1:
        raise BadInput(f"{path}: {topics[0]} holds both Image and CompressedImage; split the bag")
    return chosen


def _picture(path: Path, index: int, log_ns: int, raw: bytes) -> BagPicture:
    try:
        stamp_ns = stamp_of(raw)
    except ValueError as error:
        raise BadInput(f"{path}: picture {index} is damaged: {error}") from None
    if stamp_ns == 0:
        stamp_ns = log_ns
        raw = with_stamp(raw, stamp_ns)
    return BagPicture(stamp_ns, index, raw)
