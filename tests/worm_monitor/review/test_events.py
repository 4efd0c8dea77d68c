"""Events lead to their frames, and a note to the moment that it is on."""

from dataclasses import replace

import pyarrow.parquet as pq
import pytest
from report_trial import record, states
from reviewed_trials import FPS, FRAMES, change_summary, small_trial

from worm_analysis.results import read_results
from worm_monitor.review.events import reviewed_doubts, reviewed_events


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return small_trial(tmp_path_factory.mktemp("reviewed") / "out")


def test_contacts_lead_to_the_frames_that_they_took(results):
    table = pq.read_table(results / "contacts.parquet").to_pylist()
    stamps = pq.read_table(results / "tracks.parquet")["stamp_ns"].to_pylist()
    told = [e for e in reviewed_events(read_results(results)) if e["kind"] == "contact"]
    contacts = [row for row in table if row["kind"] == "contact"]
    assert len(told) == len(contacts) > 3
    for event, row in zip(told, contacts, strict=True):
        assert stamps[event["row"]] == row["start_ns"]
        assert stamps[event["last"]] == row["end_ns"]
        assert f"{row['distance_mm']:.2f} mm" in event["text"]


def test_events_are_in_the_order_of_time(results):
    rows = [event["row"] for event in reviewed_events(read_results(results))]
    assert rows == sorted(rows)


def noted(results, why, frame):
    entry = {
        "kind": "parameter_changed", "frame": frame, "why": why, "duration_s": 0.0, "count": 0,
        "stamp_ns": round(frame * 1e9 / FPS),
    }  # fmt: skip
    change_summary(results, lambda summary: summary.update(source_events=[entry]))
    (event,) = [
        e for e in reviewed_events(read_results(results)) if e["kind"] in ("note", "source")
    ]
    return event


@pytest.mark.parametrize(
    ("notes", "text"),
    [
        (("", "8.25 s, frame 99: it turns"), "it turns"),
        (("a line", "a line\n8.25 s, frame 99: it's out"), "it's out"),
        (("1.00 s, frame 12: a", "1.00 s, frame 12: a\n8.25 s, frame 99: b to 'c"), "b to 'c"),
    ],
)
def test_a_note_leads_to_the_frame_that_it_names(tmp_path, notes, text):
    why = f"recorder: notes changed from {notes[0]!r} to {notes[1]!r}"
    event = noted(small_trial(tmp_path / "out"), why, 120)
    assert event == {"row": 99, "last": 99, "kind": "note", "text": text}


def test_a_note_of_another_form_stands_where_it_came(tmp_path):
    results = small_trial(tmp_path / "out")
    event = noted(results, "recorder: notes changed from '' to 'frame 3 is odd'", 120)
    assert (event["row"], event["kind"]) == (120, "note")
    assert "frame 3 is odd" in event["text"]


def test_an_event_after_the_last_frame_leads_to_it(tmp_path):
    event = noted(small_trial(tmp_path / "out"), "tracker: x changed from 1 to 2", FRAMES + 50)
    assert (event["row"], event["kind"]) == (FRAMES - 1, "source")


def exchanged_in(*spans):
    """A trial whose tracker told the other end in some spans of frames."""
    trial = []
    for state, midline in states(FRAMES / FPS, FPS):
        if any(first <= state.frame <= last for first, last in spans):
            state = replace(state, head=state.tail, tail=state.head)
        trial.append((state, midline))
    return trial


def test_where_ends_change_places_the_frames_up_to_the_next_time_are_offered(tmp_path):
    results = read_results(record(tmp_path / "out", exchanged_in((100, 149), (300, FRAMES - 1))))
    turns = [doubt for doubt in reviewed_doubts(results) if doubt["turns"]]
    found = {(doubt["row"], doubt["last"]): (doubt["from"], doubt["to"]) for doubt in turns}
    assert found == {
        (99, 100): (100, 149),
        (149, 150): (150, 299),
        (299, 300): (300, FRAMES - 1),
    }


def test_of_any_other_doubt_its_own_frames_are_offered(results):
    (lost,) = reviewed_doubts(read_results(results))
    assert (lost["from"], lost["to"]) == (lost["row"], lost["last"]) == (390, 394)
    assert lost["text"].startswith("head and tail not told")
    assert not lost["turns"]
