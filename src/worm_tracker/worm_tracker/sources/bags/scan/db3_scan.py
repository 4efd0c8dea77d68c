"""Reads the messages of a .db3 file: through SQLite where it is sound, page by page where not."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from worm_tracker.sources.bags.scan.scan_result import Found, FoundMessage, Lost, Topic
from worm_tracker.sources.bags.scan.sqlite_pages import (
    SIZES,
    SQLITE_MAGIC,
    Cell,
    SqlitePages,
    columns,
    declared_page_size,
)
from worm_tracker.sources.bags.scan.topic_guess import guessed_topic

_FAR = 1000
"""A row whose number is this far beyond their count has a damaged number."""


def sound_rows(
    path: Path, topic: str, after_ns: int | None = None, before_ns: int | None = None
) -> Iterator[Found]:
    """Yield the messages of one topic in the order of recording, as SQLite reads them.

    Parameters
    ----------
    path : Path
    topic : str
    after_ns, before_ns : int, optional
        Leave out what was recorded before the one, or not before the other; missing rows are then
        not looked for.

    Raises
    ------
    sqlite3.Error
        Where the file is damaged.
    """
    uri = f"{path.resolve().as_uri()}?immutable=1&mode=ro"
    with closing(sqlite3.connect(uri, uri=True)) as database:
        cursor = database.execute(
            "SELECT t.name, t.type, m.timestamp, m.data FROM messages m "
            "JOIN topics t ON m.topic_id = t.id WHERE t.name = ?1 "
            "AND (?2 IS NULL OR m.timestamp >= ?2) AND (?3 IS NULL OR m.timestamp < ?3) "
            "ORDER BY m.timestamp, m.id",
            (topic, after_ns, before_ns),
        )
        for name, kind, log_ns, data in cursor:
            blob = data if isinstance(data, bytes) else b""
            time = log_ns if isinstance(log_ns, int) else -1
            yield FoundMessage(Topic(str(name), str(kind)), time, time, 0, blob)
        if after_ns is not None or before_ns is not None:
            return
        count, first, last = database.execute(
            "SELECT count(*), min(id), max(id) FROM messages NOT INDEXED"
        ).fetchone()
    if count and last - first + 1 != count:
        missing = last - first + 1 - count
        yield Lost(f"{missing} numbers are missing among its rows", max(0, missing))


class Db3Scan:
    """The messages of a .db3 file in the order of their rows, whatever is left of it.

    Leaf pages are found by their first byte and read for themselves: a damaged page costs its own
    rows. Pages in a write-ahead log that SQLite has not taken over yet are read from there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def __iter__(self) -> Iterator[Found]:
        """Yield messages, then what could not be read."""
        with self._path.open("rb") as file:
            head = file.read(100)
        declared = declared_page_size(head)
        sizes = dict.fromkeys(([declared] if declared else []) + list(SIZES))
        for size in sizes:
            pages = SqlitePages(self._path, size)
            with closing(pages):
                rows = _Rows(pages)
                if rows.messages:
                    yield from rows
                    yield from _about_the_header(head, declared, size)
                    return
        yield Lost("no row of a table of messages is in it", None)


def _about_the_header(head: bytes, declared: int | None, size: int) -> Iterator[Lost]:
    if not head.startswith(SQLITE_MAGIC) or declared != size:
        yield Lost(f"its header is damaged; it was read in pages of {size} bytes", 0)


class _Rows:
    """The rows of one file, as its leaf pages hold them."""

    def __init__(self, pages: SqlitePages) -> None:
        self._pages = pages
        self.topics: dict[int, Topic] = {}
        self.messages: dict[int, Cell] = {}
        self._definitions: dict[str, tuple[str, str]] = {}
        for number, page in pages.leaves():
            for cell in pages.cells(number, page):
                self._take(cell)

    def _take(self, cell: Cell) -> None:
        """Keep a row of messages for later, and what a row of the other tables says."""
        if _is_message(cell.start):
            self.messages.setdefault(cell.rowid, cell)
            return
        if cell.size > 1 << 22:
            return
        payload = self._pages.payload(cell)
        row = None if payload is None else columns(payload, 6)
        if row is None or len(row) < 4 or not all(isinstance(text, str) for text in row[1:]):
            return
        texts = [str(text) for text in row[1:]]
        if "/" in texts[1] and texts[0].startswith("/"):
            self.topics.setdefault(cell.rowid, Topic(texts[0], texts[1], texts[2] or "cdr"))
        elif len(texts) >= 3 and texts[1] in ("ros2msg", "ros2idl"):
            self._definitions[texts[0]] = (texts[2], texts[1])

    def __iter__(self) -> Iterator[Found]:
        read = 0
        unread: list[int] = []
        for rowid in sorted(self.messages):
            payload = self._pages.payload(self.messages[rowid])
            row = None if payload is None else columns(payload, 4)
            topic = None
            if row is not None and isinstance(row[1], int) and isinstance(row[3], bytes):
                topic = self._topic(row[1], row[3])
                if topic is not None:
                    read += 1
                    time = row[2] if isinstance(row[2], int) else -1
                    yield FoundMessage(topic, time, time, 0, row[3])
            if topic is None:
                unread.append(rowid)
        yield from self._missing(unread, read)

    def _topic(self, number: int, data: bytes) -> Topic | None:
        topic = self.topics.get(number) or guessed_topic(number, data)
        if topic is None or topic.type not in self._definitions:
            return topic
        definition, form = self._definitions[topic.type]
        return replace(topic, definition=definition, definition_format=form)

    def _missing(self, unread: list[int], read: int) -> Iterator[Lost]:
        if unread:
            which = f"row {unread[0]}" if len(unread) == 1 else f"{len(unread)} rows"
            yield Lost(f"{which} of its messages cannot be read: pages are damaged", len(unread))
        far = 2 * len(self.messages) + _FAR
        rows = [rowid for rowid in (*self.messages, *self._pages.indexed_rows()) if rowid <= far]
        gone = max(rows, default=0) - len(self.messages)
        if gone > 0:
            yield Lost(f"{gone} rows of its messages are gone: pages are damaged", gone)


def _is_message(start: bytes) -> bool:
    """Tell whether a row begins as one of messages does: (id, topic_id, timestamp, data)."""
    # The header of five numbers: its size, no id (it is the row's number), two integers, a blob.
    if len(start) < 6 or not 5 <= start[0] <= 9 or start[1] not in (0, 1, 2, 3, 4, 5, 6):
        return False
    kind = start[4]
    return (
        start[2] in (1, 2, 3, 4, 5, 6, 8, 9)
        and start[3] in (1, 2, 3, 4, 5, 6, 8, 9)
        and (kind >= 0x80 or (kind >= 12 and kind % 2 == 0))
    )
