"""An earlier result is replaced whole, or not at all; nothing else ever is; no result is lost."""

import os
import shutil
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from result_files import SUMMARY, TABLES, files_in, result_text, write_result

from worm_bringup.outputs import directory_swap
from worm_bringup.outputs.earlier_result import POOLED
from worm_bringup.outputs.output_lock import output_lock
from worm_bringup.outputs.results_directory import Kept, check_out, results_directory
from worm_msgs_py.errors import BadInput

OURS = [*TABLES, "report.html", "bag/metadata.yaml", "bag/bag.mcap", "figures/fig-1d.svg",
        "report_frame_000012.png"]  # fmt: skip
FOREIGN = ["notes.txt", "bag/notes.txt", "bag/other.mcap", "bag/bag_0.mcap", "figures/mine.svg",
           "frame_000012.png", "report_frame_12.png", "tracks.parquet~", "Report.html",
           "bag/deep/bag.mcap", "link"]  # fmt: skip


def put(directory, name):
    """Write a file whose content no other file has."""
    path = directory / name
    with suppress(FileExistsError, NotADirectoryError):
        path.parent.mkdir(parents=True, exist_ok=True)
        if name == "link":
            path.symlink_to("summary.json")
        elif not path.exists():
            path.write_text(f"{name} of {directory.name}, {os.urandom(8).hex()}")


class BrokenError(RuntimeError):
    pass


@settings(max_examples=300)
@given(
    there=st.sets(st.sampled_from([*OURS, *OURS, *FOREIGN[:3]]), max_size=4),
    summary=st.sampled_from([None, SUMMARY, SUMMARY, SUMMARY, "{}", "[", '{"provenance": []}']),
    meanwhile=st.sets(st.sampled_from(FOREIGN), max_size=2),
    removed=st.booleans(),
    breaks=st.sampled_from(["never", "never", "half way", "after the summary"]),
)
def test_nothing_is_lost_whatever_is_in_the_directory_and_whatever_comes_into_it(
    there, summary, meanwhile, removed, breaks
):
    with tempfile.TemporaryDirectory() as folder:
        top = Path(folder)
        out = top / "out"
        for name in there:
            put(out, name)
        if summary is not None and out.exists():
            (out / "summary.json").write_text(summary)
        before = files_in(top)
        at_start = None
        try:
            with results_directory(out) as partial:
                if removed:
                    shutil.rmtree(out, ignore_errors=True)
                at_start = files_in(top)
                for name in meanwhile:
                    put(out, name)
                came = {k: v for k, v in files_in(top).items() if k not in at_start}
                if breaks == "half way":
                    (partial / "tracks.parquet").write_text("half")
                    raise BrokenError
                write_result(partial, "new")
                if breaks != "never":
                    raise BrokenError
        except BadInput:
            assert at_start is None
            assert files_in(top) == before
            return
        except (Kept, BrokenError):
            pass
        after = files_in(top)
        whole = SUMMARY.encode() == before.get("out/summary.json")
        assert not before or (whole and {name[4:] for name in before} <= {*OURS, "summary.json"})
        assert came.items() <= after.items()
        new = [Path(name).parent for name, data in after.items() if data == b"new"]
        places = {place for place in new if place.name != "bag"}
        assert len(places) == (0 if breaks == "half way" else 1)
        for place in places:
            assert result_text(top / place) == "new"
        if places != {Path("out")}:
            assert at_start.items() - {(".out.lock", b"")} <= after.items()
        assert not [item.name for item in top.iterdir() if item.name.startswith(".")]


def earlier_result(tmp_path):
    out = tmp_path / "out"
    write_result(out, "earlier")
    return out


def write_new(out, *, meanwhile=lambda: None, fails=None):
    with results_directory(out) as partial:
        write_result(partial, "new", report=fails is None)
        meanwhile()
        if fails is not None:
            raise fails


@pytest.mark.parametrize("name", ["notes.txt", "bag/notes.txt"])
def test_notes_written_into_the_directory_during_a_trial_are_kept_and_so_are_the_results(
    tmp_path, name
):
    out = earlier_result(tmp_path)
    with pytest.raises(Kept, match=rf"{name}.*new results are whole and kept in .*out-2$"):
        write_new(out, meanwhile=lambda: (out / name).write_text("what I saw"))
    assert (out / name).read_text() == "what I saw"
    assert result_text(out) == "earlier"
    assert result_text(tmp_path / "out-2") == "new"


def test_results_are_kept_under_a_name_that_is_free(tmp_path):
    out = earlier_result(tmp_path)
    (tmp_path / "out-2").mkdir()
    (tmp_path / "out-3").write_text("mine")
    with pytest.raises(Kept, match=r"out-4$") as kept:
        write_new(out, meanwhile=lambda: (out / "notes.txt").write_text(""))
    assert kept.value.directory == tmp_path / "out-4"
    assert result_text(tmp_path / "out-4") == "new"


def test_a_directory_that_became_a_file_is_left_alone(tmp_path):
    out = tmp_path / "out"
    with pytest.raises(Kept, match=r"is a file by now.*out-2$"):
        write_new(out, meanwhile=lambda: out.write_text("mine"))
    assert out.read_text() == "mine"
    assert result_text(tmp_path / "out-2") == "new"


def test_results_without_a_report_are_kept_where_they_were_to_be(tmp_path):
    with pytest.raises(Kept, match=r"out, but their report is not written \(no fonts\)"):
        write_new(tmp_path / "out", fails=RuntimeError("no fonts"))
    assert result_text(tmp_path / "out") == "new"


def test_results_without_a_report_do_not_replace_an_earlier_result(tmp_path):
    out = earlier_result(tmp_path)
    with pytest.raises(Kept, match=r"kept in .*out-2"):
        write_new(out, fails=KeyboardInterrupt())
    assert result_text(out) == "earlier"
    assert result_text(tmp_path / "out-2") == "new"


def test_a_result_of_another_command_is_not_replaced(tmp_path):
    out = earlier_result(tmp_path)
    with pytest.raises(BadInput, match="not a result of ours"), results_directory(out, POOLED):
        pass
    assert result_text(out) == "earlier"


@pytest.mark.parametrize("kind", ["good", "dangling"])
def test_a_symbolic_link_is_followed_once_and_stays(tmp_path, kind):
    target, out = tmp_path / "disk" / "target", tmp_path / "out"
    target.parent.mkdir()
    if kind == "good":
        write_result(target, "earlier")
    out.symlink_to(target)
    write_new(out)
    assert out.readlink() == target
    assert result_text(target) == "new"
    assert [item.name for item in target.parent.iterdir()] == ["target"]


def test_links_in_a_circle_are_one_line(tmp_path):
    (tmp_path / "one").symlink_to("two")
    (tmp_path / "two").symlink_to("one")
    with pytest.raises(BadInput, match="circle"), results_directory(tmp_path / "one"):
        pass


def test_a_second_run_into_a_directory_is_refused_and_the_first_undisturbed(tmp_path):
    out = earlier_result(tmp_path)
    link = tmp_path / "link"
    link.symlink_to(out)
    with results_directory(out) as partial:
        write_result(partial, "new")
        for name in (out, link):
            with pytest.raises(BadInput, match=r"another run.*--out"):
                check_out(name)
            with pytest.raises(BadInput, match=r"another run.*--out"), results_directory(name):
                pass
    assert result_text(out) == "new"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["link", "out"]


def test_runs_into_directories_side_by_side_do_not_wait_for_each_other(tmp_path):
    with results_directory(tmp_path / "a") as a, results_directory(tmp_path / "b") as b:
        write_result(a, "a")
        write_result(b, "b")
    assert result_text(tmp_path / "a") == "a"
    assert result_text(tmp_path / "b") == "b"


def test_a_lock_that_was_removed_while_it_was_held_is_not_taken_for_the_next_one(tmp_path):
    with output_lock(tmp_path / "out"):
        (tmp_path / ".out.lock").unlink()
        with output_lock(tmp_path / "out"):
            pass
    assert list(tmp_path.iterdir()) == []


@contextmanager
def renames_alone(monkeypatch):
    """A file system that cannot exchange two names, as NFS."""

    def cannot(one, other):
        raise OSError(22, "Invalid argument")

    with monkeypatch.context() as patch:
        patch.setattr(directory_swap, "_exchange", cannot)
        yield


def test_a_file_system_that_cannot_exchange_gets_two_renames(tmp_path, monkeypatch):
    out = earlier_result(tmp_path)
    with renames_alone(monkeypatch):
        write_new(out)
        with pytest.raises(Kept):
            write_new(out, meanwhile=lambda: (out / "notes.txt").write_text("mine"))
    assert result_text(out) == "new"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["out", "out-2"]


def test_an_earlier_result_comes_back_that_was_set_aside_when_the_process_was_killed(tmp_path):
    write_result(tmp_path / ".out.old-0123abcd", "earlier")
    with suppress(BrokenError), results_directory(tmp_path / "out"):
        raise BrokenError
    assert result_text(tmp_path / "out") == "earlier"
    assert [item.name for item in tmp_path.iterdir()] == ["out"]


def test_what_killed_runs_left_is_removed_but_for_what_is_not_ours(tmp_path):
    for name in ("00000001", "00000002"):
        write_result(tmp_path / f".out.partial-{name}", "half")
        (tmp_path / f".out.partial-{name}" / "summary.json").unlink()
    (tmp_path / ".out.partial-00000002" / "notes.txt").write_text("mine")
    (tmp_path / ".out.partial-notours").write_text("mine")
    write_new(tmp_path / "out")
    left = files_in(tmp_path)
    assert left[".out.partial-00000002/notes.txt"] == b"mine"
    assert left[".out.partial-notours"] == b"mine"
    assert len(left) == 10


def test_what_a_killed_live_trial_left_is_never_removed(tmp_path, capsys):
    left = tmp_path / ".out.live-01234567"
    left.mkdir()
    (left / "tracks.parquet").write_text("all that there is")
    write_new(tmp_path / "out")
    assert (left / "tracks.parquet").read_text() == "all that there is"
    assert str(left) in capsys.readouterr().err


@pytest.mark.parametrize(("live", "frames"), [(True, 3), (True, 0), (False, 3)])
def test_an_unfinished_live_trial_is_kept_and_told_and_nothing_else(tmp_path, capsys, live, frames):
    with suppress(BrokenError), results_directory(tmp_path / "out", live=live) as partial:
        pq.write_table(pa.table({"frame": list(range(frames))}), partial / "tracks.parquet")
        raise BrokenError
    kept = tmp_path / "out-unfinished"
    if live and frames:
        assert pq.read_metadata(kept / "tracks.parquet").num_rows == frames
        assert str(kept) in capsys.readouterr().err
    else:
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("purpose", ["live", "partial"])
def test_finished_results_of_a_killed_run_get_a_name_that_is_told(tmp_path, capsys, purpose):
    write_result(tmp_path / f".out.{purpose}-01234567", "finished")
    write_new(tmp_path / "out")
    assert result_text(tmp_path / "out-2") == "finished"
    assert result_text(tmp_path / "out") == "new"
    assert f"{tmp_path / 'out-2'}: finished results" in capsys.readouterr().err
