"""Says in one line what is wrong with a file that should be a bag, and what to do about it."""

import errno
import shlex
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.scan.scan import COMPRESSED_STORAGE, STORAGE, listed_files
from worm_tracker.sources.bags.scan.scan_result import Lost

_MCAP_MAGIC = b"\x89MCAP0\r\n"
_SQLITE_MAGIC = b"SQLite format 3\x00"
_VIDEOS = {".avi", ".mp4", ".mkv", ".mov", ".m4v", ".mpg", ".mpeg", ".webm", ".wmv"}
_KINDS_OF_BAGS = "a rosbag2 directory, an .mcap file or a .db3 file"
_LOGS = ("-wal", "-journal")


def no_bag_there(path: Path) -> BadInput:
    """Return the fault of a path that leads nowhere."""
    return BadInput(f"{path}: no such bag; give {_KINDS_OF_BAGS}")


def why_not_a_bag(path: Path) -> BadInput | None:
    """Return the fault of something that exists and is no sound bag; None where it looks like one.

    Nothing but regular files is opened: reading a pipe would wait for ever.
    """
    fault = why_no_storage(path)
    if fault is None:
        fault = _why_not_a_bag_directory(path) if path.is_dir() else _why_not_a_bag_file(path)
    if fault is not None:
        return fault
    for file in _storage_files(path):
        if any(_has_bytes(file.with_name(file.name + log)) for log in _LOGS):
            return BadInput(
                f"{file}: its recorder was not closed: messages wait in a journal beside it; "
                f"{_repair(path)}"
            )
        if file.suffix in STORAGE and _is_cut(file):
            return BadInput(f"{file}: cut short, its end is missing; {_repair(path)}")
    return None


def why_no_storage(path: Path) -> BadInput | None:
    """Return the fault of a path in which there is nothing that a scan could read."""
    if not path.is_dir():
        return _why_not_storage(path)
    files = _storage_files(path)
    if not files and not (path / "metadata.yaml").is_file():
        return BadInput(
            f"{path}: not a bag: the directory holds no metadata.yaml; give {_KINDS_OF_BAGS}"
        )
    odd = next((file for file in files if not file.is_file()), None)
    if odd is not None:
        return BadInput(f"{odd}: not a regular file, so no part of a bag; take it out of the bag")
    return None


def _why_not_storage(path: Path) -> BadInput | None:
    quoted = shlex.quote(str(path))
    if path.suffix in _VIDEOS:
        return BadInput(
            f"{path}: a video, not a bag; turn it into one with `worm import {quoted} --out BAG`"
        )
    if path.suffix == ".bag":
        return BadInput(
            f"{path}: a ROS 1 bag; turn it into a rosbag2 with "
            f"`rosbags-convert --src {quoted} --dst BAG`"
        )
    if path.suffix not in STORAGE:
        return BadInput(f"{path}: not a bag; give {_KINDS_OF_BAGS}")
    if not path.is_file():
        return BadInput(f"{path}: not a regular file, so not a bag; give {_KINDS_OF_BAGS}")
    if not _has_bytes(path):
        return BadInput(f"{path}: the file is empty (0 bytes); copy it again, or give another")
    return None


def _why_not_a_bag_file(path: Path) -> BadInput | None:
    try:
        with path.open("rb") as file:
            head = file.read(16)
    except OSError as error:
        return BadInput(f"{path}: cannot be read: {error.strerror}")
    if path.suffix == ".mcap" and not head.startswith(_MCAP_MAGIC):
        return BadInput(
            f"{path}: not a bag, or a damaged one: it does not begin as an mcap file does; if it "
            f"was one, {_repair(path)}"
        )
    if path.suffix == ".db3" and not head.startswith(_SQLITE_MAGIC):
        return BadInput(
            f"{path}: not a bag, or a damaged one: it does not begin as a SQLite database does; "
            f"if it was one, {_repair(path)}"
        )
    return None


def _why_not_a_bag_directory(path: Path) -> BadInput | None:
    if not (path / "metadata.yaml").is_file():
        return BadInput(
            f"{path}: metadata.yaml is missing, the recorder was not closed; {_repair(path)}"
        )
    names = listed_files(path / "metadata.yaml")
    twice = next((name for name, count in Counter(names).items() if count > 1), None)
    if twice is not None:
        return BadInput(
            f"{path}: metadata.yaml lists {twice} twice, so that each of its pictures would be "
            f"counted twice; delete one of the lines, or {_repair(path)}"
        )
    for name in names:
        file = path / name
        if not _is_there(file):
            return BadInput(
                f"{path}: metadata.yaml lists {name[:80]}, which is not there as a regular file; "
                f"copy it again, or {_repair(path)}"
            )
    return None


def damaged(path: Path, why: str) -> BadInput:
    """Return the fault of a bag in which something cannot be read."""
    return BadInput(f"{path}: damaged ({why.rstrip('.')}); {_repair(path)}")


def nothing_to_save(path: Path, losses: Sequence[Lost]) -> BadInput:
    """Return the fault of a bag of which nothing is left."""
    why = "; ".join(loss.why for loss in losses[:3]) or "it holds none"
    return BadInput(f"{path}: not one message can be read; nothing can be saved ({why})")


def unreadable(path: Path, error: Exception) -> BadInput:
    """Return the fault of a bag that cannot be read, or not to its end."""
    if isinstance(error, BadInput):
        return error
    if isinstance(error, OSError) and error.errno is not None:
        if error.errno == errno.ENOSPC:
            return BadInput(f"{path}: cannot be unpacked: no space for temporary files")
        return BadInput(f"{path}: cannot be read: {error.strerror}")
    reason = " ".join(str(error).split()) or type(error).__name__
    if "Profile is not ros2" in reason:
        return BadInput(f"{path}: an mcap file, but not one of ROS 2; convert it to a rosbag2")
    return damaged(path, reason)


def _storage_files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    names = (*STORAGE, *COMPRESSED_STORAGE)
    return sorted(file for file in path.iterdir() if file.name.endswith(names))


def _is_there(file: Path) -> bool:
    try:
        return file.is_file()
    except OSError:  # a name that is too long for the file system
        return False


def _has_bytes(file: Path) -> bool:
    return _is_there(file) and file.stat().st_size > 0


def _is_cut(file: Path) -> bool:
    """Tell whether the file ends before its format says that it should."""
    size = file.stat().st_size
    with file.open("rb") as stream:
        head = stream.read(32)
        if file.suffix == ".mcap":
            stream.seek(-min(size, len(_MCAP_MAGIC)), 2)
            return stream.read() != _MCAP_MAGIC
    # SQLite's header: page size at 16 (1 means 65536), number of pages at 28, both big-endian.
    page = int.from_bytes(head[16:18], "big")
    pages = int.from_bytes(head[28:32], "big")
    return len(head) < 32 or size < (65536 if page == 1 else page) * pages


def _repair(path: Path) -> str:
    return (
        f"save what is there with `worm repair {shlex.quote(str(path))}`, or replay what is there "
        "with --salvage"
    )
