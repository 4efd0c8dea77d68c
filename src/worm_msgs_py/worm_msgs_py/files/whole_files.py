"""Files and folders that are there whole or not at all, and never in the place of another's."""

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from worm_msgs_py.errors import BadInput


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a new name beside `path` to write to; the file moves to `path` where the block succeeds.

    What is at `path` is replaced: it is for a file that is ours.
    """
    unfinished = _partial_path(path)
    try:
        yield unfinished
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


@contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """Give a new name beside `path` to write to, as `whole_file`, but replace nothing.

    Raises
    ------
    BadInput
        Something is at `path`, at the start or by the end, or it cannot be written.
    """
    refuse_existing(path)
    unfinished = _partial_path(path)
    with _write_errors_in_a_line(path):
        try:
            yield unfinished
            try:
                os.link(unfinished, path)  # unlike a rename it never replaces
            except FileExistsError:
                raise _exists_already(path) from None
            except OSError as error:
                if error.errno not in (errno.EPERM, errno.EOPNOTSUPP):
                    raise
                refuse_existing(path)  # a file system without links
                unfinished.rename(path)
        finally:
            unfinished.unlink(missing_ok=True)


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """Give the name of a folder to make; it moves to `path` where the block succeeds.

    It has the last name of `path`, so that what is named after its folder is named right.

    Raises
    ------
    BadInput
        Something is at `path`, at the start or by the end, or it cannot be written.
    """
    refuse_existing(path)
    unfinished = _partial_path(path)
    with _write_errors_in_a_line(path):
        try:
            unfinished.mkdir(parents=True)
            yield unfinished / path.name
            refuse_existing(path)
            (unfinished / path.name).rename(path)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)


def refuse_existing(path: Path) -> None:
    """Raise BadInput where something is at `path`, be it a link that leads nowhere."""
    if os.path.lexists(path):
        raise _exists_already(path)


def _exists_already(path: Path) -> BadInput:
    return BadInput(f"{path}: exists already; remove it or choose another name")


@contextmanager
def _write_errors_in_a_line(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        why = error.strerror or " ".join(str(error).split())
        raise BadInput(f"{path}: cannot be written ({why}); choose another place") from error


def _partial_path(path: Path) -> Path:
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
