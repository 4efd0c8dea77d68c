"""Scans all storage files of a bag, with or without its metadata.yaml."""

import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml
import zstandard

from worm_tracker.sources.bags.scan.db3_scan import Db3Scan
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB, MIB, decompress, is_zstd
from worm_tracker.sources.bags.scan.mcap_scan import McapScan
from worm_tracker.sources.bags.scan.scan_result import Found, FoundMessage, Lost, Topic

STORAGE = (".mcap", ".db3")
COMPRESSED_STORAGE = tuple(f"{suffix}.zstd" for suffix in STORAGE)
_COPY_BYTES = 1 << 22


def storage_files(bag: Path) -> list[Path]:
    """Return the storage files of a bag in the order in which they were recorded.

    Those that metadata.yaml lists, each once; where it is missing or ruined, all that are there.
    """
    if not bag.is_dir():
        return [bag]
    there = sorted(
        (file for file in bag.iterdir() if file.name.endswith((*STORAGE, *COMPRESSED_STORAGE))),
        key=_file_order,
    )
    listed = [bag / Path(name).name for name in listed_files(bag / "metadata.yaml")]
    known = [file for file in dict.fromkeys(listed) if file in there]
    return [file for file in known or there if file.is_file()]


def _file_order(file: Path) -> tuple[int, str]:
    """Return what sorts bag_2.mcap before bag_10.mcap."""
    digits = file.name.split(".")[0].rpartition("_")[2]
    return (int(digits) if digits.isdigit() and len(digits) < 10 else -1, file.name)


def listed_files(metadata: Path) -> list[str]:
    """Return the names of the storage files in a metadata.yaml; none where it makes no sense."""
    names = _metadata(metadata).get("relative_file_paths")
    return [name for name in names if isinstance(name, str)] if isinstance(names, list) else []


def _metadata(file: Path) -> dict[str, Any]:
    """Return what a metadata.yaml says; nothing where it makes no sense."""
    try:
        text = file.read_text(encoding="utf-8") if file.is_file() else ""
        return dict(yaml.safe_load(text)["rosbag2_bagfile_information"])
    except (OSError, ValueError, TypeError, KeyError, RecursionError, yaml.YAMLError):
        return {}


def scan_file(file: Path, max_chunk_mib: float = MAX_CHUNK_MIB) -> Iterator[Found]:
    """Yield what is in one storage file; what its losses say begins with its name.

    Raises
    ------
    OSError
        The file cannot be opened or the disk fails.
    """
    limit = round(max_chunk_mib * MIB)
    if file.name.endswith(COMPRESSED_STORAGE):
        yield from _scan_compressed(file, max_chunk_mib)
        return
    scan = Db3Scan(file) if file.suffix == ".db3" else McapScan(file, limit)
    for found in scan:
        if isinstance(found, Lost):
            yield replace(found, why=f"{file.name}: {found.why}")
        else:
            yield unpacked(found, limit)


def unpacked(found: FoundMessage, limit: int) -> FoundMessage:
    """Undo rosbag2's compression of each message for itself, as far as it can be."""
    if not is_zstd(found.data):
        return found
    return replace(found, data=decompress(found.data, "zstd", limit)[0])


def _scan_compressed(file: Path, max_chunk_mib: float) -> Iterator[Found]:
    """Decompress a file of rosbag2's compression mode "file" as far as it goes, and scan that."""
    with tempfile.TemporaryDirectory(prefix="worm-") as folder:
        plain = Path(folder) / file.name.removesuffix(".zstd")
        try:
            with (
                file.open("rb") as packed,
                plain.open("wb") as target,
                zstandard.ZstdDecompressor().stream_reader(packed) as stream,
            ):
                shutil.copyfileobj(stream, target, _COPY_BYTES)
        except zstandard.ZstdError as error:
            yield Lost(f"{file.name}: its compressed data is damaged ({error})", None)
        yield from scan_file(plain, max_chunk_mib)


@dataclass(slots=True)
class Survey:
    """What a whole scan of a bag has found, without keeping the messages."""

    messages: Counter[Topic] = field(default_factory=Counter)
    losses: list[Lost] = field(default_factory=list)
    first_ns: int | None = None
    last_ns: int | None = None

    @property
    def saved(self) -> int:
        """Number of messages that were found."""
        return self.messages.total()

    def take(self, found: Found) -> None:
        """Count one thing."""
        if isinstance(found, Lost):
            self.losses.append(found)
            return
        self.messages[found.topic] += 1
        if 0 <= found.log_ns < 2**63:
            self.first_ns = found.log_ns if self.first_ns is None else self.first_ns
            self.last_ns = max(found.log_ns, self.last_ns or 0)


def scan_bag(bag: Path, max_chunk_mib: float = MAX_CHUNK_MIB) -> Iterator[Found]:
    """Yield what is in all storage files of a bag, file after file, then what its index misses."""
    known = 0
    for file in storage_files(bag):
        for found in scan_file(file, max_chunk_mib):
            known += (found.messages or 0) if isinstance(found, Lost) else 1
            yield found
    counted = _metadata(bag / "metadata.yaml").get("message_count")
    if isinstance(counted, int) and counted > known:
        why = f"metadata.yaml counts {counted} messages, {known} were found or missed"
        yield Lost(why, counted - known)
