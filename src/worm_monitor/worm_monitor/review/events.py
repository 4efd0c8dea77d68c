"""What happened in a trial, each with the frames that it took: the list that a person goes by."""

import re
from typing import Any

import numpy as np

from worm_analysis.results import Results
from worm_analysis.results.contacts import read_episodes
from worm_analysis.results.passages import read_passages
from worm_monitor.event_words import event_in_words
from worm_msgs_py import Attempt, Episode, EpisodeKind, SourceEvent, SourceEventKind, Visit
from worm_msgs_py.units import NS_PER_S

_NOTES = "recorder: notes changed from "
_NOTE = re.compile(r""".*(?:\\n| to ['"])[\d.]+ s, frame (?P<frame>\d+): (?P<text>.*)['"]\Z""")
"""The last line of the notes, where the monitor's page wrote it: with the moment that it is on."""


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
