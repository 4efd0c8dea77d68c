"""What a command writes never is, holds, or lies in something else that it writes or reads."""

import os
import tempfile
from pathlib import Path

import pytest
from forked_commands import worm
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from picture_bags import storage_file, write_bag
from result_files import files_in, write_result

from worm_bringup.outputs.output_rules import check_apart
from worm_msgs_py.errors import BadInput

NAMES = st.sampled_from(["a", "b", "c", "..", "l", "m"])
PATHS = st.lists(NAMES, min_size=1, max_size=4).map("/".join)
TARGETS = PATHS | st.sampled_from(["../b", "../c", "../a/c"])


def make_tree(root, folders, links):
    for folder in folders:
        os.makedirs(os.path.realpath(root / folder), exist_ok=True)  # noqa: PTH103
    for link, target in links.items():
        if not os.path.lexists(root / link):
            (root / link).symlink_to(target)


def make(place):
    """Make a directory as the system takes its name; return the inodes from it to the root."""
    real = Path(os.path.realpath(place))
    real.mkdir(parents=True, exist_ok=True)
    return [(folder.stat().st_dev, folder.stat().st_ino) for folder in (real, *real.parents)]


def touch(one, other):
    return one[0] in other or other[0] in one


@settings(max_examples=300)
@given(
    folders=st.lists(PATHS, max_size=4),
    links=st.dictionaries(st.sampled_from(["l", "m", "a/l", "b/m"]), TARGETS, max_size=3),
    out=PATHS,
    record=PATHS,
    bag=PATHS | st.sampled_from(["a", "b"]),
)
def test_places_are_accepted_where_none_is_in_another_on_the_disk(folders, links, out, record, bag):
    with tempfile.TemporaryDirectory() as top:
        root = Path(top, "1", "2", "3", "4", "5")
        for folder in ("a", "b"):
            (root / folder).mkdir(parents=True)
        make_tree(root, folders, links)
        inside = [path for path in (root / bag).rglob("*") if path.is_symlink()]
        accepted = True
        try:
            check_apart({"--out": root / out, "--record": root / record}, {"the bag": root / bag})
        except BadInput as error:
            assume("circle" not in str(error))
            accepted = False
        try:
            of_out, of_record, of_bag = (make(root / name) for name in (out, record, bag))
            read = [of_bag, *(make(link) for link in inside)]
        except (OSError, RuntimeError):
            assume(False)
        together = touch(of_out, of_record) or any(
            touch(written, each) for written in (of_out, of_record) for each in read
        )
        assert accepted != together


def test_a_link_in_the_bag_is_followed(tmp_path):
    write_result(tmp_path / "trial", "")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap").symlink_to(tmp_path / "trial" / "bag" / "bag.mcap")
    with pytest.raises(BadInput, match=r"--out .*trial: holds the bag"):
        check_apart({"--out": tmp_path / "trial"}, {"the bag": tmp_path / "bag"})


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("replay bag --out bag", "is the same as the bag"),
        ("replay bag/FILE --out bag", "holds the bag"),
        ("replay bag --out bag/out", "lies in the bag"),
        ("replay trial/bag --out trial", "holds the bag"),
        ("live --camera http://127.0.0.1:9/ --out t --record t/rec", "holds --record"),
        ("live --camera http://127.0.0.1:9/ --out t --record t", "is the same as --record"),
        ("live --camera http://127.0.0.1:9/ --out t/out --record t", "lies in --record"),
        ("report trial --out trial/pool", "lies in trial 1"),
        ("analyse trial --out trial", "holds the tracks"),
        ("import film --out film/bag", "lies in the film"),
        ("replay bag --out .", "holds the bag"),
        ("replay ../bag --out . # from elsewhere", "is the directory you are in"),
    ],
)
def test_a_command_refuses_places_that_touch_before_it_makes_anything(tmp_path, command, said):
    bag = write_bag(tmp_path / "bag", 2)
    write_result(tmp_path / "trial", "earlier")
    for folder in ("film", "elsewhere"):
        (tmp_path / folder).mkdir()
    before = files_in(tmp_path)
    name = storage_file(bag).name
    command, _, elsewhere = command.replace("FILE", name).partition(" # from ")
    done = worm(*command.split(), cwd=tmp_path / elsewhere)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert said in line
    assert "--out" in line
    assert files_in(tmp_path) == before
