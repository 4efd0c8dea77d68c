"""What can be read of a damaged bag by other means than ours: the `mcap` library, and SQLite."""

import sqlite3
from binascii import crc32
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

from mcap.reader import SeekingReader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk

Key = tuple[int, int]
"""Time of recording and checksum of a message."""


def readable(file: Path) -> set[Key]:
    """Return the messages that can be read."""
    if file.suffix == ".db3":
        return set(_by_rows(file))
    found = set()
    for way in (_in_order, _by_index):
        with suppress(Exception):  # whatever the damage makes of the library
            for message in way(file):
                found.add((message.log_time, crc32(message.data)))
    return found


def _in_order(file: Path) -> Iterator[Message]:
    """Read from the start to the first error, chunk after chunk."""
    with file.open("rb") as stream:
        for record in StreamReader(stream, emit_chunks=True, validate_crcs=False).records:
            if isinstance(record, Message):
                yield record
            elif isinstance(record, Chunk):
                yield from _of_chunk(record)


def _by_index(file: Path) -> Iterator[Message]:
    """Read each chunk where the index at the end says that it is."""
    with file.open("rb") as stream:
        summary = SeekingReader(stream).get_summary()
        for index in summary.chunk_indexes if summary else ():
            with suppress(Exception):
                stream.seek(index.chunk_start_offset)
                reader = StreamReader(
                    stream, skip_magic=True, emit_chunks=True, validate_crcs=False
                )
                chunk = next(iter(reader.records))
                if isinstance(chunk, Chunk):
                    yield from _of_chunk(chunk)


def _of_chunk(chunk: Chunk) -> Iterator[Message]:
    with suppress(Exception):
        for record in breakup_chunk(chunk, validate_crc=False):
            if isinstance(record, Message):
                yield record


def _by_rows(file: Path) -> Iterator[Key]:
    """Ask SQLite for each row by its number."""
    with (
        suppress(sqlite3.Error),
        closing(sqlite3.connect(f"{file.as_uri()}?immutable=1&mode=ro", uri=True)) as database,
    ):
        for rowid in range(1, 40):
            with suppress(sqlite3.Error, UnicodeDecodeError):
                query = "SELECT timestamp, data FROM messages WHERE rowid = ?"
                for log_ns, data in database.execute(query, (rowid,)):
                    if isinstance(log_ns, int) and isinstance(data, bytes):
                        yield log_ns, crc32(data)
