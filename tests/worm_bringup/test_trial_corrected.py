"""A replay with corrections has them in all of its files, and is the same every time."""

import json
from dataclasses import replace
from pathlib import Path

import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
from forked_commands import run_command
from result_files import TABLES
from stopped_replays import FILES, replay, trial_of

from worm_bringup.graph.node_spec import NodeSpec
from worm_msgs_py.files.corrections import (
    CORRECTIONS_FILE,
    Correction,
    CorrectionKind,
    read_corrections,
    write_corrections,
)

BAG = Path(__file__).parents[2] / "bags" / "larva"
PLAYED_S, FIRST, LAST = 2.0, 10, 14
pytestmark = pytest.mark.xdist_group("corrected trial")


def replayed(out, corrections=(), viewers=()):
    trial = trial_of(BAG, playback_duration=PLAYED_S)
    replay(replace(trial, corrections=tuple(corrections), viewers=tuple(viewers)), out)
    return out


def stamps(out):
    return pq.read_table(out / "tracks.parquet", columns=["stamp_ns"])["stamp_ns"].to_pylist()


def the_same(one, other, names):
    return [name for name in names if (one / name).read_bytes() != (other / name).read_bytes()]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("corrected")


@pytest.fixture(scope="module")
def plain(folder):
    return replayed(folder / "plain")


@pytest.fixture(scope="module")
def swap(plain):
    taken_ns = stamps(plain)
    return Correction(
        CorrectionKind.SWAP_HEAD,
        FIRST,
        taken_ns[FIRST],
        LAST,
        taken_ns[LAST],
        "Mia",
        "2026-03-21T09:30:00Z",
        "by eye",
    )


@pytest.fixture(scope="module")
def corrected(folder, swap):
    return replayed(folder / "corrected", [swap])


@pytest.fixture(scope="module")
def asked(folder):
    operator = NodeSpec("asking_node", "asker", {"after_frames": [12, 20]})
    return replayed(folder / "asked", viewers=[operator])


def test_corrected_frames_are_turned_round_and_all_others_are_as_they_were(plain, corrected):
    before, after = (pq.read_table(out / "tracks.parquet") for out in (plain, corrected))
    inside = pc.and_(pc.greater_equal(before["frame"], FIRST), pc.less_equal(before["frame"], LAST))
    of_the_tracker = [
        name
        for name in before.column_names
        if name.startswith(("head", "tail", "centroid", "midline", "where", "status", "length"))
    ]
    outside = [table.filter(pc.invert(inside)).select(of_the_tracker) for table in (before, after)]
    assert outside[0].equals(outside[1])
    turned = after.filter(inside)
    assert turned["head_u_px"].equals(before.filter(inside)["tail_u_px"])
    assert turned["r_t_mm"].equals(before.filter(inside)["r_h_mm"])


def test_a_summary_and_a_report_say_what_was_corrected(plain, corrected, swap):
    said = json.loads((corrected / "summary.json").read_text())["corrections"]
    assert said["frames_swapped"] == LAST - FIRST + 1
    (applied,) = said["applied"]
    assert Correction(**applied) == swap
    line = "head and tail were exchanged by hand in 5 frames: from frame 10 to 14 (by Mia)"
    assert line in (corrected / "report.html").read_text()
    assert read_corrections(corrected) == (swap,)
    assert "corrections" not in json.loads((plain / "summary.json").read_text())
    assert not (plain / CORRECTIONS_FILE).exists()


def test_a_replay_that_was_stopped_does_not_go_on_with_other_corrections(swap):
    plain = trial_of(BAG, playback_duration=PLAYED_S)
    other = replace(swap, last_frame=LAST + 1, last_stamp_ns=swap.last_stamp_ns + 1)
    told = [replace(plain, corrections=these).fingerprint for these in ((), (swap,), (other,))]
    assert all(told.count(each) == 1 for each in told)


def test_the_command_replaces_its_own_corrected_results_by_the_same_bytes(
    tmp_path, corrected, swap
):
    played = ["replay", str(BAG), "--playback-duration", str(PLAYED_S)]
    file = tmp_path / "mine.json"
    write_corrections(file, [swap])
    before = None
    for given in (file, tmp_path / "out"):
        words = [*played, "--out", str(tmp_path / "out"), "--corrections", str(given)]
        status, said = run_command(words, tmp_path, {})
        assert status == 0, said
        assert "exchanged by hand in 5 frames" in said
        assert "other parameters" not in said
        found = {name: (tmp_path / "out" / name).read_bytes() for name in FILES}
        assert before in (None, found)
        before = found
    assert not the_same(tmp_path / "out", corrected, (*TABLES, CORRECTIONS_FILE))
    words = [*played, "--out", str(tmp_path / "on"), "--corrections", str(tmp_path / "out")]
    status, said = run_command([*words, "--hold-back-frames", "300"], tmp_path, {})
    assert status == 0, said
    assert "other parameters (hold_back_frames was 1000, is 300): the corrections exchange" in said
    status, said = run_command([*played, "--out", str(tmp_path / "out")], tmp_path, {})
    assert status == 2
    assert "corrections by hand that would be lost (from frame 10 to 14, by Mia)" in said
    assert {name: (tmp_path / "out" / name).read_bytes() for name in FILES} == before


def test_corrections_of_another_recording_are_refused_before_anything_is_made(tmp_path, swap):
    file = tmp_path / "mine.json"
    for wrong in (
        replace(swap, first_stamp_ns=swap.first_stamp_ns + 1),
        replace(swap, last_frame=10**6),
    ):
        write_corrections(file, [wrong])
        words = ["replay", str(BAG), "--out", str(tmp_path / "out"), "--corrections", str(file)]
        status, said = run_command([*words, "--playback-duration", "2"], tmp_path, {})
        assert status == 2
        assert said.startswith(f"worm: {file}: the correction from frame 10")
        assert "of another recording" in said
        assert said.count("\n") == 1
        assert [item.name for item in tmp_path.iterdir()] == ["mine.json"]


def test_what_an_operator_asked_for_is_told_and_a_replay_with_it_gives_the_same(
    folder, plain, asked
):
    corrections = read_corrections(asked)
    said = json.loads((asked / "summary.json").read_text())["corrections"]
    assert [Correction(**entry) for entry in said["applied"]] == list(corrections)
    assert [told.what for told in corrections] == [CorrectionKind.SWAP_REQUEST] * 2
    assert {told.by for told in corrections} == {"~/swap_head"}
    taken_ns = stamps(asked)
    assert all(told.first_stamp_ns == taken_ns[told.first_frame] for told in corrections)
    assert the_same(plain, asked, ["tracks.parquet"])
    assert "exchanged on request: after frame" in (asked / "report.html").read_text()
    again = replayed(folder / "again", corrections)
    assert not the_same(asked, again, (*FILES, CORRECTIONS_FILE))
