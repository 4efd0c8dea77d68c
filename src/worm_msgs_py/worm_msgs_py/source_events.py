"""What happened to the pictures before they reached the tracker: outages, damage, an early end."""

from dataclasses import dataclass
from enum import StrEnum


class SourceEventKind(StrEnum):
    """What happened."""

    OUTAGE = "outage"
    """The camera gave no picture for some time, and came back."""
    LOST = "lost"
    """Pictures of the recording cannot be read; they are not among the frames."""
    BAD_MESSAGE = "bad_message"
    """A message cannot be read; it is a frame with the status ``bad_image``."""
    RECORD_STOPPED = "record_stopped"
    """Pictures are no longer recorded (a full disk); tracking goes on."""
    ENDED_EARLY = "ended_early"
    """The source ended before its time: the trial is not whole."""


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
    """

    kind: SourceEventKind
    frame: int
    stamp_ns: int
    why: str
    duration_s: float = 0.0
    count: int = 0
