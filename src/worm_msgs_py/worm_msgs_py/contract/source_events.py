"""What happened to a trial's pictures: outages, damage, an early end, why they gave no poses."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class SourceEventKind(StrEnum):
    """What happened."""

    NOT_ACCEPTED = "not_accepted"
    """The camera did not take a setting that was asked for, and films otherwise."""
    OUTAGE = "outage"
    """The camera gave no picture for some time, and came back."""
    LOST = "lost"
    """Pictures of the recording cannot be read; they are not among the frames."""
    LOST_ON_THE_WAY = "lost_on_the_way"
    """Pictures that a camera's driver sent and that never came; they are not among the frames."""
    MISCOUNTED = "miscounted"
    """The recording's index counts another number of pictures than there are; all are frames."""
    MISSING_ROWS = "missing_rows"
    """A table of tracks skips frames, by its stamps; they are not among the frames."""
    BAD_MESSAGE = "bad_message"
    """A message cannot be read; it is a frame with the status ``bad_image``."""
    RECORD_STOPPED = "record_stopped"
    """Pictures are no longer recorded (a full disk); tracking goes on."""
    ENDED_EARLY = "ended_early"
    """The source ended before its time: the trial is not whole."""
    WHAT_TO_TRY = "what_to_try"
    """Most frames gave no pose for one reason, or poses of what is no worm: what to do about it."""
    PARAMETER_CHANGED = "parameter_changed"
    """A parameter of a node was changed while the trial ran; it holds from this frame on."""
    HEAD_SWAPPED = "head_swapped"
    """An operator had head and tail exchanged, after this frame was taken."""


@dataclass(frozen=True, slots=True)
class SourceEvent:
    """One thing that happened to a source of pictures.

    Attributes
    ----------
    kind : SourceEventKind
        What happened.
    frame : int
        Number of the frame that it concerns; otherwise of the next one that is sent.
    stamp_ns : int
        When it happened, in the time of the frames: an outage begins at the last frame before it.
    duration_s : float
        How long it lasted; 0 where that means nothing.
    count : int
        How many messages it concerns, as far as that is known; 0 where it means nothing.
    why : str
        One line for people.
    at : str
        When an operator asked for it: ISO 8601, UTC; empty of what nobody asked for.
    """

    kind: SourceEventKind
    frame: int
    stamp_ns: int
    why: str
    duration_s: float = 0.0
    count: int = 0
    at: str = ""


def parameter_changed(
    node: str, name: str, before: Any, value: Any, frame: int, stamp_ns: int
) -> SourceEvent:
    """Return the event that a parameter has another value from a frame on."""
    why = f"{node}: {name} changed from {before!r} to {value!r}"
    return SourceEvent(SourceEventKind.PARAMETER_CHANGED, frame, stamp_ns, why)


def read_source_events(entries: Iterable[Mapping[str, Any]]) -> tuple[SourceEvent, ...]:
    """Return the events of a `summary.json`; KeyError, TypeError or ValueError where one is bad."""
    return tuple(
        SourceEvent(
            SourceEventKind(entry["kind"]),
            int(entry["frame"]),
            int(entry["stamp_ns"]),
            str(entry["why"]),
            float(entry["duration_s"]),
            int(entry["count"]),
        )
        for entry in entries
    )


def in_words(events: Iterable[SourceEvent]) -> list[str]:
    """Return one line for each kind of event that occurs, for people."""
    by_kind: dict[SourceEventKind, list[SourceEvent]] = {}
    for event in events:
        by_kind.setdefault(event.kind, []).append(event)
    return [_kind_in_words(kind, by_kind[kind]) for kind in SourceEventKind if kind in by_kind]


def _kind_in_words(kind: SourceEventKind, events: list[SourceEvent]) -> str:
    count = sum(event.count for event in events)
    first = events[0].why + (" (and more)" if len(events) > 1 else "")
    if kind is SourceEventKind.OUTAGE:
        seconds = [event.duration_s for event in events]
        longest = f", the longest {max(seconds):.1f} s" if len(events) > 1 else ""
        return (
            f"{len(events)} outage{'s' if len(events) > 1 else ''} of the camera, "
            f"{sum(seconds):.1f} s in all{longest}"
        )
    if kind is SourceEventKind.LOST:
        if count == 0:
            return f"the recording is damaged, how much is lost is not known: {first}"
        return f"{count} messages of the recording are lost: {first}"
    if kind is SourceEventKind.LOST_ON_THE_WAY:
        return f"{count} pictures of the camera's driver never came: {first}"
    if kind is SourceEventKind.NOT_ACCEPTED:
        return "the camera films otherwise than asked: " + "; ".join(one.why for one in events)
    if kind in (SourceEventKind.MISCOUNTED, SourceEventKind.MISSING_ROWS):
        return first
    if kind is SourceEventKind.BAD_MESSAGE:
        return f"{count or 'some'} messages cannot be used: {first}"
    if kind is SourceEventKind.RECORD_STOPPED:
        return f"the record is not whole: {first}"
    if kind is SourceEventKind.WHAT_TO_TRY:
        return first
    if kind is SourceEventKind.HEAD_SWAPPED:
        return "; ".join(event.why for event in events)
    if kind is SourceEventKind.PARAMETER_CHANGED:
        return "; ".join(f"from frame {event.frame} on {event.why}" for event in events)
    return f"ended before its time: {first}"
