"""The two ways to read a bag: as a sound one, or whatever is left of it."""

from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from rosbags.rosbag2 import Reader

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_errors import (
    damaged,
    no_bag_there,
    nothing_to_save,
    unreadable,
    why_no_storage,
    why_not_a_bag,
)
from worm_tracker.sources.bags.scan.db3_scan import sound_rows
from worm_tracker.sources.bags.scan.decompression import MIB
from worm_tracker.sources.bags.scan.mcap_scan import McapScan
from worm_tracker.sources.bags.scan.mcap_summary import McapSummary, read_mcap_summary
from worm_tracker.sources.bags.scan.scan import Survey, scan_bag, unpacked
from worm_tracker.sources.bags.scan.scan_result import Found, FoundMessage, Lost


class BagSource(Protocol):
    """A bag that is open.

    Attributes
    ----------
    counts : Counter of (str, str)
        How many messages there are of each topic and type, by the bag's own account.
    start_ns, end_ns : int
        Times of recording of its first message, and just after the last.
    """

    counts: Counter[tuple[str, str]]
    start_ns: int
    end_ns: int

    def found(
        self, topic: str, after_ns: int | None, before_ns: int | None = None
    ) -> Iterator[Found]:
        """Yield the messages of a topic, and what is lost, in the order of recording.

        What was recorded before the one time, or not before the other, may be left out.
        """
        ...

    def close(self) -> None:
        """Close the files."""
        ...


class SoundBag:
    """A bag that is whole: the first damage that is met ends the reading with `BadInput`."""

    def __init__(self, path: Path, max_chunk_mib: float) -> None:
        self._path, self._limit = path, round(max_chunk_mib * MIB)
        self._reader = _open(path)
        self.counts: Counter[tuple[str, str]] = Counter()
        for connection in self._reader.connections:
            self.counts[connection.topic, connection.msgtype] += connection.msgcount
        self.start_ns, self.end_ns = self._reader.start_time, self._reader.end_time
        self._summaries: dict[Path, McapSummary] = {}
        storage = self._reader.storage
        self._files: list[Path] = [
            Path(str(part.path)) for part in getattr(storage, "storages", [storage])
        ]

    def found(
        self, topic: str, after_ns: int | None, before_ns: int | None = None
    ) -> Iterator[FoundMessage]:
        """Yield the messages of a topic."""
        for file in self._files:
            try:
                scan: Iterator[Found] = (
                    sound_rows(file, topic, after_ns, before_ns)
                    if file.suffix == ".db3"
                    else iter(
                        McapScan(file, self._limit, after_ns, before_ns, self._summary_of(file))
                    )
                )
                for found in scan:
                    if isinstance(found, Lost):
                        raise damaged(self._path, f"{file.name}: {found.why}")
                    if found.topic.name == topic:
                        yield unpacked(found, self._limit)
            except Exception as error:  # damage shows itself in as many ways as there are parsers
                raise unreadable(self._path, error) from error

    def _summary_of(self, file: Path) -> McapSummary:
        if file not in self._summaries:
            with file.open("rb") as stream:
                self._summaries[file] = read_mcap_summary(stream, file.stat().st_size)
        return self._summaries[file]

    def close(self) -> None:
        """Close the files."""
        if self._reader.is_open:
            self._reader.close()


class SalvagedBag:
    """A bag that may be damaged: it is read once to count what is there, then again to play it."""

    def __init__(self, path: Path, max_chunk_mib: float) -> None:
        self._path, self._max_chunk_mib = path, max_chunk_mib
        if not _can_be_seen(path):
            raise no_bag_there(path)
        fault = why_no_storage(path)
        if fault is not None:
            raise fault
        survey = Survey()
        try:
            for found in scan_bag(path, max_chunk_mib):
                survey.take(found)
        except OSError as error:
            raise unreadable(path, error) from error
        if not survey.messages:
            raise nothing_to_save(path, survey.losses)
        self.counts: Counter[tuple[str, str]] = Counter()
        for topic, count in survey.messages.items():
            self.counts[topic.name, topic.type] += count
        self.start_ns, self.end_ns = survey.first_ns or 0, (survey.last_ns or 0) + 1

    def found(
        self, topic: str, after_ns: int | None, before_ns: int | None = None
    ) -> Iterator[Found]:
        """Yield the messages of a topic, and what is lost of any: all that there are."""
        for found in scan_bag(self._path, self._max_chunk_mib):
            if isinstance(found, Lost) or found.topic.name == topic:
                yield found

    def close(self) -> None:
        """Nothing stays open."""


def _can_be_seen(path: Path) -> bool:
    with suppress(OSError):  # a name that is too long for the file system
        return path.exists()
    return False


def _open(path: Path) -> Reader:
    if not _can_be_seen(path):
        raise no_bag_there(path)
    try:
        fault = why_not_a_bag(path)
        if fault is not None:
            raise fault
        reader = Reader(path)
        reader.open()
    except BadInput:
        raise
    except Exception as error:  # as above: damaged files fail in many ways
        raise unreadable(path, error) from error
    return reader
