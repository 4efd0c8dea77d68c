"""The folder beside OUT that a replay which was stopped goes on from.

```
.OUT.checkpoint/        mode 0700
  manifest.json         what it belongs to, and the names and hashes of the files below
  state-000007.pickle   the state of every node but the recorder, at the manifest's frame
  messages-000000.z     what the recorder was sent, in order: compressed, a file a checkpoint
  messages-000001.z
```

A file is written under a name that no manifest holds yet, and reaches the disk before the manifest
that names it takes the place of the last one in a single step. So whenever a run is killed, the
manifest names whole files. The pickles are read only from a folder that is this user's and that
nobody else can write into or read.
"""

import errno
import hashlib
import json
import os
import re
import stat
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from worm_bringup.checkpoints import exact_pickle
from worm_bringup.outputs.output_rules import resolve_out
from worm_msgs_py.errors import BadInput

_MANIFEST = "manifest.json"
_OURS = re.compile(r"manifest\.json|state-\d+\.pickle|messages-\d+\.z|.+\.new")
_FORMAT = 1
_ANEW = "leave out --resume to begin anew"


@dataclass(frozen=True)
class Stored:
    """A file of the folder: its name, and the SHA-256 of its bytes."""

    name: str
    sha256: str


@dataclass(frozen=True)
class Manifest:
    """What a checkpoint is of.

    Attributes
    ----------
    fingerprint : mapping
        All that the results depend on.
    frames : int
        Frames that were sent.
    expected : int or None
        Frames that are to be sent in all, where that is known.
    state : Stored
        The states of the nodes.
    messages : tuple of Stored
        What the recorder was sent.
    """

    fingerprint: Mapping[str, Any]
    frames: int
    expected: int | None
    state: Stored
    messages: tuple[Stored, ...]


class CheckpointFolder:
    """The checkpoint of one results directory.

    Parameters
    ----------
    out : Path
        The results directory that the replay is to make.
    """

    def __init__(self, out: Path):
        out = resolve_out(out)
        self.path = out.with_name(f".{out.name}.checkpoint")

    def manifest(self) -> Manifest | None:
        """Return what the last checkpoint is of; None where there is none.

        Raises
        ------
        BadInput
            The folder is not ours alone, or its manifest cannot be read.
        """
        try:
            text = self._bytes(_MANIFEST)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._damaged(f"{_MANIFEST}: {error.strerror}") from error
        try:
            data = json.loads(text)
            if data.pop("format") != _FORMAT:
                raise self._damaged("it was made by another version of this software")
            messages = tuple(Stored(**item) for item in data.pop("messages"))
            return Manifest(state=Stored(**data.pop("state")), messages=messages, **data)
        except (AttributeError, KeyError, TypeError, json.JSONDecodeError, UnicodeError) as error:
            raise self._damaged("its manifest is not one of ours") from error

    def states(self, manifest: Manifest) -> Any:
        """Return the states of the nodes."""
        return exact_pickle.loads(self._read(manifest.state))

    def messages(self, manifest: Manifest) -> Iterator[Any]:
        """Yield what the recorder was sent, checkpoint by checkpoint."""
        for stored in manifest.messages:
            yield exact_pickle.loads(zlib.decompress(self._read(stored)))

    def save(
        self,
        fingerprint: Mapping[str, Any],
        frames: int,
        expected: int | None,
        states: Any,
        messages: Any,
        before: Sequence[Stored],
    ) -> Manifest:
        """Write a checkpoint; it takes the place of the last one.

        Parameters
        ----------
        messages : picklable
            What the recorder was sent since the files `before` were written.

        Raises
        ------
        OSError
            It could not be written; the last one holds.
        """
        self._make()
        number = 1 + max((_number_in_name(item.name) for item in self.path.iterdir()), default=-1)
        packed = zlib.compress(exact_pickle.dumps(messages), 1)
        manifest = Manifest(
            fingerprint=fingerprint,
            frames=frames,
            expected=expected,
            messages=(*before, self._write(f"messages-{number:06d}.z", packed)),
            state=self._write(f"state-{number:06d}.pickle", exact_pickle.dumps(states)),
        )
        text = json.dumps({"format": _FORMAT, **asdict(manifest)}, indent=1)
        self._write(_MANIFEST, text.encode())
        self._remove_all_but(manifest)
        return manifest

    def tidy(self) -> None:
        """Remove what no checkpoint holds: files that were being written when a run was killed."""
        manifest = self.manifest()
        if manifest is None:
            self.remove()
        else:
            self._remove_all_but(manifest)

    def remove(self) -> None:
        """Remove the checkpoint: the files that are ours, and the folder where it is empty then."""
        if not self.path.exists():
            return
        self._check_ours(self.path.lstat())
        (self.path / _MANIFEST).unlink(missing_ok=True)  # first: the others alone are none
        self._remove_all_but(None)
        with suppress(OSError):
            self.path.rmdir()

    def _make(self) -> None:
        with suppress(FileExistsError):
            self.path.mkdir(mode=0o700)
        self._check_ours(self.path.lstat())

    def _check_ours(self, about: os.stat_result) -> None:
        if (
            not stat.S_ISDIR(about.st_mode)
            or about.st_uid != os.geteuid()
            or stat.S_IMODE(about.st_mode) & 0o077
        ):
            raise self._of_others()

    def _write(self, name: str, data: bytes) -> Stored:
        """Write a file whole or not at all, and wait until the disk has it."""
        new = self.path / f"{name}.new"
        with new.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        new.replace(self.path / name)
        folder = os.open(self.path, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
        return Stored(name, hashlib.sha256(data).hexdigest())

    def _read(self, stored: Stored) -> bytes:
        try:
            data = self._bytes(stored.name)
        except OSError as error:
            raise self._damaged(f"{stored.name}: {error.strerror}") from error
        if hashlib.sha256(data).hexdigest() != stored.sha256:
            raise self._damaged(f"{stored.name} is not as it was written")
        return data

    def _bytes(self, name: str) -> bytes:
        """Read a file in the very folder that was found to be ours, whatever is renamed meanwhile.

        Raises
        ------
        BadInput
            The folder is not ours alone.
        OSError
            The folder or the file is not there, or cannot be read.
        """
        try:
            folder = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except OSError as error:
            if error.errno in (errno.ENOTDIR, errno.ELOOP):
                raise self._of_others() from None
            raise
        try:
            self._check_ours(os.fstat(folder))
            handle = os.open(name, os.O_RDONLY | os.O_NOFOLLOW, dir_fd=folder)
        finally:
            os.close(folder)
        with os.fdopen(handle, "rb") as stream:
            return stream.read()

    def _remove_all_but(self, manifest: Manifest | None) -> None:
        kept = set()
        if manifest is not None:
            kept = {_MANIFEST, manifest.state.name, *(item.name for item in manifest.messages)}
        for item in self.path.iterdir():
            if item.name not in kept and _OURS.fullmatch(item.name):
                item.unlink(missing_ok=True)

    def _of_others(self) -> BadInput:
        return BadInput(
            f"{self.path}: is not a folder of yours alone, as a checkpoint must be: move it away, "
            "or choose another --out"
        )

    def _damaged(self, why: str) -> BadInput:
        return BadInput(f"{self.path}: this checkpoint cannot be used ({why}): {_ANEW}")


def _number_in_name(name: str) -> int:
    found = re.search(r"-(\d+)\.", name)
    return int(found.group(1)) if found else -1
