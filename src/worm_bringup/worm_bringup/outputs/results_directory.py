"""A results directory that is there whole or not at all, and never costs a finished result."""

import errno
import os
import secrets
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from glob import escape
from itertools import count
from pathlib import Path
from typing import TypeGuard

import pyarrow as pa
import pyarrow.parquet as pq

from worm_bringup.outputs.directory_swap import put_in_place_of
from worm_bringup.outputs.earlier_result import (
    TRIAL,
    ResultKind,
    holds_summary,
    remove_result,
    why_corrections_are_lost,
    why_not_replaceable,
)
from worm_bringup.outputs.output_lock import InUse, is_in_use, output_lock
from worm_bringup.outputs.output_rules import resolve_out
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import Correction, kept_corrections
from worm_msgs_py.ros.running import finish_despite_signals
from worm_msgs_py.text import printable

_PARQUET_MAGIC = b"PAR1"
_OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO, errno.EFBIG, errno.EACCES)


class Kept(RuntimeError):  # noqa: N818 (it is what the results are)
    """Results were finished and are kept, but not where, or not as whole as, they should be.

    Attributes
    ----------
    directory : Path
        Where they are.
    interrupted : bool
        Whether a signal is the reason.
    """

    def __init__(self, said: str, directory: Path, *, interrupted: bool = False):
        super().__init__(said)
        self.directory = directory
        self.interrupted = interrupted


def check_out(out: Path, kind: ResultKind = TRIAL) -> None:
    """Refuse a results directory that cannot be made or replaced, and make nothing.

    Raises
    ------
    BadInput
        As from `results_directory`.
    """
    place = resolve_out(out)
    with _output_errors_in_a_line(out):
        _check_place(place, out, kind)
        if is_in_use(place):
            raise InUse


@contextmanager
def results_directory(out: Path, kind: ResultKind = TRIAL, *, live: bool = False) -> Iterator[Path]:
    """Give a new directory beside `out` to write into; it becomes `out` where the block succeeds.

    An earlier result of ours in `out` is replaced, in one step and only then; anything else is left
    alone. Where the block fails after it has written a whole ``summary.json``, or `out` cannot be
    replaced any more, the new results are kept under a name that `Kept` tells. Only one process at
    a time may write to `out`. What another has left behind that was killed is removed where it can
    be made again; finished results, and what is left of a live trial, are kept and told.

    Parameters
    ----------
    out : Path
        The directory to make; symbolic links are followed once, at the start.
    kind : ResultKind
        What it will hold, and an earlier result may hold.
    live : bool
        Whether its input cannot be had a second time.

    Raises
    ------
    BadInput
        `out` is no place for results (see `output_rules`), holds something that is not an earlier
        result, or corrections that would be lost, is written to by another process, or cannot be
        written.
    Kept
        See above.
    """
    place = resolve_out(out)
    with ExitStack() as stack:
        with _output_errors_in_a_line(out):
            _check_place(place, out, kind)
            place.parent.mkdir(parents=True, exist_ok=True)
            if stack.enter_context(output_lock(place)):
                _remove_leftovers(place, out, kind)
            _check_place(place, out, kind)
            partial = _new_beside(place, "live" if live else "partial")
            partial.mkdir()
        try:
            yield partial
        except BaseException as error:
            with finish_despite_signals():
                _save_or_remove(partial, place, out, kind, error, live=live)
                if _is_of_the_disk(error, partial):
                    raise _cannot_write(out, error) from error
                raise
        with finish_despite_signals():
            _finish(partial, place, out, kind)


def _save_or_remove(
    partial: Path,
    place: Path,
    out: Path,
    kind: ResultKind,
    error: BaseException,
    *,
    live: bool,
) -> None:
    """Keep what is whole after an error, and what cannot be had again; remove what is neither."""
    if not holds_summary(partial):
        if live and _has_frames(partial):
            unfinished = place.with_name(f"{place.name}-unfinished")
            kept = _path_for_people(_keep(partial, unfinished, try_first=unfinished), out)
            _print_line(
                f"{kept}: the tables and the bag of the trial until then, without a summary"
            )
            return
        with suppress(OSError):
            remove_result(partial, kind)
        return
    raise without_report(
        _path_for_people(_keep(partial, place, try_first=place), out), error
    ) from error


@contextmanager
def report_afterwards(out: Path) -> Iterator[Path]:
    """Give results that are in place to a block that writes their report, and say so.

    Raises
    ------
    Kept
        The block has failed, or was interrupted; or another run writes to `out` by now.
    """
    try:
        with output_lock(resolve_out(out)):
            _print_line(f"{out}: the results are whole; now their report (Ctrl-C leaves it out)")
            yield resolve_out(out)
    except InUse:
        raise without_report(out, RuntimeError("another run is writing there")) from None
    except BaseException as error:
        raise without_report(out, error) from error


def without_report(kept: Path, error: BaseException) -> Kept:
    """Return what is said of whole results whose report is not written because of an error."""
    interrupted = isinstance(error, KeyboardInterrupt)
    why = "interrupted" if interrupted else _in_a_line(error)
    return Kept(
        f"the results are whole and kept in {kept}, but their report is not written ({why}): "
        f"`worm report {kept}` writes it",
        kept,
        interrupted=interrupted,
    )


def _finish(partial: Path, place: Path, out: Path, kind: ResultKind) -> None:
    try:
        _sync(partial)
        why = _put_in_place(partial, place, kind)
    except OSError as error:
        why = f"cannot be replaced ({error.strerror})"
    if why:
        kept = _path_for_people(_keep(partial, place), out)
        raise Kept(f"{out}: {why}; the new results are whole and kept in {kept}", kept)


def _check_place(place: Path, out: Path, kind: ResultKind) -> None:
    if not os.path.lexists(place):
        return
    if not place.is_dir():
        raise BadInput(f"{out}: is a file: name a directory with --out")
    why = why_not_replaceable(place, kind)
    if why:
        raise BadInput(f"{out}: {why}: choose an empty or new directory with --out")


def _put_in_place(partial: Path, place: Path, kind: ResultKind) -> str:
    """Make `partial` the results directory; say why not where that would cost something else."""
    if not os.path.lexists(place):
        partial.rename(place)
        return ""
    why = why_not_replaceable(place, kind) if place.is_dir() else "is a file by now"
    if why:
        return why
    aside = _new_beside(place, "old")
    put_in_place_of(partial, place, aside)
    why = why_not_replaceable(aside, kind)  # again: now nobody finds it any more
    if why:
        put_in_place_of(aside, place, partial)
        return why
    if not remove_result(aside, kind):
        left = _keep(aside, place)
        _print_line(f"{left}: what was written into {place} just now")
    return ""


def _keep(partial: Path, place: Path, *, try_first: Path | None = None) -> Path:
    """Move a finished result to a name that is free, if that can be done; return where it is."""
    numbered = (place.with_name(f"{place.name}-{number}") for number in count(2))
    for free in (try_first, *(next(numbered) for _ in range(1000))):
        if free is None or os.path.lexists(free):
            continue
        with suppress(OSError):
            return partial.rename(free)
    return partial


def _remove_leftovers(place: Path, out: Path, kind: ResultKind) -> None:
    """Put right what killed processes have left; the lock says that none of them is alive."""
    for item in sorted(place.parent.glob(f".{escape(place.name)}.*-????????")):
        purpose = item.name.removeprefix(f".{place.name}.").rpartition("-")[0]
        if item.is_symlink() or not item.is_dir():
            continue
        if purpose == "old" and not place.exists() and holds_summary(item):
            item.rename(place)  # killed between two renames
        elif purpose in ("partial", "live") and holds_summary(item):
            kept = _path_for_people(_keep(item, place), out)
            _print_line(f"{kept}: finished results of a run into {out} that was killed")
        elif purpose == "old" and why_corrections_are_lost(item, _corrections_in(place)):
            kept = _path_for_people(_keep(item, place), out)
            _print_line(
                f"{kept}: what a run into {out} that was killed has replaced, with corrections"
            )
        elif purpose in ("old", "partial"):
            remove_result(item, kind)
        elif purpose == "live":
            _print_line(
                f"{_path_for_people(item, out)}: what is left of a live trial that was killed"
            )


def _corrections_in(place: Path) -> tuple[Correction, ...]:
    """Return the corrections of a result; none where they cannot be read."""
    try:
        return kept_corrections(place)
    except BadInput:
        return ()


def _print_line(said: str) -> None:
    print(f"worm: {printable(said)}", file=sys.stderr)


def _has_frames(partial: Path) -> bool:
    """Tell whether a trial has begun; a table that a full disk has cut counts too."""
    table = partial / "tracks.parquet"
    try:
        return bool(pq.read_metadata(table).num_rows)
    except (OSError, pa.ArrowException):
        return table.is_file() and table.stat().st_size > len(_PARQUET_MAGIC)


def _new_beside(place: Path, purpose: str) -> Path:
    return place.with_name(f".{place.name}.{purpose}-{secrets.token_hex(4)}")


def _sync(directory: Path) -> None:
    """See the files onto the disk, so that a power cut does not leave names without content."""
    for item in (*directory.rglob("*"), directory):
        if item.is_symlink() or not (item.is_file() or item.is_dir()):
            continue
        handle = os.open(item, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _path_for_people(directory: Path, out: Path) -> Path:
    """Return the directory as a person would name it who says `out`."""
    short = out.parent / directory.name
    return short if short.exists() and short.samefile(directory) else directory


def _in_a_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


@contextmanager
def _output_errors_in_a_line(out: Path) -> Iterator[None]:
    try:
        yield
    except InUse:
        raise BadInput(
            f"{out}: another run is writing to it: let it end, or choose another --out"
        ) from None
    except OSError as error:
        raise _cannot_write(out, error) from None


def _is_of_the_disk(error: BaseException, partial: Path) -> TypeGuard[OSError]:
    """Tell whether an error in the block is about writing the results."""
    if not isinstance(error, OSError) or error.errno not in _OF_THE_DISK:
        return False
    return error.filename is None or Path(os.fsdecode(error.filename)).is_relative_to(partial)


def _cannot_write(out: Path, error: OSError) -> BadInput:
    why = error.strerror or _in_a_line(error)
    return BadInput(f"{out}: cannot be written ({why}): make room, or choose another --out")
