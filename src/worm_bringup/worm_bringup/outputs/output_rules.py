"""Which places a command may write to: apart from each other, and from what it reads."""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from worm_msgs_py.errors import BadInput

_Identity = str | tuple[int, int]


def resolve_out(out: Path) -> Path:
    """Return the directory that `out` means, symbolic links followed, whether it is there or not.

    Raises
    ------
    BadInput
        Where its links lead nowhere, or it is no place for results: the root, the home directory,
        the current one, a directory that holds one of these, or a mount point.
    """
    place = _resolved(out)
    dear = ((Path.cwd, "the directory you are in"), (Path.home, "your home directory"))
    for find, said in dear:
        with suppress(RuntimeError, FileNotFoundError):  # no home; the directory is gone
            if _resolved(find()).is_relative_to(place):
                raise BadInput(f"{out}: is {said}, or holds it: name a new directory with --out")
    if place.is_mount():
        raise BadInput(
            f"{out}: is a mount point, which cannot be replaced: name a directory in it with --out"
        )
    return place


def check_apart(outputs: Mapping[str, Path | None], inputs: Mapping[str, Path]) -> None:
    """Refuse outputs that are, hold, or lie in one another or an input.

    Symbolic links are followed, those inside of an input too; a directory that is mounted in
    several places is known by its inode.

    Parameters
    ----------
    outputs : mapping of option to path or None
        Such as ``--out``; None is an option that was not given.
    inputs : mapping of name to path
        Such as ``the bag``; files and directories.

    Raises
    ------
    BadInput
        One line that names both.
    """
    given = [(option, path) for option, path in outputs.items() if path is not None]
    pairs = [(one, other) for k, one in enumerate(given) for other in given[k + 1 :]]
    pairs += [(one, (name, path)) for one in given for name, path in inputs.items()]
    for (option, path), (name, other) in pairs:
        for part in _with_linked(other) if (name, other) not in given else (other,):
            relation = _relation(path, part)
            if relation:
                raise BadInput(
                    f"{option} {path}: {relation} {name} ({other}): choose another {option}, "
                    "apart from it"
                )


def _relation(path: Path, other: Path) -> str:
    """Say how a path lies to another one; empty where they are apart."""
    own, others = _ancestry(path), _ancestry(other)
    inside, around = own[0] & set().union(*others), others[0] & set().union(*own)
    if inside and around:
        return "is the same as"
    if inside:
        return "holds"
    return "lies in" if around else ""


def _ancestry(path: Path) -> list[set[_Identity]]:
    """Return what identifies a place, then what identifies each directory around it."""
    place = _resolved(path)
    return [set(_identities(each)) for each in (place, *place.parents)]


def _identities(place: Path) -> Iterator[_Identity]:
    yield str(place)
    with suppress(OSError):
        found = place.stat()
        yield found.st_dev, found.st_ino


def _with_linked(given: Path) -> Iterable[Path]:
    """Return an input and what it links to."""
    yield given
    for folder, folders, files in os.walk(given):  # of a file: nothing
        here = (Path(folder) / name for name in (*folders, *files))
        yield from (item for item in here if item.is_symlink())


def _resolved(path: Path) -> Path:
    try:
        place = path.resolve()
        looping = place.is_symlink()
    except RuntimeError:
        looping = True
    except OSError as error:
        raise BadInput(f"{path}: cannot be used ({error.strerror}): choose another") from None
    if looping:
        raise BadInput(f"{path}: its symbolic links lead round in a circle: name another path")
    return place
