"""Reads the pages of a SQLite file without asking SQLite, which stops at the first bad one."""

import os
import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SQLITE_MAGIC = b"SQLite format 3\x00"
SIZES = (4096, 1024, 512, 2048, 8192, 16384, 32768, 65536)
"""Page sizes that there are, the usual one first."""

TABLE, INDEX = 0x0D, 0x0A
"""First byte of a leaf page."""
_BLOCK = 256
_WAL_MAGIC = (0x377F0682, 0x377F0683)
_WAL_HEAD, _FRAME_HEAD = 32, 24


def declared_page_size(head: bytes) -> int | None:
    """Return the page size in the first bytes of a file; None where it makes no sense."""
    size = int.from_bytes(head[16:18], "big")
    size = 65536 if size == 1 else size
    return size if size in SIZES else None


@dataclass(frozen=True, slots=True)
class Cell:
    """A row in a leaf page.

    Attributes
    ----------
    rowid : int
    size : int
        Bytes of the whole payload.
    start : bytes
        The part of the payload in the leaf.
    overflow : int
        Number of the page with the rest; 0 where there is none.
    """

    rowid: int
    size: int
    start: bytes
    overflow: int


class SqlitePages:
    """The pages of a file, those of its write-ahead log in the place of older ones."""

    def __init__(self, path: Path, page_size: int) -> None:
        self._file = path.open("rb", buffering=0)
        self.page_size = page_size
        self.count = -(-os.fstat(self._file.fileno()).st_size // page_size)
        self._file.seek(20)
        reserved = (self._file.read(1) or b"\0")[0]
        self._usable = page_size - (reserved if reserved <= 32 else 0)
        log = path.with_name(path.name + "-wal")
        self._log = log.open("rb", buffering=0) if log.is_file() else None
        self._newer = {} if self._log is None else self._read_log()
        self.count = max([self.count, *self._newer])

    def close(self) -> None:
        """Close the files."""
        self._file.close()
        if self._log is not None:
            self._log.close()

    def _read_log(self) -> dict[int, int]:
        """Return where in the log each page is newest, up to the last whole transaction."""
        assert self._log is not None
        head = self._log.read(_WAL_HEAD)
        if len(head) < _WAL_HEAD or struct.unpack_from(">I", head)[0] not in _WAL_MAGIC:
            return {}
        salt = head[16:24]
        newest: dict[int, int] = {}
        pending: dict[int, int] = {}
        at = _WAL_HEAD
        while True:
            self._log.seek(at)
            frame = self._log.read(_FRAME_HEAD)
            end = at + _FRAME_HEAD + self.page_size
            if len(frame) < _FRAME_HEAD or frame[8:16] != salt:
                return newest
            if end > os.fstat(self._log.fileno()).st_size:
                return newest
            number, committed = struct.unpack_from(">II", frame)
            pending[number] = at + _FRAME_HEAD
            if committed:
                newest |= pending
                pending = {}
            at = end

    def page(self, number: int) -> bytes:
        """Return a page, numbered from 1; shorter or empty where the file is cut."""
        file, at = self._file, (number - 1) * self.page_size
        if number in self._newer and self._log is not None:
            file, at = self._log, self._newer[number]
        file.seek(at)
        return file.read(self.page_size) or b""

    def leaves(self, kind: int = TABLE) -> Iterator[tuple[int, bytes]]:
        """Yield the leaf pages of one kind with their numbers."""
        for first in range(1, self.count + 1, _BLOCK):
            self._file.seek((first - 1) * self.page_size)
            block = self._file.read(_BLOCK * self.page_size)
            kinds = np.frombuffer(block, np.uint8)[:: self.page_size]
            leaves = {first + int(k) for k in np.flatnonzero(kinds == kind)}
            leaves |= {n for n in self._newer if first <= n < first + _BLOCK}
            leaves |= {1} if first == 1 else set()
            for number in sorted(leaves):
                page = self.page(number)
                if page[100 if number == 1 else 0 :][:1] == bytes([kind]):
                    yield number, page

    def cells(self, number: int, page: bytes) -> Iterator[Cell]:
        """Yield the rows of a table's leaf; those that make no sense are left out."""
        for place in _cell_places(number, page):
            try:
                yield self._cell(page, place)
            except (IndexError, struct.error):
                continue

    def indexed_rows(self) -> Iterator[int]:
        """Yield the numbers of the rows that are in the index of an integer column."""
        for number, page in self.leaves(INDEX):
            for place in _cell_places(number, page):
                with suppress(IndexError):
                    size, at = varint(page, place)
                    row = columns(page[at : at + size], 2)
                    if row is not None and len(row) == 2 and isinstance(row[1], int):
                        yield row[1]

    def _cell(self, page: bytes, at: int) -> Cell:
        size, at = varint(page, at)
        rowid, at = varint(page, at)
        most = self._usable - 35
        if size <= most:
            return Cell(rowid, size, page[at : at + size], 0)
        least = (self._usable - 12) * 32 // 255 - 23
        local = least + (size - least) % (self._usable - 4)
        local = local if local <= most else least
        (overflow,) = struct.unpack_from(">I", page, at + local)
        return Cell(rowid, size, page[at : at + local], overflow)

    def payload(self, cell: Cell) -> bytes | None:
        """Return the whole payload of a row; None where a page of it is missing."""
        if cell.size > self.count * self.page_size:
            return None
        parts, have, number = [cell.start], len(cell.start), cell.overflow
        while have < cell.size:
            page = self.page(number) if 1 < number <= self.count else b""
            if len(page) < self._usable:
                return None
            part = page[4 : min(self._usable, 4 + cell.size - have)]
            parts.append(part)
            have += len(part)
            number = int.from_bytes(page[:4], "big")
        return b"".join(parts)


def _cell_places(number: int, page: bytes) -> tuple[int, ...]:
    """Return where in a leaf its cells begin."""
    at = 100 if number == 1 else 0
    count = int.from_bytes(page[at + 3 : at + 5], "big")
    room = min(count, (len(page) - at - 8) // 2)
    return struct.unpack_from(f">{max(0, room)}H", page, at + 8)


def varint(data: bytes, at: int) -> tuple[int, int]:
    """Return SQLite's number of variable length, and where it ends."""
    value = 0
    for k in range(8):
        byte = data[at + k]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, at + k + 1
    return value << 8 | data[at + 8], at + 9


def columns(payload: bytes, most: int) -> list[object] | None:
    """Return the values of a row; None where they make no sense or are more than `most`."""
    try:
        end, at = varint(payload, 0)
        kinds: list[int] = []
        while at < end and len(kinds) <= most:
            kind, at = varint(payload, at)
            kinds.append(kind)
        if at != end or len(kinds) > most:
            return None
        values: list[object] = []
        for kind in kinds:
            size = (0, 1, 2, 3, 4, 6, 8, 8, 0, 0)[kind] if kind < 10 else (kind - 12) // 2
            if kind in (10, 11) or at + size > len(payload):
                return None
            values.append(_cell_value(kind, payload[at : at + size]))
            at += size
    except (IndexError, UnicodeDecodeError):
        return None
    return values


def _cell_value(kind: int, data: bytes) -> object:
    if kind == 0:
        return None
    if kind == 7:
        return struct.unpack(">d", data)[0]
    if kind in (8, 9):
        return kind - 8
    if kind < 7:
        return int.from_bytes(data, "big", signed=True)
    return data.decode() if kind % 2 else data
