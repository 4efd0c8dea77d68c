"""Reads the summary at the end of an mcap file as far as it is sound."""

import struct
from binascii import crc32
from dataclasses import dataclass, field
from typing import BinaryIO

from worm_tracker.sources.bags.scan.mcap_records import (
    HEAD,
    MCAP_MAGIC,
    ChunkPlace,
    Described,
    Op,
    is_plausible,
    read_chunk_index,
    read_statistics,
)

_FOOTER = HEAD.size + 20 + len(MCAP_MAGIC)
_DATA_END = HEAD.size + 4
_LARGEST_SUMMARY = 1 << 28


@dataclass(slots=True)
class McapSummary:
    """What the end of the file says of the rest of it.

    Attributes
    ----------
    starts_at : int
        Where the data ends and the summary begins; 0 where that is not known.
    sound : bool
        Whether every record of it can be read and its checksum, if there is one, is right.
    described : Described
        Schemas and channels.
    chunks : dict
        The chunks by their place in the file.
    counts : dict
        Messages of each channel; empty where it does not say, or is not sound.
    """

    starts_at: int = 0
    sound: bool = False
    described: Described = field(default_factory=Described)
    chunks: dict[int, ChunkPlace] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)

    @property
    def places(self) -> list[int]:
        """Where the chunks begin, in order."""
        return sorted(self.chunks)

    def span(self, after_ns: int | None, before_ns: int | None) -> tuple[int, int] | None:
        """Return where the chunks begin and end that were recorded in a time.

        None where the summary is not sound, or messages lie beside the chunks: then all of the file
        must be gone through.
        """
        inside = sum(place.messages for place in self.chunks.values())
        if not self.sound or inside == 0 or inside != sum(self.counts.values()):
            return None
        wanted = [
            place
            for place in self.chunks.values()
            if (after_ns is None or place.end_ns >= after_ns)
            and (before_ns is None or place.start_ns < before_ns)
        ]
        begins = (place.offset for place in wanted)
        ends = (place.offset + place.length for place in wanted)
        return min(begins, default=self.starts_at), max(ends, default=self.starts_at)


def read_mcap_summary(file: BinaryIO, size: int) -> McapSummary:
    """Return the summary; an empty one where there is none or it makes no sense."""
    summary = McapSummary()
    if size < len(MCAP_MAGIC) + _FOOTER:
        return summary
    file.seek(size - _FOOTER)
    footer = file.read(_FOOTER)
    op, length = HEAD.unpack_from(footer)
    if not footer.endswith(MCAP_MAGIC) or op != Op.FOOTER or length != 20:
        return summary
    start, _, crc = struct.unpack_from("<QQI", footer, HEAD.size)
    if start == 0:
        return summary
    if (
        not len(MCAP_MAGIC) + _DATA_END <= start <= size - _FOOTER
        or size - start > _LARGEST_SUMMARY
    ):
        return summary
    file.seek(start - _DATA_END)
    ends = HEAD.unpack(file.read(HEAD.size))
    if ends != (Op.DATA_END, 4):
        return summary
    summary.starts_at = start
    file.seek(start)
    records = file.read(size - _FOOTER - start)
    summary.sound = _take_records(summary, records)
    # The checksum covers the summary and the footer up to itself.
    if crc and crc32(footer[: HEAD.size + 16], crc32(records)) != crc:
        summary.sound = False
    if not summary.sound:
        summary.counts = {}
    return summary


def _take_records(summary: McapSummary, records: bytes) -> bool:
    """Take the summary's records; False from the first one on that cannot be read."""
    at = 0
    while at < len(records):
        if at + HEAD.size > len(records):
            return False
        op, length = HEAD.unpack_from(records, at)
        at += HEAD.size
        body = records[at : at + length]
        if not is_plausible(op, length, body[:64], len(records) - at):
            return False
        try:
            if op in (Op.SCHEMA, Op.CHANNEL):
                if not summary.described.take(op, body):
                    return False
            elif op == Op.CHUNK_INDEX:
                place = read_chunk_index(body)
                summary.chunks[place.offset] = place
            elif op == Op.STATISTICS:
                summary.counts = read_statistics(body)
        except (ValueError, struct.error):
            return False
        at += length
    return True
