"""`corrections.json`: where people have set right which end of the worm is the head."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import datetime, timedelta
from enum import StrEnum
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any

from worm_msgs_py.contract.source_events import SourceEvent
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.json_files import read_json
from worm_msgs_py.files.whole_files import whole_file
from worm_msgs_py.text import printable
from worm_msgs_py.units import NS_PER_S

CORRECTIONS_FILE = "corrections.json"
"""What the file is called in a results directory."""
CORRECTIONS_FORMAT = 1
LONGEST_CORRECTION_TEXT = 400
"""Signs that a name or a note may have."""
_MOST_BYTES = 16 << 20
_MOST_LISTED = 5
_STAMPS = 2**63


class CorrectionKind(StrEnum):
    """What a person said."""

    SWAP_HEAD = "swap_head"
    """In these frames, and in no others, the head is the end that was told to be the tail."""
    SWAP_REQUEST = "swap_request"
    """Once the first of these frames was taken, `~/swap_head` was called: for the frames that the
    tracker then held back and for all that came, where it did not change its mind any more."""


@dataclass(frozen=True, slots=True)
class Correction:
    """One thing that a person has set right.

    Attributes
    ----------
    what : CorrectionKind
    first_frame, first_stamp_ns : int
        The first frame that it applies to, or after which it was asked for.
    last_frame, last_stamp_ns : int or None
        The last frame that it applies to; None: to the end, as a request always is.
    by : str
        Who, or what, has corrected.
    at : str
        When: ISO 8601, UTC.
    note : str
        Anything else.

    Raises
    ------
    BadInput
        A value is not of this form: what is wrong, going on from "the correction".
    """

    what: CorrectionKind
    first_frame: int
    first_stamp_ns: int
    last_frame: int | None
    last_stamp_ns: int | None
    by: str
    at: str
    note: str = ""

    def __post_init__(self) -> None:
        if self.what not in tuple(CorrectionKind):
            raise BadInput(f"says {self.what!r}: give {' or '.join(CorrectionKind)}")
        object.__setattr__(self, "what", CorrectionKind(self.what))
        self._check_frames()
        for name in ("by", "note"):
            text = getattr(self, name)
            if not isinstance(text, str) or len(text) > LONGEST_CORRECTION_TEXT:
                most = LONGEST_CORRECTION_TEXT
                raise BadInput(f"has a {name} that is no text of {most} signs at most")
            if text != printable(text):
                raise BadInput(f"has a {name} with signs that cannot be printed")
        if not self.by.strip():
            raise BadInput("does not say who made it: give 'by'")
        if not _is_utc(self.at):
            raise BadInput(f"has 'at' {self.at!r}: give a time as 2026-03-21T09:30:00Z")

    def _check_frames(self) -> None:
        for name in ("first_frame", "first_stamp_ns", "last_frame", "last_stamp_ns"):
            value = getattr(self, name)
            if value is None and name.startswith("last"):
                continue
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _STAMPS:
                raise BadInput(f"has {name} {value!r}: give a whole number, 0 or more")
        if (self.last_frame is None) != (self.last_stamp_ns is None):
            raise BadInput("has one of last_frame and last_stamp_ns: give both, or null for both")
        if self.last_frame is not None and self.last_frame < self.first_frame:
            raise BadInput(f"ends with frame {self.last_frame}, before its first")
        if self.what == CorrectionKind.SWAP_REQUEST and self.last_frame is not None:
            raise BadInput("is a request with a last frame: it holds to the end")

    @property
    def frames_in_words(self) -> str:
        """The frames that it applies to, for people."""
        if self.what is CorrectionKind.SWAP_REQUEST:
            return f"after frame {self.first_frame}"
        if self.last_frame is None:
            return f"from frame {self.first_frame} to the end"
        return f"from frame {self.first_frame} to {self.last_frame}"

    def swaps(self, frame: int) -> bool:
        """Tell whether head and tail of a frame are exchanged as it leaves the tracker."""
        last = inf if self.last_frame is None else self.last_frame
        return self.what is CorrectionKind.SWAP_HEAD and self.first_frame <= frame <= last


def why_not_together(corrections: Iterable[Correction]) -> str:
    """Say which corrections exchange the ends of one frame twice; empty where none do."""
    swaps = [told for told in corrections if told.what is CorrectionKind.SWAP_HEAD]
    for one, other in pairwise(sorted(swaps, key=lambda told: told.first_frame)):
        if one.swaps(other.first_frame):
            return (
                f"head and tail are exchanged twice in frame {other.first_frame} "
                f"({one.frames_in_words}, and {other.frames_in_words}): leave one of them out, or "
                "let one begin after the other's end"
            )
    return ""


def why_not_of(corrections: Iterable[Correction], frame: int, stamp_ns: int) -> str:
    """Say which correction is of another recording than this frame; empty where none is."""
    for told in corrections:
        places = ((told.first_frame, told.first_stamp_ns), (told.last_frame, told.last_stamp_ns))
        for its_frame, its_ns in places:
            if its_frame == frame and its_ns is not None and its_ns != stamp_ns:
                return (
                    f"the correction {told.frames_in_words} is of another recording: its frame "
                    f"{frame} was taken at {its_ns / NS_PER_S:.6f} s, this one's at "
                    f"{stamp_ns / NS_PER_S:.6f} s: give the corrections of this one, played from "
                    "the same start"
                )
    return ""


def why_beyond(corrections: Iterable[Correction], frames: int) -> str:
    """Say which correction is of frames that a recording does not have; empty where none is."""
    for told in corrections:
        if max(told.first_frame, told.last_frame or 0) >= frames:
            return (
                f"the correction {told.frames_in_words} is of another recording: this one has "
                f"{frames} frames"
            )
    return ""


def read_corrections(path: Path) -> tuple[Correction, ...]:
    """Return the corrections of a file, or of a results directory, in their order in it.

    Raises
    ------
    BadInput
        It is not there, is no file of corrections, or two corrections exclude each other.
    """
    file = path / CORRECTIONS_FILE if path.is_dir() else path
    try:
        found = read_json(file, _MOST_BYTES)
    except FileNotFoundError:
        raise BadInput(
            f"{file}: is not there: give a corrections.json, or results that hold one"
        ) from None
    except (OSError, ValueError) as error:
        raise _no_corrections(file, f"cannot be read ({error})") from None
    try:
        return _corrections_of(found)
    except BadInput as error:
        raise _no_corrections(file, str(error)) from None


def kept_corrections(directory: Path) -> tuple[Correction, ...]:
    """Return the corrections that a results directory holds; none where it has no file of them.

    Raises
    ------
    BadInput
        As `read_corrections`.
    """
    there = (directory / CORRECTIONS_FILE).exists()
    return read_corrections(directory) if there else ()


def write_corrections(path: Path, corrections: Sequence[Correction]) -> None:
    """Write a file of corrections, whole or not at all, in the place of an earlier one.

    Raises
    ------
    BadInput
        Two corrections exclude each other, or what is at `path` is no file of corrections.
    OSError
        It cannot be written.
    """
    wrong = why_not_together(corrections)
    if wrong:
        raise BadInput(f"{path}: {wrong}")
    if path.exists():
        read_corrections(path)
    with whole_file(path) as unfinished:
        unfinished.write_text(corrections_to_json(corrections), encoding="utf-8")


def corrections_to_json(corrections: Iterable[Correction]) -> str:
    """Return the text of a file of corrections; it depends on them alone."""
    document = {
        "format": CORRECTIONS_FORMAT,
        "corrections": [asdict(correction) for correction in corrections],
    }
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def corrections_from_json(text: str) -> tuple[Correction, ...]:
    """Return the corrections that a text holds, as of a file; none of an empty text.

    Raises
    ------
    BadInput
        It is no such text: what is wrong.
    """
    if not text:
        return ()
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        raise BadInput("is no JSON") from None
    return _corrections_of(found)


def _corrections_of(found: Any) -> tuple[Correction, ...]:
    if not isinstance(found, Mapping) or not isinstance(found.get("corrections"), list):
        raise BadInput("has no list 'corrections'")
    if found.get("format") != CORRECTIONS_FORMAT:
        raise BadInput(f"has the format {found.get('format')!r}, not {CORRECTIONS_FORMAT}")
    return corrections_of(found["corrections"])


def corrections_of(entries: Iterable[Any]) -> tuple[Correction, ...]:
    """Return corrections from their entries in a JSON document.

    Raises
    ------
    BadInput
        An entry is none, or two exclude each other: what is wrong.
    """
    corrections = tuple(_correction(number, entry) for number, entry in enumerate(entries, 1))
    wrong = why_not_together(corrections)
    if wrong:
        raise BadInput(wrong)
    return corrections


def requested(event: SourceEvent) -> Correction:
    """Return what an operator asked for while a trial ran, so that a replay can do it again."""
    return Correction(
        CorrectionKind.SWAP_REQUEST,
        first_frame=event.frame,
        first_stamp_ns=event.stamp_ns,
        last_frame=None,
        last_stamp_ns=None,
        by="~/swap_head",
        at=event.at,
        note=event.why,
    )


def corrections_in_words(corrections: Iterable[Correction], frames_swapped: int) -> list[str]:
    """Return a line for each kind of correction that there is, for people."""
    said = {
        CorrectionKind.SWAP_HEAD: f"head and tail were exchanged by hand in {frames_swapped} "
        f"frame{'' if frames_swapped == 1 else 's'}",
        CorrectionKind.SWAP_REQUEST: "head and tail were exchanged on request",
    }
    told = list(corrections)
    return [
        f"{line}: " + _listed([f"{one.frames_in_words} (by {one.by})" for one in those])
        for kind, line in said.items()
        if (those := [one for one in told if one.what is kind])
    ]


def _listed(items: Sequence[str]) -> str:
    more = len(items) - _MOST_LISTED
    rest = [f"and {more} more, in {CORRECTIONS_FILE}"] if more > 0 else []
    return "; ".join([*items[:_MOST_LISTED], *rest])


def _correction(number: int, entry: Any) -> Correction:
    names = [item.name for item in fields(Correction)]
    if not isinstance(entry, Mapping):
        raise BadInput(f"correction {number} is no JSON object")
    unknown = sorted(set(entry) - set(names))
    missing = [name for name in names if name not in entry and name != "note"]
    if unknown or missing:
        wrong = f"has {unknown[0]!r}, which no" if unknown else f"lacks {missing[0]!r}, which every"
        raise BadInput(f"correction {number} {wrong} correction has")
    try:
        return Correction(**entry)
    except BadInput as error:
        raise BadInput(f"correction {number} {error}") from None


def _no_corrections(file: Path, why: str) -> BadInput:
    return BadInput(f"{file}: is no file of corrections: {why}: put it right, or move it elsewhere")


def _is_utc(text: Any) -> bool:
    """Tell whether a text is a time, with the offset of UTC."""
    try:
        return datetime.fromisoformat(text).utcoffset() == timedelta(0)
    except (TypeError, ValueError):
        return False


def _no_corrections_text(text: str) -> str:
    """Return what is wrong with a parameter that holds corrections."""
    try:
        corrections_from_json(text)
    except BadInput as error:
        return str(error)
    return ""


CORRECTIONS = Declaration(
    "corrections",
    "",
    "The text of a corrections.json: where people have set right which end is the head.",
    check=_no_corrections_text,
)
