"""Scans an mcap file from its first byte to its last and goes over what is damaged."""

import os
import re
import struct
from bisect import bisect_left
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import BinaryIO

from worm_tracker.sources.bags.scan.decompression import COMPRESSIONS, decompress
from worm_tracker.sources.bags.scan.mcap_chunk import ChunkReading, records_in
from worm_tracker.sources.bags.scan.mcap_records import (
    HEAD,
    MCAP_MAGIC,
    MESSAGE_HEAD,
    Described,
    Op,
    is_plausible,
    read_channel,
    read_chunk_head,
    read_message_index,
    read_schema,
)
from worm_tracker.sources.bags.scan.mcap_summary import McapSummary, read_mcap_summary
from worm_tracker.sources.bags.scan.scan_result import Found, FoundMessage, Lost, Topic
from worm_tracker.sources.bags.scan.topic_guess import guessed_topic

_WINDOW = 1 << 20
_RECORD_START = 64
_ANY = re.compile(rb"[\x02-\x07\x0f](?=.{4}\x00{4})", re.DOTALL)
_AROUND_CHUNKS = re.compile(rb"[\x02\x06\x07\x0f](?=.{4}\x00{4})", re.DOTALL)
"""What lies between compressed chunks: anything else that is found there is in one."""


class McapScan:
    """The messages of an mcap file in the order in which they lie in it.

    Parameters
    ----------
    path : Path
    max_chunk_bytes : int
        No larger chunk is decompressed.
    after_ns, before_ns : int, optional
        Pass over chunks whose messages were all recorded before the one, or not before the other.
    summary : McapSummary, optional
        That of the file, where it has been read before.
    """

    def __init__(
        self,
        path: Path,
        max_chunk_bytes: int,
        after_ns: int | None = None,
        before_ns: int | None = None,
        summary: McapSummary | None = None,
    ) -> None:
        self._path, self._limit = path, max_chunk_bytes
        self._after_ns, self._before_ns = after_ns, before_ns
        self._known_summary = summary
        self._described = Described()
        self._found = self._lost = 0
        self._skipped = self._compressed = False

    def __iter__(self) -> Iterator[Found]:
        """Yield messages, and the places that cannot be read, in the order of the file."""
        with self._path.open("rb") as file:
            self._file: BinaryIO = file
            self._size = os.fstat(file.fileno()).st_size
            known = self._known_summary
            self._summary = read_mcap_summary(file, self._size) if known is None else known
            for found in self._walk():
                if isinstance(found, Lost):
                    self._lost += found.messages or 0
                else:
                    self._found += 1
                yield found
            yield from self._missing()

    def _walk(self) -> Iterator[Found]:
        at, end = len(MCAP_MAGIC), self._summary.starts_at or self._size
        closed = bool(self._summary.starts_at)
        if self._after_ns is not None or self._before_ns is not None:
            span = self._summary.span(self._after_ns, self._before_ns)
            if span is not None:
                at, end = span
                self._skipped = True
        while at < end:
            op, length = self._record_at(at) or (0, 0)
            if op == 0:
                cut_at = at
                at = yield from self._go_over(at, end)
                if at >= end and not closed:
                    yield Lost(f"it is cut short in the record at byte {cut_at}", None)
                    return
                continue
            closed = closed or op in (Op.DATA_END, Op.FOOTER)
            after = at + HEAD.size + length
            if op == Op.CHUNK:
                whole = yield from self._chunk(at, length)
                if not whole and after < end and self._record_at(after) is None:
                    # Bytes are missing in it, so that it seems to reach into what follows it.
                    after = self._next_record(at + 1, after, _AROUND_CHUNKS)
            elif op == Op.MESSAGE:
                yield from self._message(self._read(at + HEAD.size, length), at)
            elif op in (Op.SCHEMA, Op.CHANNEL):
                self._described.take(op, self._read(at + HEAD.size, length))
            at = after
        if not closed:
            yield Lost("it ends without its index: the recorder was stopped before it closed", None)

    def _go_over(self, at: int, end: int) -> Generator[Found, None, int]:
        """Yield what can be read of a damaged place; return where the next record begins."""
        if self._is_cut_chunk(at):
            yield from self._chunk(at, self._size - at - HEAD.size)
            return self._next_record(at + 1, end, _AROUND_CHUNKS)
        kinds = _AROUND_CHUNKS if self._compressed else _ANY
        after = self._next_record(at + 1, end, kinds)
        if after - at > len(MCAP_MAGIC) or self._read(at, len(MCAP_MAGIC)) != MCAP_MAGIC:
            why = f"bytes {at} to {after} cannot be read: no record begins there"
            yield Lost(why, None, after - at)
        return after

    def _is_cut_chunk(self, at: int) -> bool:
        """Tell whether a chunk begins here whose end is not in the file any more."""
        data = self._read(at, HEAD.size + _RECORD_START)
        if len(data) < HEAD.size or data[0] != Op.CHUNK:
            return False
        try:
            head = read_chunk_head(data[HEAD.size :])
        except (ValueError, struct.error):
            return False
        (_, length) = HEAD.unpack_from(data)
        return length == head.data_at + head.compressed_size and head.compression in COMPRESSIONS

    def _missing(self) -> Iterator[Lost]:
        """Yield what the file's own count says beyond what was found and missed."""
        counted = sum(self._summary.counts.values())
        missing = counted - self._found - self._lost
        if missing > 0 and not self._skipped:
            yield Lost(f"its index counts {counted} messages, {self._found} were found", missing)

    def _read(self, at: int, count: int) -> bytes:
        self._file.seek(at)
        return self._file.read(count)

    def _record_at(self, at: int, *, strictly: bool = False) -> tuple[int, int] | None:
        """Return the kind and length of the record that begins here; None where none does."""
        data = self._read(at, HEAD.size + _RECORD_START)
        if len(data) < HEAD.size:
            return None
        op, length = HEAD.unpack_from(data)
        left = self._size - at - HEAD.size
        if is_plausible(op, length, data[HEAD.size :], left, strictly=strictly):
            return int(op), int(length)
        return self._chunk_by_its_own_length(at, data[HEAD.size :], op)

    def _chunk_by_its_own_length(self, at: int, start: bytes, op: int) -> tuple[int, int] | None:
        """Return a chunk whose kind or length is damaged, where the rest of it fits."""
        if op != Op.CHUNK and at not in self._summary.chunks:
            return None
        try:
            head = read_chunk_head(start)
        except (ValueError, struct.error):
            return None
        length = head.data_at + head.compressed_size
        if length > self._size - at:
            return None
        data = self._read(at + HEAD.size + length, HEAD.size + _RECORD_START)
        if len(data) < HEAD.size:
            return None
        after, after_length = HEAD.unpack_from(data)
        left = self._size - at - 2 * HEAD.size - length
        fits = is_plausible(after, after_length, data[HEAD.size :], left, strictly=True)
        return (Op.CHUNK, length) if fits else None

    def _next_record(self, at: int, end: int, kinds: re.Pattern[bytes]) -> int:
        """Return where the next record of some kinds begins that is surely one."""
        places = self._summary.places
        known = (place for place in places[bisect_left(places, at) :] if self._is_chunk(place))
        stop = min(end, next(known, end))
        while at < stop:
            window = self._read(at, _WINDOW + HEAD.size)
            for match in kinds.finditer(window):
                place = at + match.start()
                if place >= stop or match.start() >= _WINDOW:
                    break
                if self._is_surely_one(place):
                    return place
            at += _WINDOW
        return stop

    def _is_chunk(self, at: int) -> bool:
        head = self._record_at(at)
        return head is not None and head[0] == Op.CHUNK

    def _is_surely_one(self, at: int) -> bool:
        head = self._record_at(at, strictly=True)
        if head is None:
            return False
        op, length = head
        if op in (Op.SCHEMA, Op.CHANNEL):
            body = self._read(at + HEAD.size, length)
            try:
                read_schema(body) if op == Op.SCHEMA else read_channel(body, {})
            except (ValueError, struct.error):
                return False
        if op == Op.MESSAGE:
            channel = int.from_bytes(self._read(at + HEAD.size, 2), "little")
            after = at + HEAD.size + length
            whole = after == self._size or self._record_at(after) is not None
            return whole and self._topic(channel) is not None
        return True

    def _topic(self, channel: int) -> Topic | None:
        first, second = self._summary.described.topics, self._described.topics
        if not self._summary.sound:
            first, second = second, first
        return first.get(channel) or second.get(channel)

    def _channels(self) -> frozenset[int]:
        return frozenset(self._summary.described.topics) | frozenset(self._described.topics)

    def _message(self, body: bytes, at: int) -> Iterator[Found]:
        channel, sequence, log_ns, publish_ns = MESSAGE_HEAD.unpack_from(body)
        data = body[MESSAGE_HEAD.size :]
        topic = self._topic(channel)
        if topic is None or not topic.type:
            topic = guessed_topic(channel, data, topic)
        if topic is None:
            yield Lost(f"the message at byte {at}: nothing describes its channel {channel}", 1)
        else:
            yield FoundMessage(topic, log_ns, publish_ns, sequence, data)

    def _chunk(self, at: int, length: int) -> Generator[Found, None, bool]:
        """Yield what is in a chunk, then what is wrong with it; return whether it was whole."""
        head = read_chunk_head(self._read(at + HEAD.size, _RECORD_START))
        too_early = self._after_ns is not None and head.end_ns < self._after_ns
        if too_early or (self._before_ns is not None and head.start_ns >= self._before_ns):
            self._skipped = True
            return True
        self._compressed = self._compressed or head.compression != ""
        offsets = self._offsets(at + HEAD.size + length)
        place = self._summary.chunks.get(at)
        expected = len(offsets) or (place.messages if place else None)
        reading = ChunkReading(at, head, expected)
        if max(head.size, head.compressed_size) > self._limit:
            yield reading.too_large(self._limit)
            return True
        packed = self._read(at + HEAD.size + head.data_at, head.compressed_size)
        data, reading.why = decompress(packed, head.compression, self._limit)
        reading.check(data)
        for op, body in records_in(data, offsets, self._channels()):
            if op == Op.MESSAGE:
                for found in self._message(body, at):
                    if isinstance(found, FoundMessage):
                        reading.kept += 1
                        yield found
                    else:
                        reading.unknown += 1
            elif op in (Op.SCHEMA, Op.CHANNEL):
                reading.unread += 0 if self._described.take(op, body) else len(body)
            elif op == 0:
                reading.unread += len(body)
        lost = reading.verdict()
        if lost is not None:
            yield lost
        return lost is None

    def _offsets(self, at: int) -> list[int]:
        """Return where the messages of a chunk begin, from the indices that follow it."""
        offsets: list[int] = []
        while (head := self._record_at(at)) is not None and head[0] == Op.MESSAGE_INDEX:
            offsets += read_message_index(self._read(at + HEAD.size, head[1]))
            at += HEAD.size + head[1]
        return sorted(offsets)
