"""A results directory that is there whole or not at all."""

import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from worm_msgs_py.errors import BadInput

_OURS = {
    "tracks.parquet",
    "contacts.parquet",
    "passages.parquet",
    "summary.json",
    "report.html",
    "bag",
}


@contextmanager
def results_directory(out: Path, ours: Collection[str] = _OURS) -> Iterator[Path]:
    """Give a directory beside `out` to write into; it becomes `out` where the block succeeds.

    An earlier result in `out` is replaced, and only then; anything else there is left alone.

    Parameters
    ----------
    out : Path
        The directory to make.
    ours : collection of str
        Names that an earlier result may hold.

    Raises
    ------
    BadInput
        Where `out` holds something that is not an earlier result, or cannot be written.
    """
    _refuse_foreign(out, ours)
    partial = out.with_name(f".{out.name}.partial")
    try:
        if partial.exists():
            shutil.rmtree(partial)
        partial.mkdir(parents=True)
    except OSError as error:
        raise BadInput(
            f"{out}: cannot be written ({error.strerror}): choose another --out"
        ) from error
    try:
        yield partial
        if out.exists():
            shutil.rmtree(out)
        partial.rename(out)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _refuse_foreign(out: Path, ours: Collection[str]) -> None:
    if not out.exists():
        return
    if not out.is_dir():
        raise BadInput(f"{out}: is a file: name a directory with --out")
    foreign = sorted(item.name for item in out.iterdir() if item.name not in ours)
    if foreign:
        raise BadInput(
            f"{out}: holds {foreign[0]!r}, which is not a result of ours: "
            "choose an empty or new directory with --out"
        )
