"""A results directory is there whole or not at all."""

import os
from pathlib import Path

import pytest
from result_files import SUMMARY, result_text, write_result

from worm_bringup.outputs.results_directory import results_directory
from worm_bringup.provenance import bag_hash
from worm_msgs_py.errors import BadInput


def names_in(directory):
    return sorted(item.name for item in directory.iterdir())


def test_results_appear_whole(tmp_path):
    out = tmp_path / "deep" / "out"
    with results_directory(out) as partial:
        (partial / "summary.json").write_text(SUMMARY)
        assert not out.exists()
    assert names_in(out) == ["summary.json"]
    assert names_in(out.parent) == ["out"]


def test_the_directory_has_the_rights_that_the_umask_gives(tmp_path):
    before = os.umask(0o027)
    try:
        with results_directory(tmp_path / "out") as partial:
            (partial / "summary.json").write_text(SUMMARY)
    finally:
        os.umask(before)
    assert (tmp_path / "out").stat().st_mode & 0o777 == 0o750


def test_a_failed_run_leaves_nothing_and_keeps_the_earlier_result(tmp_path):
    out = tmp_path / "out"
    with results_directory(out) as partial:
        write_result(partial, "first")

    def fail_half_way():
        with results_directory(out) as partial:
            (partial / "tracks.parquet").write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail_half_way()
    assert result_text(out) == "first"
    assert names_in(tmp_path) == ["out"]


def test_a_second_run_replaces_the_first(tmp_path):
    out = tmp_path / "out"
    for text in ("first", "second"):
        with results_directory(out) as partial:
            write_result(partial, text)
    assert result_text(out) == "second"
    assert names_in(tmp_path) == ["out"]


def test_two_runs_have_directories_whose_names_cannot_be_foretold(tmp_path):
    names = set()
    for _ in range(2):
        with results_directory(tmp_path / "out") as partial:
            names.add(partial.name)
            write_result(partial, "")
    assert len(names) == 2


@pytest.mark.parametrize("name", ["[x]", "a b", "*", "ö", "-n", "x" * 200, "out.partial-00000000"])
def test_a_directory_may_have_any_name(tmp_path, name):
    for text in ("first", "second"):
        with results_directory(tmp_path / name) as partial:
            write_result(partial, text)
    assert result_text(tmp_path / name) == "second"
    assert names_in(tmp_path) == [name]


def test_a_name_that_is_too_long_is_one_line(tmp_path):
    with (
        pytest.raises(BadInput, match=r"too long.*choose another"),
        results_directory(tmp_path / ("x" * 256)),
    ):
        pass


def test_a_directory_with_other_things_is_refused_and_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with (
        pytest.raises(BadInput, match=r"thesis\.tex.*--out"),
        results_directory(tmp_path),
    ):
        pass
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_a_file_is_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(BadInput, match="is a file"), results_directory(file):
        pass


@pytest.mark.parametrize("out", [".", "..", "", "/", "~"])
def test_no_place_for_results_is_refused(tmp_path, monkeypatch, out):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with (
        pytest.raises(BadInput, match=r"is (the directory you are in|your home)"),
        results_directory(Path(out).expanduser()),
    ):
        pass
    assert names_in(tmp_path) == ["here"]


def test_the_hash_of_a_bag_follows_its_content_alone(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.mcap").write_bytes(b"abc")
    assert bag_hash(tmp_path / "one") == bag_hash(tmp_path / "two")
    (tmp_path / "two" / "a.mcap").write_bytes(b"abd")
    assert bag_hash(tmp_path / "one") != bag_hash(tmp_path / "two")
