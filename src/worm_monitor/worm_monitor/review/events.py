"""What happened in a trial and what is doubtful in it, with the frames: what a person goes by."""

import re
from typing import Any

import numpy as np

from worm_analysis.results import Results
from worm_analysis.results.contacts import read_episodes
from worm_analysis.results.doubtful_stretches import (
    Doubt,
    DoubtfulStretch,
    doubtful_stretches,
)
from worm_analysis.results.passages import read_passages
from worm_monitor.event_words import event_in_words
from worm_msgs_py import Attempt, Episode, EpisodeKind, SourceEvent, SourceEventKind, Visit
from worm_msgs_py.units import NS_PER_S

_NOTES = "recorder: notes changed from "
_NOTE = re.compile(r""".*(?:\\n| to ['"])[\d.]+ s, frame (?P<frame>\d+): (?P<text>.*)['"]\Z""")
"""The last line of the notes, where the monitor's page wrote it: with the moment that it is on."""

_DOUBTS = {
    Doubt.EXCHANGED: "head and tail change places",
    Doubt.UNSURE_HEAD: "not sure which end is the head",
    Doubt.FOLDED: "folded",
    Doubt.LOST: "head and tail not told",
}


def reviewed_events(results: Results) -> list[dict[str, Any]]:
    """Return contacts, visits, attempts, escapes, notes and what happened to the pictures.

    In the order of time, each with `row` and `last` (rows of the tracks), `kind` and `text`.
    """
    stamps = results.tracks["stamp_ns"]
    of_analysis: list[Episode | Visit | Attempt] = [
        *(e for e in read_episodes(results.contacts) if e.kind is EpisodeKind.CONTACT),
        *read_passages(results.passages),
    ]
    told = []
    for event in of_analysis:
        kind, text = event_in_words(event)
        told.append((event.start_ns, event.end_ns, kind, text))
    told += (_of_source(event, results) for event in results.source_events)
    last_row = len(stamps) - 1
    return [
        {
            "row": min(int(np.searchsorted(stamps, start_ns)), last_row),
            "last": max(0, int(np.searchsorted(stamps, end_ns, side="right")) - 1),
            "kind": kind,
            "text": text,
        }
        for start_ns, end_ns, kind, text in sorted(told, key=lambda item: item[0])
    ]


def reviewed_doubts(results: Results) -> list[dict[str, Any]]:
    """Return where a person should look, the worst first.

    Each has `row` and `last`, `text`, whether it `turns` (head and tail change places in it), and
    what to exchange if it is wrong, `from` and `to`: where ends change places the frames after it,
    as far as they do so again.
    """
    stretches = doubtful_stretches(results.tracks)
    turns = sorted(s.first_stamp_ns for s in stretches if s.why is Doubt.EXCHANGED)
    stamps = results.tracks["stamp_ns"]
    told = []
    for stretch in stretches:
        row, last = np.searchsorted(stamps, (stretch.first_stamp_ns, stretch.last_stamp_ns))
        begin, end = int(row), int(last)
        if stretch.why is Doubt.EXCHANGED:
            again = next((ns for ns in turns if ns >= stretch.last_stamp_ns), None)
            begin, end = int(last), len(stamps) - 1
            end = end if again is None else int(np.searchsorted(stamps, again))
        told.append(
            {
                "row": int(row),
                "last": int(last),
                "turns": stretch.why is Doubt.EXCHANGED,
                "from": begin,
                "to": end,
                "text": _stretch_in_words(stretch),
            }
        )
    return told


def _stretch_in_words(stretch: DoubtfulStretch) -> str:
    text = _DOUBTS[stretch.why]
    if stretch.why is Doubt.UNSURE_HEAD:
        text += f" ({stretch.least_certainty:.2f})"
    return text if stretch.why is Doubt.EXCHANGED else f"{text}, {stretch.duration_s:.1f} s"


def _of_source(event: SourceEvent, results: Results) -> tuple[int, int, str, str]:
    end_ns = event.stamp_ns + round(event.duration_s * NS_PER_S)
    if event.kind is not SourceEventKind.PARAMETER_CHANGED or not event.why.startswith(_NOTES):
        return event.stamp_ns, end_ns, "source", f"{event.kind.replace('_', ' ')}: {event.why}"
    found = _NOTE.match(event.why)
    frame = int(found["frame"]) if found else -1
    rows = np.flatnonzero(results.tracks["frame"] == frame)
    if found is None or not len(rows):
        return event.stamp_ns, end_ns, "note", event.why.removeprefix("recorder: ")
    stamp_ns = int(results.tracks["stamp_ns"][rows[0]])
    return stamp_ns, stamp_ns, "note", found["text"]
