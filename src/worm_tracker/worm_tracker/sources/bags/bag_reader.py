"""Reads the pictures of a recording: a rosbag2 directory, an .mcap or a .db3 file."""

import heapq
from collections import deque
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Self

from worm_msgs_py.contract.source_events import SourceEventKind
from worm_msgs_py.errors import BadInput, BadPicture
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bag_sources import BagSource, SalvagedBag, SoundBag
from worm_tracker.sources.bags.image_stamps import PictureStamps, ahead_of
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB
from worm_tracker.sources.bags.scan.scan_result import FoundMessage, Lost
from worm_tracker.sources.bags.serialized_images import (
    empty_picture,
    read_picture,
    stamp_of,
    with_stamp,
)
from worm_tracker.sources.image_decoder import (
    COMPRESSED_TYPE,
    IMAGE_TYPE,
    MAX_MEGAPIXELS,
    check_readable,
    check_whole,
)

REORDERED = 8
"""Pictures that are held back to put those into order that were recorded out of it."""

_PICTURE_TYPES = (IMAGE_TYPE, COMPRESSED_TYPE)
_TRIED = 100
"""Messages that may be unreadable at the start before the topic is taken to hold no picture."""


@dataclass(frozen=True, slots=True, order=True)
class BagPicture:
    """One picture as it lies in the bag.

    Attributes
    ----------
    stamp_ns : int
        Time of capture, as `PictureStamps` decides it.
    index : int
        Place among the bag's pictures in the order of recording; it tells equal stamps apart.
    raw : bytes
        The message in CDR form, its header's stamp set to `stamp_ns`. One that cannot be read is
        replaced by an empty picture, which every reader of ROS can read.
    why_bad : str
        Why it was replaced; empty where it was not.
    """

    stamp_ns: int
    index: int
    raw: bytes
    why_bad: str = ""


@dataclass(frozen=True, slots=True)
class BagLoss:
    """What is to be said of a bag beside its pictures.

    Attributes
    ----------
    kind : SourceEventKind
        `LOST` or `MISCOUNTED`.
    why : str
        One line.
    count : int
        Messages that are lost, 0 where their number is not known.
    """

    kind: SourceEventKind
    why: str
    count: int


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
    salvage : bool
        Go over what is damaged, and say what was lost, instead of refusing it.
    max_chunk_mib : float
        Largest piece of the bag, decompressed, that is read.
    max_megapixels : float
        Larger pictures are bad ones.

    Attributes
    ----------
    topic : str
        The topic that is read.
    message_type : str
        `IMAGE_TYPE` or `COMPRESSED_TYPE`.
    count : int
        Number of pictures on the topic, as the bag counts them.
    expected : int
        Number of pictures that will be read: `count`, or a guess from the recorded times where
        only a part is read.
    losses : deque of BagLoss
        What was lost among the pictures that were read so far; the reader takes it from there.

    Raises
    ------
    BadInput
        No such bag, not a bag, cut or damaged, no pictures, several topics of pictures and none
        chosen, no message that can be read, nothing left after the offset. One line each.
    """

    def __init__(
        self,
        path: Path,
        topic: str | None = None,
        *,
        start_offset_s: float = 0.0,
        playback_duration_s: float | None = None,
        salvage: bool = False,
        max_chunk_mib: float = MAX_CHUNK_MIB,
        max_megapixels: float = MAX_MEGAPIXELS,
    ) -> None:
        self.path = Path(path)
        self.losses: deque[BagLoss] = deque()
        _check_range(start_offset_s, playback_duration_s)
        self._salvage, self._max_megapixels = salvage, max_megapixels
        kind = SalvagedBag if salvage else SoundBag
        self._bag: BagSource = kind(self.path, max_chunk_mib)
        try:
            self.topic, self.message_type = _topic_to_read(self.path, self._bag, topic)
            self.count = self._bag.counts[self.topic, self.message_type]
            first = self._first()
            first_ns = next((m.log_ns for m in first if 0 <= m.log_ns < 2**63), 0)
            self._first_stamps = [(_header_stamp(m.data), m.log_ns) for m in first[:REORDERED]]
            self._first_ns = first_ns
            self._choose_part(start_offset_s, playback_duration_s)
            self.expected = max(1, self.count) if self._whole else self._guess(first_ns)
        except BaseException:
            self.close()
            raise

    def _choose_part(self, start_offset_s: float, playback_duration_s: float | None) -> None:
        self._start_ns = self._first_ns + round(start_offset_s * NS_PER_S)
        self._stop_ns: int | None = None
        if playback_duration_s is not None:
            self._stop_ns = self._start_ns + round(playback_duration_s * NS_PER_S)
        self._whole = start_offset_s == 0.0 and self._stop_ns is None

    def part(self, start_offset_s: float, playback_duration_s: float | None) -> "BagPictures":
        """Return another part of the same bag, without a look at all of it again.

        Parameters
        ----------
        start_offset_s, playback_duration_s : float
            As of the bag; where nothing is left there are no pictures.
        """
        _check_range(start_offset_s, playback_duration_s)
        part = copy(self)
        part.losses = deque()
        part._choose_part(start_offset_s, playback_duration_s)
        return part

    def _first(self) -> list[FoundMessage]:
        """Return the first messages as far as one that can be read, and `REORDERED` at least."""
        first: list[FoundMessage] = []
        good, why = False, ""
        for message in islice(self._messages(None, None), _TRIED):
            first.append(message)
            why_bad = self._why_bad(message.data)
            good, why = good or not why_bad, why or why_bad
            if good and len(first) >= REORDERED:
                break
        self.losses.clear()  # they are told when the pictures are read
        if not first:
            raise BadInput(
                f"{self.path}: the bag holds no picture; it may have been recorded too late"
            )
        if not good:
            raise BadInput(f"{self.path}, topic {self.topic}: no message can be read: {why}")
        return first

    def _why_bad(self, raw: bytes) -> str:
        """Return why a message is not a picture that can be read; empty where it is one."""
        try:
            fields = read_picture(raw, self.message_type)
            check_readable(fields)
            check_whole(fields, self._max_megapixels)
        except (BadInput, BadPicture) as error:
            return str(error)
        except ValueError as error:
            return f"the message is not a {self.message_type}: {error}"
        return ""

    def _guess(self, first_ns: int) -> int:
        end_ns = self._bag.end_ns
        stop_ns = end_ns if self._stop_ns is None else min(self._stop_ns, end_ns)
        share = max(0, stop_ns - self._start_ns) / max(1, end_ns - first_ns)
        if share == 0.0:
            raise BadInput(
                f"{self.path}: nothing is left to play; the bag lasts "
                f"{(end_ns - first_ns) / NS_PER_S:.3f} s: choose a smaller --start-offset"
            )
        return max(1, min(self.count, round(share * self.count)))

    @property
    def duration_s(self) -> float:
        """Length of the recording, seconds, other topics included."""
        return max(0, self._bag.end_ns - self._bag.start_ns) / NS_PER_S

    @property
    def playback_s(self) -> float:
        """Length of the part that is read, seconds; other topics may end after the pictures."""
        stop_ns = self._bag.end_ns
        if self._stop_ns is not None:
            stop_ns = min(stop_ns, self._stop_ns)
        return max(0, stop_ns - self._start_ns) / NS_PER_S

    def _messages(self, start_ns: int | None, stop_ns: int | None) -> Iterator[FoundMessage]:
        """Yield the topic's messages recorded in a span of time; note what is lost."""
        for found in self._bag.found(self.topic, start_ns, stop_ns):
            if isinstance(found, Lost):
                count = found.messages or 0
                self.losses.append(BagLoss(SourceEventKind.LOST, found.why, count))
            elif found.topic.type != self.message_type:
                pass
            elif (start_ns is None or found.log_ns >= start_ns) and (
                stop_ns is None or found.log_ns < stop_ns
            ):
                yield found

    def __iter__(self) -> Iterator[BagPicture]:
        """Yield the pictures in the order of their stamps.

        Recorders write what arrives when it arrives; pictures that were recorded out of order by
        fewer than `REORDERED` places are put right.

        Raises
        ------
        BadInput
            The bag is damaged further on.
        """
        self.losses.clear()
        held: list[BagPicture] = []
        count = 0
        for picture in self._pictures():
            count += 1
            heapq.heappush(held, picture)
            if len(held) > REORDERED:
                yield heapq.heappop(held)
        while held:
            yield heapq.heappop(held)
        if self._whole and not self._salvage and count != self.count:
            self.losses.append(_miscounted(self.topic, self.count, count))

    def _pictures(self) -> Iterator[BagPicture]:
        """Yield the pictures in the order of recording."""
        start_ns = None if self._whole else self._start_ns
        stamps = PictureStamps(self._first_stamps)
        messages = self._messages(start_ns, self._stop_ns)
        message = next(messages, None)
        index = 0
        while message is not None:
            after = next(messages, None)
            ahead = None if after is None else ahead_of(_header_stamp(after.data), after.log_ns)
            yield self._picture(index, message, stamps, ahead)
            message, index = after, index + 1

    def _picture(
        self, index: int, message: FoundMessage, stamps: PictureStamps, next_ahead: int | None
    ) -> BagPicture:
        why = self._why_bad(message.data)
        stamp_ns, known = stamps.decide(_header_stamp(message.data), message.log_ns, next_ahead)
        if not why and not known:
            why = "neither its header nor its time of recording says when it was taken"
        if why:
            return BagPicture(stamp_ns, index, empty_picture(stamp_ns, self.message_type), why)
        return BagPicture(stamp_ns, index, with_stamp(message.data, stamp_ns))

    def close(self) -> None:
        """Close the files."""
        self._bag.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _header_stamp(raw: bytes) -> int:
    """Return the stamp in a message's header; 0 where it has none."""
    try:
        return stamp_of(raw)
    except ValueError:
        return 0


def _check_range(start_offset_s: float, playback_duration_s: float | None) -> None:
    if not start_offset_s >= 0.0:
        raise BadInput(f"--start-offset is {start_offset_s} s; it must be 0 or more")
    if playback_duration_s is not None and not playback_duration_s > 0.0:
        raise BadInput(f"--playback-duration is {playback_duration_s} s; it must be more than 0")


def _topic_to_read(path: Path, bag: BagSource, topic: str | None) -> tuple[str, str]:
    """Return name and type of the topic that is to be read."""
    pictures = {key: count for key, count in bag.counts.items() if key[1] in _PICTURE_TYPES}
    listed = (
        ", ".join(sorted(f"{name} ({kind or 'of no known type'})" for name, kind in bag.counts))
        or "nothing"
    )
    if not pictures:
        raise BadInput(
            f"{path}: no topic of pictures ({' or '.join(_PICTURE_TYPES)}); it holds {listed}"
        )
    if topic is not None:
        wanted = "/" + topic.lstrip("/")
        chosen = {key: n for key, n in pictures.items() if "/" + key[0].lstrip("/") == wanted}
        if not chosen:
            raise BadInput(f"{path}: no pictures on the topic {topic}; the bag holds {listed}")
    else:
        chosen = pictures
    # Where the index counts none at all it may be wrong: then reading tells.
    chosen = {key: count for key, count in chosen.items() if count > 0} or chosen
    topics = sorted({name for name, _ in chosen})
    if len(topics) > 1:
        raise BadInput(
            f"{path}: several topics hold pictures ({', '.join(topics)}); "
            f"choose one, such as --topic {topics[0]}"
        )
    if len(chosen) > 1:
        raise BadInput(f"{path}: {topics[0]} holds both Image and CompressedImage; split the bag")
    return next(iter(chosen))


def _miscounted(topic: str, counted: int, there: int) -> BagLoss:
    return BagLoss(
        SourceEventKind.MISCOUNTED,
        f"the bag's index counts {counted} pictures on {topic}, it holds {there}; all that are "
        "there were read, and nothing else of the bag is damaged",
        max(0, counted - there),
    )
