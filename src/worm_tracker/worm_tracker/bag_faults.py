"""Says in one line what is wrong with a file that should be a bag, and what to do about it."""

import errno
from pathlib import Path

from worm_msgs_py.errors import BadInput

_MCAP_MAGIC = b"\x89MCAP0\r\n"
_SQLITE_MAGIC = b"SQLite format 3\x00"
_VIDEOS = {".avi", ".mp4", ".mkv", ".mov", ".m4v", ".mpg", ".mpeg", ".webm", ".wmv"}
_STORAGE = (".mcap", ".db3")
_KINDS = "a rosbag2 directory, an .mcap file or a .db3 file"


def no_bag_there(path: Path) -> BadInput:
    """Return the fault of a path that leads nowhere."""
    return BadInput(f"{path}: no such bag; give {_KINDS}")


def why_not_a_bag(path: Path) -> BadInput | None:
    """Return the fault of something that exists and is no bag; None where it looks like one."""
    fault = _why_not_a_bag_directory(path) if path.is_dir() else _why_not_a_bag_file(path)
    if fault is not None:
        return fault
    return next((_cut(file) for file in _storage_files(path) if _is_cut(file)), None)


def _why_not_a_bag_file(path: Path) -> BadInput | None:
    if path.suffix in _VIDEOS:
        return BadInput(
            f"{path}: a video, not a bag; turn it into one with `worm import {path} --out BAG`"
        )
    if path.suffix == ".bag":
        return BadInput(
            f"{path}: a ROS 1 bag; turn it into a rosbag2 with "
            f"`rosbags-convert --src {path} --dst BAG`"
        )
    if path.suffix not in _STORAGE:
        return BadInput(f"{path}: not a bag; give {_KINDS}")
    try:
        with path.open("rb") as file:
            head = file.read(16)
    except OSError as error:
        return BadInput(f"{path}: cannot be read: {error.strerror}")
    if not head:
        return BadInput(f"{path}: the file is empty (0 bytes); the recorder never wrote to it")
    if path.suffix == ".mcap" and not head.startswith(_MCAP_MAGIC):
        return BadInput(f"{path}: not a bag: it does not begin as an mcap file does")
    if path.suffix == ".db3" and not head.startswith(_SQLITE_MAGIC):
        return BadInput(f"{path}: not a bag: it does not begin as a SQLite database does")
    return None


def _why_not_a_bag_directory(path: Path) -> BadInput | None:
    if (path / "metadata.yaml").is_file():
        return None
    storage = sorted(file for file in path.iterdir() if file.suffix in _STORAGE)
    if not storage:
        return BadInput(f"{path}: not a bag: the directory holds no metadata.yaml; give {_KINDS}")
    return BadInput(
        f"{path}: metadata.yaml is missing, the recorder was not closed; give {storage[0]} itself, "
        f"or rebuild the index with `ros2 bag reindex {path}`"
    )


def unreadable(path: Path, error: Exception) -> BadInput:
    """Return the fault of a bag that cannot be read, or not to its end."""
    if isinstance(error, BadInput):
        return error
    if isinstance(error, OSError) and error.errno in (errno.EACCES, errno.EPERM, errno.EIO):
        return BadInput(f"{path}: cannot be read: {error.strerror}")
    reason = " ".join(str(error).split()) or type(error).__name__
    if "Profile is not ros2" in reason:
        return BadInput(f"{path}: an mcap file, but not one of ROS 2; convert it to a rosbag2")
    files = [file for file in _storage_files(path) if file.exists()]
    remedy = _repair(files[0]) if files else "copy it again"
    return BadInput(f"{path}: damaged ({reason.rstrip('.')}); {remedy}")


def _storage_files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    return sorted(file for file in path.iterdir() if file.suffix in _STORAGE)


def _cut(file: Path) -> BadInput:
    return BadInput(f"{file}: cut short, its end is missing; {_repair(file)}")


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


def _repair(file: Path) -> str:
    if file.suffix == ".mcap":
        whole = file.with_name(f"{file.stem}_repaired.mcap")
        return f"save what is there with `python -m worm_tracker.bag_repair {file} {whole}`"
    return f"save what is there with `sqlite3 {file} .recover | sqlite3 repaired.db3`"
