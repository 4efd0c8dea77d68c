"""The corrections of a results directory, as several browsers change them one after the other."""

import fcntl
import getpass
import hashlib
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import numpy as np

from worm_monitor.review.trial import ReviewedTrial
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import (
    CORRECTIONS_FILE,
    Correction,
    CorrectionKind,
    kept_corrections,
    why_not_together,
    write_corrections,
)

_CHANGED_BY_ANOTHER = (
    "somebody else has changed the corrections meanwhile: look at the list, then do it again"
)

_NO_REPLAY = (
    "these results were made of a table of tracks, which no replay can correct: exchange head and "
    "tail in the table, and analyse it again"
)
_MADE_ANEW = (
    "these results were made anew since the page was opened, or moved: start worm review again"
)


class CorrectionStore:
    """Reads and changes the file; every change says which state of it it rests on."""

    def __init__(self, trial: ReviewedTrial) -> None:
        self._trial = trial
        self._path = trial.directory / CORRECTIONS_FILE
        self._made = self._made_now()

    def told(self, refused: str = "") -> dict[str, Any]:
        """Return what the page shows: the file's state, its entries, and why nothing was done.

        `damaged` is what is wrong with the file, `never` why these results can have none.
        """
        never = {"never": self._why_never()}
        try:
            version = self._version()
            entries = kept_corrections(self._trial.directory)
        except (BadInput, OSError) as error:
            return never | {
                "version": "", "entries": [], "refused": refused, "damaged": str(error),
            }  # fmt: skip
        told = [asdict(entry) | {"frames": entry.frames_in_words} for entry in entries]
        for entry in told:  # JavaScript rounds such numbers, and the page needs none
            del entry["first_stamp_ns"], entry["last_stamp_ns"]
        return never | {"version": version, "entries": told, "refused": refused, "damaged": ""}

    def change(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        """Add an entry, or remove one, and return what the page shows then.

        Parameters
        ----------
        asked : mapping
            `based_on`, the version that the page shows; `add` with `first`, `last` (frames), `by`
            and `note`, or `remove`, the place of an entry.
        """
        never = self._why_never()
        if never:
            return self.told(never)
        try:
            with self._alone():
                if asked.get("based_on") != self._version():
                    return self.told(_CHANGED_BY_ANOTHER)
                entries = list(kept_corrections(self._trial.directory))
                if "add" in asked:
                    entries.append(self._correction(asked["add"]))
                else:
                    self._remove(entries, asked.get("remove"))
                wrong = why_not_together(entries)
                if wrong:
                    return self.told(wrong)
                write_corrections(self._path, entries)
        except BadInput as error:
            return self.told(f"the correction {error}")
        except OSError as error:
            return self.told(f"{self._path}: cannot be written ({error.strerror})")
        return self.told()

    def _why_never(self) -> str:
        if self._trial.of_table:
            return _NO_REPLAY
        return "" if self._made_now() == self._made else _MADE_ANEW

    def _made_now(self) -> tuple[int, int]:
        """Return what changes when another run replaces the results."""
        try:
            found = (self._trial.directory / "summary.json").stat()
        except OSError:
            return 0, 0
        return found.st_ino, found.st_mtime_ns

    def _correction(self, asked: Any) -> Correction:
        if not isinstance(asked, Mapping):
            raise BadInput("is no JSON object")
        first, last = self._row(asked.get("first")), self._row(asked.get("last"))
        stamps, frames = self._trial.stamps_ns, self._trial.frames
        return Correction(
            what=CorrectionKind.SWAP_HEAD,
            first_frame=int(frames[first]),
            first_stamp_ns=int(stamps[first]),
            last_frame=int(frames[last]),
            last_stamp_ns=int(stamps[last]),
            by=str(asked.get("by", "")).strip(),
            at=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
            note=str(asked.get("note", "")).strip(),
        )

    def _row(self, frame: Any) -> int:
        number = frame if isinstance(frame, int) else -1
        rows = np.flatnonzero(self._trial.frames == number)
        if not len(rows):
            raise BadInput(f"names frame {frame!r}, which this trial does not have")
        return int(rows[0])

    @staticmethod
    def _remove(entries: list[Correction], place: Any) -> None:
        if not isinstance(place, int) or not 0 <= place < len(entries):
            raise BadInput("is not there")
        if entries[place].what is not CorrectionKind.SWAP_HEAD:
            raise BadInput("was made while the trial ran, and stays")
        del entries[place]

    def _version(self) -> str:
        try:
            return hashlib.sha256(self._path.read_bytes()).hexdigest()
        except FileNotFoundError:
            return "none"

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Keep another `worm review` of these results from changing the file in between."""
        handle = os.open(self._path.parent, os.O_RDONLY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            yield
        finally:
            os.close(handle)


def who_am_i() -> str:
    """Return the login name; empty where there is none."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return ""
