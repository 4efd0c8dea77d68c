"""The records of the mcap format that a bag needs, each checked before anything of it is used."""

import struct
from dataclasses import dataclass, field
from enum import IntEnum

from worm_tracker.sources.bags.scan.scan_result import Topic

MCAP_MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHUNK_HEAD = struct.Struct("<QQQI")
_U16, _U32, _U64 = struct.Struct("<H"), struct.Struct("<I"), struct.Struct("<Q")
_RECORD_BELOW = 1 << 24
"""No record but chunks, messages and attachments is larger than this."""


class Op(IntEnum):
    """What a record is."""

    HEADER = 0x01
    FOOTER = 0x02
    SCHEMA = 0x03
    CHANNEL = 0x04
    MESSAGE = 0x05
    CHUNK = 0x06
    MESSAGE_INDEX = 0x07
    CHUNK_INDEX = 0x08
    ATTACHMENT = 0x09
    ATTACHMENT_INDEX = 0x0A
    STATISTICS = 0x0B
    METADATA = 0x0C
    METADATA_INDEX = 0x0D
    SUMMARY_OFFSET = 0x0E
    DATA_END = 0x0F


_KNOWN = frozenset(int(op) for op in Op)


@dataclass(frozen=True, slots=True)
class ChunkHead:
    """What stands before the compressed records of a chunk; `data_at` is relative to its body."""

    start_ns: int
    end_ns: int
    size: int
    crc: int
    compression: str
    compressed_size: int
    data_at: int


@dataclass(frozen=True, slots=True)
class ChunkPlace:
    """A chunk as the index at the end of the file knows it."""

    offset: int
    length: int
    messages: int
    start_ns: int
    end_ns: int


@dataclass(slots=True)
class Described:
    """Schemas and channels as far as they have been read."""

    schemas: dict[int, tuple[str, str, str]] = field(default_factory=dict)
    topics: dict[int, Topic] = field(default_factory=dict)

    def take(self, op: int, body: bytes) -> bool:
        """Take a schema or a channel; the first word on each counts. False where it is damaged."""
        try:
            if op == Op.SCHEMA:
                number, schema = read_schema(body)
                self.schemas.setdefault(number, schema)
            else:
                number, topic = read_channel(body, self.schemas)
                self.topics.setdefault(number, topic)
        except (ValueError, struct.error):
            return False
        return True


class _Cursor:
    """Reads fields one after another; ValueError where the record ends too early."""

    def __init__(self, body: bytes) -> None:
        self.body, self.at = body, 0

    def take(self, count: int) -> bytes:
        if count > len(self.body) - self.at:
            raise ValueError("the record ends too early")
        self.at += count
        return self.body[self.at - count : self.at]

    def number(self, form: struct.Struct) -> int:
        (value,) = form.unpack(self.take(form.size))
        return int(value)

    def text(self) -> str:
        return self.take(self.number(_U32)).decode()

    def pairs(self) -> dict[str, str]:
        end = self.number(_U32) + self.at
        pairs = {}
        while self.at < end:
            key = self.text()
            pairs[key] = self.text()
        return pairs

    def end(self) -> None:
        if self.at != len(self.body):
            raise ValueError("the record is longer than its fields")


def read_schema(body: bytes) -> tuple[int, tuple[str, str, str]]:
    """Return a schema's number and its (name, format, definition)."""
    cursor = _Cursor(body)
    number, name, form = cursor.number(_U16), cursor.text(), cursor.text()
    definition = cursor.text()
    cursor.end()
    return number, (name, form, definition)


def read_channel(body: bytes, schemas: dict[int, tuple[str, str, str]]) -> tuple[int, Topic]:
    """Return a channel's number and its topic."""
    cursor = _Cursor(body)
    number, schema, name = cursor.number(_U16), cursor.number(_U16), cursor.text()
    serialization, metadata = cursor.text(), cursor.pairs()
    cursor.end()
    kind, form, definition = schemas.get(schema, ("", "", ""))
    return number, Topic(name, kind, serialization, definition, form, metadata)


def read_chunk_head(body: bytes) -> ChunkHead:
    """Return a chunk's head from the first bytes of its body; ValueError where it is none."""
    cursor = _Cursor(body)
    start_ns, end_ns, size, crc = _CHUNK_HEAD.unpack(cursor.take(_CHUNK_HEAD.size))
    length = cursor.number(_U32)
    if length > 16:
        raise ValueError("no compression has so long a name")
    compression = cursor.take(length).decode("latin-1")
    compressed_size = cursor.number(_U64)
    return ChunkHead(start_ns, end_ns, size, crc, compression, compressed_size, cursor.at)


def read_chunk_index(body: bytes) -> ChunkPlace:
    """Return where a chunk is, and how many messages it holds."""
    cursor = _Cursor(body)
    start_ns, end_ns = cursor.number(_U64), cursor.number(_U64)
    offset, length = cursor.number(_U64), cursor.number(_U64)
    channels = cursor.take(cursor.number(_U32))
    index_length = cursor.number(_U64)
    # A message index is 15 bytes and 16 more a message.
    messages = (index_length - 15 * (len(channels) // 10)) // 16
    return ChunkPlace(offset, length, max(0, messages), start_ns, end_ns)


def read_message_index(body: bytes) -> list[int]:
    """Return where in its chunk each message of a channel begins."""
    offsets = struct.unpack(f"<{(len(body) - 6) // 8}Q", body[6:])
    return list(offsets[1::2])


def read_statistics(body: bytes) -> dict[int, int]:
    """Return the number of messages of each channel."""
    cursor = _Cursor(body)
    cursor.take(42)
    pairs = cursor.take(cursor.number(_U32))
    return dict(struct.iter_unpack("<HQ", pairs))


def is_plausible(op: int, length: int, start: bytes, left: int, *, strictly: bool = False) -> bool:
    """Tell whether a record of this kind can be `length` bytes long and begin like this.

    Parameters
    ----------
    start : bytes
        The first bytes of its body, 64 where there are as many.
    left : int
        Bytes from the record's body to the end of what is read.
    strictly : bool
        Take only kinds whose own fields repeat their length: what random bytes hardly do.
    """
    if length > left:
        return False
    if op == Op.CHUNK:
        try:
            head = read_chunk_head(start)
        except (ValueError, struct.error):
            return False
        return length == head.data_at + head.compressed_size
    if op == Op.MESSAGE:
        return length >= MESSAGE_HEAD.size
    if op == Op.MESSAGE_INDEX:
        return len(start) >= 6 and length == 6 + _U32.unpack_from(start, 2)[0] and length % 16 == 6
    if op in (Op.FOOTER, Op.DATA_END):
        return length == (20 if op == Op.FOOTER else 4)
    if op in (Op.SCHEMA, Op.CHANNEL):
        at = 2 if op == Op.SCHEMA else 4
        return (
            len(start) >= at + 4
            and at + 4 + _U32.unpack_from(start, at)[0] < length < _RECORD_BELOW
        )
    if strictly:
        return False
    if op == Op.ATTACHMENT or op >= 0x80:
        return True
    return op in _KNOWN and length < _RECORD_BELOW
