"""Tells a directory that holds a result of ours, and nothing else, from any other."""

import json
import os
import re
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import CORRECTIONS_FILE, Correction, kept_corrections
from worm_msgs_py.files.frame_pictures import FRAME_PICTURE

SOFTWARE = "worm-escape"


@dataclass(frozen=True, slots=True)
class ResultKind:
    """What a command writes into its directory.

    Attributes
    ----------
    files : str
        Regular expression of the files' paths in it.
    folders : frozenset of str
        The folders in it.
    corrections : tuple of Correction
        Those that it has: an earlier result with others is not replaced.
    """

    files: str
    folders: frozenset[str]
    corrections: tuple[Correction, ...] = ()


_CORRECTIONS = re.escape(CORRECTIONS_FILE)
_UNFINISHED = (
    rf"|\.(summary\.json|report\.html|{_CORRECTIONS}|{FRAME_PICTURE})\.[0-9a-f]{{8}}\.part"
)
_FIGURES = r"|figures/fig-[\w-]+\.(svg|pdf)"
TRIAL = ResultKind(
    rf"(tracks|contacts|passages|sums)\.parquet|summary\.json|report\.html|{FRAME_PICTURE}"
    rf"|{_CORRECTIONS}"
    r"|bag/(metadata\.yaml|bag\.mcap)" + _FIGURES + _UNFINISHED,
    frozenset({"bag", "figures"}),
)
"""Of `worm replay`, `worm live` and `worm analyse`."""
POOLED = ResultKind(
    r"report\.html|summary\.json|tables/(fig-[\w-]+|numbers|trials)\.csv" + _FIGURES + _UNFINISHED,
    frozenset({"figures", "tables"}),
)
"""Of `worm report`."""


def why_not_replaceable(directory: Path, kind: ResultKind) -> str:
    """Say why a directory may not be replaced; empty where it is empty or a result of ours."""
    foreign = next(foreign_items(directory, kind), None)
    if foreign is not None:
        return f"holds '{foreign}', which is not a result of ours"
    if any(directory.iterdir()) and not holds_summary(directory):
        return "holds no valid summary.json, so it is not a result of ours"
    return why_corrections_are_lost(directory, kind.corrections)


def why_corrections_are_lost(directory: Path, corrections: Collection[Correction]) -> str:
    """Say which corrections a directory holds beside these; empty where it holds no other."""
    try:
        lost = [told for told in kept_corrections(directory) if told not in corrections]
    except BadInput:
        return f"holds a {CORRECTIONS_FILE} that cannot be read, which a person may have written"
    if not lost:
        return ""
    return (
        f"holds corrections by hand that would be lost ({lost[0].frames_in_words}, by "
        f"{lost[0].by}), and which `worm replay --corrections` of this directory takes over"
    )


def foreign_items(directory: Path, kind: ResultKind) -> Iterator[str]:
    """Give the paths in a directory that a result of this kind does not hold."""
    return (path for path, is_ours in _items(directory, kind) if not is_ours)


def holds_summary(directory: Path) -> bool:
    """Tell whether a directory holds a summary of ours, which is written when all else is whole."""
    path = directory / "summary.json"
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
        return not path.is_symlink() and summary["provenance"]["software"] == SOFTWARE
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False


def remove_result(directory: Path, kind: ResultKind) -> bool:
    """Remove what is ours, and the directory where nothing else is in it; say whether it is gone.

    The summary goes first: half a result is never taken for a whole one.
    """
    ours = [path for path, is_ours in _items(directory, kind) if is_ours]
    files = [path for path in ours if path not in kind.folders]
    for path in sorted(files, key=lambda path: path != "summary.json"):
        (directory / path).unlink(missing_ok=True)
    for path in (*(path for path in ours if path in kind.folders), ""):
        with suppress(OSError):  # something else is in it
            (directory / path).rmdir()
    return not directory.exists()


def _items(directory: Path, kind: ResultKind, folder: str = "") -> Iterator[tuple[str, bool]]:
    """Give each path in a directory, and whether it is of the kind; links never are."""
    with os.scandir(directory / folder) as found:
        items = sorted(found, key=lambda item: item.name)
    for item in items:
        path = f"{folder}/{item.name}" if folder else item.name
        if path in kind.folders and item.is_dir(follow_symlinks=False):
            yield path, True
            yield from _items(directory, kind, path)
        else:
            is_file = item.is_file(follow_symlinks=False)
            yield path, is_file and re.fullmatch(kind.files, path) is not None
