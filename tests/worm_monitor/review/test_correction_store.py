"""What one browser changes another one is told of, and nothing is lost in silence."""

import getpass
import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reviewed_trials import FPS, FRAMES, change_summary, small_trial

from worm_monitor.review.correction_store import CorrectionStore, who_am_i
from worm_monitor.review.trial import read_reviewed_trial
from worm_msgs_py.files.corrections import (
    Correction,
    CorrectionKind,
    read_corrections,
    write_corrections,
)


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    return read_reviewed_trial(small_trial(tmp_path_factory.mktemp("reviewed") / "out"))


@pytest.fixture
def kept(trial):
    (trial.directory / "corrections.json").unlink(missing_ok=True)
    return CorrectionStore(trial)


def added(kept, first, last, **more):
    entry = {"first": first, "last": last, "by": "M. P.", "note": ""} | more
    return kept.change({"based_on": kept.told()["version"], "add": entry})


def test_a_correction_is_in_the_file_at_once_with_the_stamps_of_its_frames(kept, trial):
    told = added(kept, 12, 36, note="it turned in the fold")
    assert told["refused"] == ""
    (entry,) = read_corrections(trial.directory)
    assert entry.what is CorrectionKind.SWAP_HEAD
    assert (entry.first_frame, entry.last_frame) == (12, 36)
    assert (entry.first_stamp_ns, entry.last_stamp_ns) == (
        round(12e9 / FPS),
        round(36e9 / FPS),
    )
    assert (entry.by, entry.note) == ("M. P.", "it turned in the fold")
    assert told["entries"][0]["frames"] == "from frame 12 to 36"
    assert told["version"] != "none"


def test_an_entry_is_undone_and_the_others_stay(kept, trial):
    for first in (10, 20, 30):
        added(kept, first, first + 5)
    told = kept.change({"based_on": kept.told()["version"], "remove": 1})
    assert [entry["first_frame"] for entry in told["entries"]] == [10, 30]
    assert [entry.first_frame for entry in read_corrections(trial.directory)] == [10, 30]


def test_whoever_saw_an_older_list_is_told_and_nothing_is_lost(kept, trial):
    seen = kept.told()["version"]
    added(kept, 10, 20)
    other = {"first": 50, "last": 60, "by": "other", "note": ""}
    for late in ({"add": other}, {"remove": 0}):
        told = kept.change({"based_on": seen, **late})
        assert "somebody else" in told["refused"]
        assert [entry["first_frame"] for entry in told["entries"]] == [10]
    again = kept.change({"based_on": told["version"], "add": other})
    assert [entry["first_frame"] for entry in again["entries"]] == [10, 50]


def test_frames_that_are_exchanged_already_are_refused_with_the_reason(kept, trial):
    added(kept, 10, 20)
    told = added(kept, 20, 30)
    assert "exchanged twice in frame 20" in told["refused"]
    assert len(read_corrections(trial.directory)) == 1


@pytest.mark.parametrize(
    "asked",
    [
        {"first": 30, "last": 10},
        {"first": 0, "last": FRAMES},
        {"first": -1, "last": 3},
        {"first": "3", "last": 5},
        {"first": 1, "last": 3, "by": "  "},
        {"first": 1, "last": 3, "note": "x" * 401},
        {"first": 1, "last": 3, "note": "\x1b[2J"},
    ],
)
def test_what_is_no_correction_is_refused_in_a_line_and_nothing_is_written(kept, trial, asked):
    told = added(kept, **asked)
    assert told["refused"].startswith("the correction ")
    assert "\n" not in told["refused"]
    assert not (trial.directory / "corrections.json").exists()


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda item: st.lists(item) | st.dictionaries(st.text(), item),
    max_leaves=5,
)


@given(_JSON, st.sampled_from(["add", "remove"]))
def test_nothing_that_a_browser_can_send_breaks_the_file(trial, value, what):
    (trial.directory / "corrections.json").unlink(missing_ok=True)
    kept = CorrectionStore(trial)
    told = kept.change({"based_on": "none", what: value})
    assert told["refused"]
    assert not (trial.directory / "corrections.json").exists()


def test_what_was_asked_for_in_the_trial_itself_is_shown_and_stays(kept, trial):
    request = Correction(
        CorrectionKind.SWAP_REQUEST, 4, 0, None, None, "op", "2026-03-21T09:30:00Z"
    )
    write_corrections(trial.directory / "corrections.json", [request])
    told = kept.change({"based_on": kept.told()["version"], "remove": 0})
    assert "stays" in told["refused"]
    assert read_corrections(trial.directory) == (request,)


def test_a_file_that_is_none_of_ours_is_told_and_left_as_it_is(kept, trial):
    path = trial.directory / "corrections.json"
    path.write_text('{"mine": 1}')
    assert "corrections.json" in kept.told()["damaged"]
    assert added(kept, 1, 2)["damaged"]
    assert path.read_text() == '{"mine": 1}'


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_directory_that_cannot_be_written_is_told(kept, trial):
    trial.directory.chmod(0o500)
    try:
        assert "cannot be written" in added(kept, 1, 2)["refused"]
    finally:
        trial.directory.chmod(0o700)


def test_the_page_gets_no_number_that_javascript_would_round(kept):
    added(kept, 1, 2)
    assert "stamp" not in json.dumps(kept.told())


def test_the_login_name_is_offered(monkeypatch):
    assert who_am_i() == getpass.getuser()

    def nobody():
        raise KeyError

    monkeypatch.setattr(getpass, "getuser", nobody)
    assert who_am_i() == ""


def test_results_of_a_table_of_tracks_take_no_corrections(tmp_path):
    results = small_trial(tmp_path / "out")
    change_summary(results, lambda s: s["provenance"].update(source={"table": "tracks.csv"}))
    kept = CorrectionStore(read_reviewed_trial(results))
    assert "analyse it again" in kept.told()["never"]
    assert added(kept, 1, 2)["refused"]
    assert not (results / "corrections.json").exists()


def test_results_that_were_made_anew_are_not_corrected_by_what_was_seen_before(tmp_path):
    results = small_trial(tmp_path / "out")
    kept = CorrectionStore(read_reviewed_trial(results))
    assert added(kept, 1, 2)["refused"] == ""
    results.rename(tmp_path / "old")
    small_trial(results)
    assert "made anew" in kept.told()["never"]
    assert added(kept, 5, 6)["refused"]
    assert not (results / "corrections.json").exists()
