"""Saves what can still be read of a cut or damaged bag into a whole one."""

import os
import shlex
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_errors import (
    no_bag_there,
    nothing_to_save,
    unreadable,
    why_no_storage,
)
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB
from worm_tracker.sources.bags.scan.scan import Survey, scan_bag
from worm_tracker.sources.bags.scan.scan_result import Found, Lost, Topic

_LATEST_NS = 2**64 - 1


def name_of_repaired(bag: Path) -> Path:
    """Return where a repaired bag goes if nothing else is said: beside the damaged one.

    A file that is part of a bag's directory is repaired beside that directory, or it would be
    taken for another part of it.
    """
    bag = bag.absolute()
    folder = bag.parent
    if not bag.is_dir() and (folder / "metadata.yaml").is_file():
        folder = folder.parent
    stem = bag.name if bag.is_dir() else bag.name.split(".")[0]
    return folder / f"{stem}_repaired.mcap"


def repair_bag(damaged: Path, repaired: Path, max_chunk_mib: float = MAX_CHUNK_MIB) -> Survey:
    """Copy every message that can be read into a new .mcap file, with index and checksums.

    Parameters
    ----------
    damaged : Path
        A rosbag2 directory, with or without its metadata.yaml, an .mcap or a .db3 file.
    repaired : Path
        The .mcap file to write; it must not exist.
    max_chunk_mib : float
        Largest piece of the bag, decompressed, that is read.

    Returns
    -------
    Survey
        What was saved, and what was lost.

    Raises
    ------
    BadInput
        `damaged` is no bag, `repaired` is there already or cannot be written, or not one message
        can be read.
    """
    _refuse_taken_name(damaged, repaired)
    survey = Survey()
    with _appearing_whole(repaired) as target:
        try:
            _copy(_surveyed(scan_bag(damaged, max_chunk_mib), survey, damaged), target)
        except OSError as error:  # the disk is full, not the bag damaged
            raise _not_written(repaired, error) from error
        if not survey.messages:
            raise nothing_to_save(damaged, survey.losses)
    return survey


def _refuse_taken_name(damaged: Path, repaired: Path) -> None:
    try:
        there, taken = damaged.exists(), os.path.lexists(repaired)
    except OSError:  # a name that is too long for the file system
        there, taken = False, False
    if not there:
        raise no_bag_there(damaged)
    fault = why_no_storage(damaged)
    if fault is not None:
        raise fault
    if repaired.suffix != ".mcap":
        raise BadInput(f"--out {repaired}: a repaired bag is an .mcap file: let its name end so")
    if taken:
        raise BadInput(f"{repaired}: exists already; choose another name with --out")


def _not_written(path: Path, error: OSError) -> BadInput:
    return BadInput(f"{path}: cannot be written: {error.strerror}; choose another place with --out")


@contextmanager
def _appearing_whole(path: Path) -> Iterator[BinaryIO]:
    """Give a file that takes its name when it is whole, and never the place of another."""
    try:
        number, name = tempfile.mkstemp(prefix=f".{path.name}.partial-", dir=path.parent)
    except OSError as error:
        raise _not_written(path, error) from error
    partial = Path(name)
    try:
        with os.fdopen(number, "wb") as target:
            yield target
            target.flush()
            os.fsync(target.fileno())
        mask = os.umask(0)
        os.umask(mask)
        partial.chmod(0o666 & ~mask)
        try:
            os.link(partial, path)
        except FileExistsError:
            raise BadInput(
                f"{path}: exists already; choose another name, such as "
                f"`--out {shlex.quote(str(path.with_name('again_' + path.name)))}`"
            ) from None
        except OSError:  # a file system without links
            partial.rename(path)
    finally:
        with suppress(FileNotFoundError):
            partial.unlink()


def _surveyed(found: Iterable[Found], survey: Survey, damaged: Path) -> Iterator[Found]:
    """Yield what is found, counted; a disk that fails under the bag is the bag's fault."""
    try:
        for item in found:
            survey.take(item)
            yield item
    except OSError as error:
        raise unreadable(damaged, error) from error


def _copy(found: Iterable[Found], target: BinaryIO) -> None:
    writer = Writer(target, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="worm-escape")
    channels: dict[Topic, int] = {}
    for item in found:
        if isinstance(item, Lost):
            continue
        if item.topic not in channels:
            channels[item.topic] = _register(writer, item.topic)
        writer.add_message(
            channels[item.topic],
            min(max(item.log_ns, 0), _LATEST_NS),
            item.data,
            min(max(item.publish_ns, 0), _LATEST_NS),
            item.sequence,
        )
    writer.finish()


def _register(writer: Writer, topic: Topic) -> int:
    definition, form = topic.definition, topic.definition_format
    if not definition:
        store = get_typestore(Stores.ROS2_JAZZY)
        with suppress(Exception):  # a type that is not one of ROS 2's own stays without
            definition, _ = store.generate_msgdef(topic.type, ros_version=2)
            form = "ros2msg"
    schema = writer.register_schema(topic.type, form, definition.encode())
    return int(
        writer.register_channel(topic.name, topic.serialization, schema, dict(topic.metadata))
    )
