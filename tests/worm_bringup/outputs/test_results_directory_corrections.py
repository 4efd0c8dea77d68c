"""What a person has set right in results is never lost by a new run into the same directory."""

import shutil
from dataclasses import replace

import pytest
from result_files import result_text, write_result

from worm_bringup.outputs import results_directory as module
from worm_bringup.outputs.earlier_result import TRIAL
from worm_bringup.outputs.results_directory import Kept, check_out, results_directory
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import (
    CORRECTIONS_FILE,
    Correction,
    CorrectionKind,
    read_corrections,
    write_corrections,
)

SWAPS = [
    Correction(CorrectionKind.SWAP_HEAD, n, n, n + 5, n + 5, "Mia", "2026-03-21T09:30:00Z")
    for n in (0, 10)
]


def earlier(tmp_path, corrections):
    out = tmp_path / "out"
    write_result(out, "earlier")
    write_corrections(out / CORRECTIONS_FILE, corrections)
    return out


def with_these(corrections):
    return replace(TRIAL, corrections=tuple(corrections))


def write_new(out, corrections, meanwhile=lambda: None):
    with results_directory(out, with_these(corrections)) as partial:
        write_result(partial, "new")
        write_corrections(partial / CORRECTIONS_FILE, corrections)
        meanwhile()


def test_results_with_corrections_are_replaced_only_by_those_that_have_them(tmp_path):
    out = earlier(tmp_path, SWAPS)
    for taken in ([], SWAPS[:1]):
        with pytest.raises(BadInput, match="corrections by hand that would be lost"):
            check_out(out, with_these(taken))
        with pytest.raises(BadInput, match="worm replay --corrections"):
            write_new(out, taken)
        assert result_text(out) == "earlier"
    write_new(out, SWAPS)
    assert result_text(out) == "new"
    assert list(read_corrections(out)) == SWAPS
    assert [item.name for item in tmp_path.iterdir()] == ["out"]


def test_a_file_that_cannot_be_read_may_be_a_persons(tmp_path):
    out = earlier(tmp_path, [])
    (out / CORRECTIONS_FILE).write_text("{")
    with pytest.raises(BadInput, match="a person may have written"):
        check_out(out, with_these(SWAPS))


def test_what_is_corrected_while_a_run_replaces_the_results_is_kept(tmp_path):
    out = earlier(tmp_path, SWAPS[:1])
    with pytest.raises(Kept, match="would be lost") as kept:
        write_new(
            out, SWAPS[:1], meanwhile=lambda: write_corrections(out / CORRECTIONS_FILE, SWAPS)
        )
    assert result_text(kept.value.directory) == "new"
    assert result_text(out) == "earlier"
    assert list(read_corrections(out)) == SWAPS


def test_what_is_corrected_at_the_last_moment_is_kept(tmp_path, monkeypatch):
    """After the last look, and before the directories are exchanged."""
    out = earlier(tmp_path, SWAPS[:1])
    exchange = module.put_in_place_of

    def corrected_just_before(partial, place, aside):
        if len(read_corrections(out)) == 1:
            write_corrections(out / CORRECTIONS_FILE, SWAPS)
        exchange(partial, place, aside)

    monkeypatch.setattr(module, "put_in_place_of", corrected_just_before)
    with pytest.raises(Kept):
        write_new(out, SWAPS[:1])
    assert result_text(out) == "earlier"
    assert list(read_corrections(out)) == SWAPS


def test_corrections_outlast_a_run_that_was_killed_after_the_exchange(tmp_path, capsys):
    out = earlier(tmp_path, SWAPS)
    out.rename(tmp_path / ".out.old-01234567")
    write_result(out, "in its place")
    write_new(out, [])
    assert result_text(out) == "new"
    assert list(read_corrections(tmp_path / "out-2")) == SWAPS
    assert "with corrections" in capsys.readouterr().err
    shutil.copytree(tmp_path / "out-2", tmp_path / ".out.old-89abcdef")
    write_corrections(out / CORRECTIONS_FILE, SWAPS)
    write_new(out, SWAPS)
    assert not (tmp_path / ".out.old-89abcdef").exists()
