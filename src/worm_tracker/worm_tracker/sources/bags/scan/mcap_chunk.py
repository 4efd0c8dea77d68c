"""Walks over the records in a chunk, and goes on after those that are damaged."""

import re
from binascii import crc32
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from worm_tracker.sources.bags.scan.decompression import MIB
from worm_tracker.sources.bags.scan.mcap_records import (
    HEAD,
    MESSAGE_HEAD,
    ChunkHead,
    Op,
    is_plausible,
)
from worm_tracker.sources.bags.scan.scan_result import Lost

_IN_CHUNKS = frozenset((Op.SCHEMA, Op.CHANNEL, Op.MESSAGE))
_MESSAGE = re.compile(rb"\x05(?=.{4}\x00{4})", re.DOTALL)


@dataclass(slots=True)
class ChunkReading:
    """How the reading of one chunk went.

    Attributes
    ----------
    at : int
        Where it begins in the file.
    head : ChunkHead
    expected : int or None
        Messages that an index counts in it.
    why : str
        Why it cannot be decompressed to its end; empty where it can.
    kept, unknown, unread : int
        Messages that were read; those whose channel nothing describes; bytes passed over.
    """

    at: int
    head: ChunkHead
    expected: int | None
    why: str = ""
    kept: int = 0
    unknown: int = 0
    unread: int = 0
    _sum_fails: bool = False

    def check(self, data: bytes) -> None:
        """Hold the decompressed chunk to its size and checksum."""
        if not self.why and len(data) != self.head.size:
            self.why = f"it declares {self.head.size} bytes and holds {len(data)}"
        self._sum_fails = not self.why and self.head.crc not in (0, crc32(data))

    def too_large(self, limit: int) -> Lost:
        """Return the loss of a chunk that is not decompressed."""
        size = max(self.head.size, self.head.compressed_size) / MIB
        why = f"it declares {size:.0f} MiB, --max-chunk-mib allows {limit / MIB:.0f}"
        return Lost(f"the chunk at byte {self.at}: {why}", self.expected, self.head.compressed_size)

    def verdict(self) -> Lost | None:
        """Return what is wrong with the chunk; None where nothing is."""
        reasons = [self.why] if self.why else []
        if self.unread:
            reasons.append(f"{self.unread} bytes in it are no records")
        if self.unknown:
            reasons.append(f"nothing describes the channel of {self.unknown} messages")
        if self._sum_fails:
            reasons.append(
                f"its checksum fails: {self.kept} messages are kept that may not be as recorded"
            )
        missing = None if self.expected is None else max(0, self.expected - self.kept)
        if missing and not reasons:
            reasons.append(f"its index counts {self.expected} messages, it holds {self.kept}")
        if not reasons:
            return None
        if missing is None and not self.why and not self.unread:
            missing = self.unknown
        return Lost(f"the chunk at byte {self.at}: {'; '.join(reasons)}", missing, self.unread)


def records_in(
    data: bytes, offsets: Sequence[int], channels: frozenset[int]
) -> Iterator[tuple[int, bytes]]:
    """Yield the records as (op, body); a gap is (0, the bytes passed over).

    Parameters
    ----------
    data : bytes
        The chunk, decompressed as far as it goes.
    offsets : sequence of int
        Where its messages begin, as its index says; the index may be missing or damaged too.
    channels : frozenset of int
        Channels that are described; a message of another is not looked for.
    """
    sure = sorted({at for at in offsets if _message_at(data, at)})
    at = next_sure = 0
    while at < len(data):
        while next_sure < len(sure) and sure[next_sure] <= at:
            next_sure += 1
        bound = sure[next_sure] if next_sure < len(sure) else len(data)
        end = _end_of_record(data, at, bound)
        if end:
            yield data[at], data[at + HEAD.size : end]
            at = end
        else:
            end = bound if bound < len(data) else _next_message(data, at + 1, channels)
            yield 0, data[at:end]
            at = end


def _end_of_record(data: bytes, at: int, bound: int) -> int:
    """Return where a record ends, 0 where none can be read here.

    A message that seems to reach into the next one has a wrong length: it ends where that begins.
    """
    if at + HEAD.size > len(data):
        return 0
    op, length = HEAD.unpack_from(data, at)
    body = at + HEAD.size
    if op not in _IN_CHUNKS and op < 0x80:
        return 0
    start = data[body : body + 64]
    if is_plausible(op, length, start, bound - body):
        return int(body + length)
    if op == Op.MESSAGE and bound < len(data) and bound - body >= MESSAGE_HEAD.size:
        return bound
    return 0


def _message_at(data: bytes, at: int) -> bool:
    if not 0 <= at <= len(data) - HEAD.size:
        return False
    op, length = HEAD.unpack_from(data, at)
    body = at + HEAD.size
    return bool(
        op == Op.MESSAGE and is_plausible(op, length, data[body : body + 64], len(data) - body)
    )


def _next_message(data: bytes, at: int, channels: frozenset[int]) -> int:
    """Return where the next message begins whose end is the beginning of another record."""
    for match in _MESSAGE.finditer(data, at):
        place = match.start()
        if not _message_at(data, place):
            continue
        (_, length), body = HEAD.unpack_from(data, place), place + HEAD.size
        channel = int.from_bytes(data[body : body + 2], "little")
        end = body + length
        ends_well = end == len(data) or (
            end + HEAD.size <= len(data) and _end_of_record(data, end, len(data)) > 0
        )
        if channel in channels and ends_well:
            return place
    return len(data)
