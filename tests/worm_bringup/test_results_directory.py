"""A results directory is there whole or not at all, and nothing of the user's is lost."""

import pytest

from worm_bringup.provenance import bag_hash
from worm_bringup.results_directory import results_directory
from worm_msgs_py.errors import BadInput


def test_results_appear_whole(tmp_path):
    out = tmp_path / "deep" / "out"
    with results_directory(out) as partial:
        (partial / "summary.json").write_text("{}")
        assert not out.exists()
    assert [item.name for item in out.iterdir()] == ["summary.json"]
    assert [item.name for item in out.parent.iterdir()] == ["out"]


def test_a_failed_run_leaves_nothing_and_keeps_the_earlier_result(tmp_path):
    out = tmp_path / "out"
    with results_directory(out) as partial:
        (partial / "summary.json").write_text("first")

    def fail_half_way():
        with results_directory(out) as partial:
            (partial / "summary.json").write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail_half_way()
    assert (out / "summary.json").read_text() == "first"
    assert [item.name for item in tmp_path.iterdir()] == ["out"]


def test_a_second_run_replaces_the_first(tmp_path):
    out = tmp_path / "out"
    for text in ("first", "second"):
        with results_directory(out) as partial:
            (partial / "summary.json").write_text(text)
    assert (out / "summary.json").read_text() == "second"


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


def test_the_hash_of_a_bag_follows_its_content_alone(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.mcap").write_bytes(b"abc")
    assert bag_hash(tmp_path / "one") == bag_hash(tmp_path / "two")
    (tmp_path / "two" / "a.mcap").write_bytes(b"abd")
    assert bag_hash(tmp_path / "one") != bag_hash(tmp_path / "two")
