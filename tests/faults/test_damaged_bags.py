"""What a damaged bag still holds is read and saved, what it lost is said, and nothing hangs."""

import os
import shlex
import struct
import subprocess
import sys
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from forked_commands import worm
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType
from picture_bags import IMAGE, image, numbered_picture, serialised, stamps, storage_file, write_bag
from played_bags import Played, write_raw_mcap
from rosbags.rosbag2 import StoragePlugin

from worm_msgs_py import SourceEventKind
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.bag_repair import name_of_repaired, repair_bag
from worm_tracker.sources.bags.scan.decompression import decompress
from worm_tracker.sources.bags.scan.mcap_records import HEAD, Op
from worm_tracker.sources.bags.scan.scan import Survey, scan_bag

COUNT = 60
COMPRESSIONS = [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]


def write(path, compression=CompressionType.ZSTD, chunk=20_000):
    """Write sixty pictures in ten chunks with checksums."""
    messages = [(t, serialised(image(numbered_picture(k), t))) for k, t in enumerate(stamps(COUNT))]
    return write_raw_mcap(path, messages, IMAGE, chunk=chunk, compression=compression)


def chunks(data):
    """Return where the chunks of an mcap file begin."""
    places, at = [], 8
    while data[at] != Op.DATA_END:
        op, length = HEAD.unpack_from(data, at)
        if op == Op.CHUNK:
            places.append((at, length))
        at += HEAD.size + length
    return places


def survey(path):
    result = Survey()
    for found in scan_bag(path):
        result.take(found)
    return result


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("which", [0, 4, -1])
def test_one_flipped_bit_costs_no_message_outside_its_chunk(tmp_path, compression, which):
    file = write(tmp_path / "a.mcap", compression)
    data = bytearray(file.read_bytes())
    at, length = chunks(data)[which]
    data[at + HEAD.size + length // 2] ^= 1
    file.write_bytes(data)
    found = survey(file)
    assert found.saved >= COUNT - 6
    assert found.losses
    assert all(loss.why for loss in found.losses)
    if compression is CompressionType.NONE:
        assert found.saved == COUNT
    assert found.saved + sum(loss.messages for loss in found.losses) == COUNT


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_chunk_with_a_ruined_header_costs_that_chunk_alone(tmp_path, compression):
    file = write(tmp_path / "a.mcap", compression)
    data = bytearray(file.read_bytes())
    at, _ = chunks(data)[4]
    data[at : at + 60] = bytes(60)
    file.write_bytes(data)
    found = survey(file)
    assert COUNT - 7 <= found.saved < COUNT
    assert found.saved + sum(loss.messages or 0 for loss in found.losses) == COUNT


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("removed", [1, 500])
def test_missing_bytes_cost_no_more_than_the_chunk_they_are_missing_in(
    tmp_path, compression, removed
):
    file = write(tmp_path / "a.mcap", compression)
    data = bytearray(file.read_bytes())
    at, length = chunks(data)[4]
    del data[at + length // 2 : at + length // 2 + removed]
    file.write_bytes(data)
    assert survey(file).saved >= COUNT - 7


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_cut_file_gives_all_that_came_before_the_cut(tmp_path, compression):
    file = write(tmp_path / "a.mcap", compression)
    data = file.read_bytes()
    at, length = chunks(data)[5]
    file.write_bytes(data[: at + length * 3 // 4])
    found = survey(file)
    assert found.saved >= 5 * COUNT // 10
    assert "cut short" in found.losses[-1].why


def test_the_messages_of_an_unchunked_file_are_found_one_by_one(tmp_path):
    file = write(tmp_path / "a.mcap", chunk=0)
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 10_000] = bytes(10_000)
    file.write_bytes(data)
    found = survey(file)
    assert COUNT - 6 <= found.saved < COUNT
    assert found.saved + sum(loss.messages or 0 for loss in found.losses) == COUNT


@given(data=st.data())
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_damaged_page_of_a_db3_costs_its_own_rows(tmp_path_factory, data):
    bag = write_bag(tmp_path_factory.mktemp("db3") / "bag", COUNT, storage=StoragePlugin.SQLITE3)
    file = storage_file(bag)
    content = bytearray(file.read_bytes())
    pages = len(content) // 4096
    page = data.draw(st.integers(1, pages - 1))
    content[page * 4096 : (page + 1) * 4096] = bytes(4096)
    file.write_bytes(content)
    found = survey(file)
    assert found.saved >= COUNT - 5
    assert found.saved + sum(loss.messages or 0 for loss in found.losses) == COUNT


def test_a_db3_without_its_header_and_first_page_still_gives_its_pictures(tmp_path):
    file = storage_file(write_bag(tmp_path / "bag", COUNT, storage=StoragePlugin.SQLITE3))
    content = bytearray(file.read_bytes())
    content[:4096] = bytes(4096)
    file.write_bytes(content)
    with pytest.raises(BadInput, match="worm repair"):
        BagPictures(file)
    found = survey(file)
    assert found.saved == COUNT
    assert "header is damaged" in found.losses[-1].why


def test_rows_that_wait_in_a_write_ahead_log_are_read_from_there(tmp_path):
    file = tmp_path / "killed.db3"
    script = f"""
import os, sqlite3
file = sqlite3.connect({str(file)!r})
file.execute("PRAGMA journal_mode=WAL")
file.executescript('''
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
  timestamp INTEGER NOT NULL, data BLOB NOT NULL);
INSERT INTO topics VALUES (1, '/image_raw', 'sensor_msgs/msg/Image', 'cdr', '');
''')
for k in range(20):
    data = open({str(tmp_path)!r} + f"/{{k}}.cdr", "rb").read()
    file.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?, ?)",
                 ({stamps(1)[0]} + k, data))
    file.commit()
os._exit(9)
"""
    for k, stamp_ns in enumerate(stamps(20)):
        (tmp_path / f"{k}.cdr").write_bytes(serialised(image(numbered_picture(k), stamp_ns)))
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 9
    with pytest.raises(BadInput, match=r"recorder was not closed.*worm repair"):
        BagPictures(file)
    with BagPictures(file, salvage=True) as bag:
        assert [picture.stamp_ns for picture in bag] == stamps(20)


# The command, and what it says.


def test_the_remedy_that_is_named_works_whatever_the_path(tmp_path):
    folder = tmp_path / "it's a $(touch x) folder; `rm`"
    folder.mkdir()
    bag = write_bag(folder / "bag", COUNT)
    (bag / "metadata.yaml").unlink()
    with pytest.raises(BadInput) as caught:
        BagPictures(bag)
    command = str(caught.value).split("save what is there with `", 1)[1]
    command = command[: command.rindex("`, or replay")]
    name, *arguments = shlex.split(command)
    assert name == "worm"
    done = worm(*arguments)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].startswith(f"{COUNT} messages saved in ")
    with BagPictures(name_of_repaired(bag)) as repaired:
        assert repaired.count == COUNT
    again = worm(*arguments)
    assert again.returncode == 2
    assert "exists already" in again.stderr


def test_what_was_lost_is_told_and_the_same_is_played_as_from_the_repaired_bag(
    tmp_path, ros_context, run_graph
):
    file = write(tmp_path / "a.mcap")
    data = bytearray(file.read_bytes())
    at, _ = chunks(data)[4]
    data[at + 70 : at + 1070] = bytes(1000)
    file.write_bytes(data)
    with pytest.raises(BadInput, match=r"damaged.*--salvage"), BagPictures(file) as bag:
        list(bag)
    repaired = name_of_repaired(file)
    lost = sum(loss.messages for loss in repair_bag(file, repaired).losses)
    assert 0 < lost <= 7
    with BagPictures(file, salvage=True) as one, BagPictures(repaired) as other:
        assert [picture.raw for picture in one] == [picture.raw for picture in other]
    played = Played(run_graph, ros_context, file, salvage=True)
    assert len(played.states) == COUNT - lost
    (event,) = played.events
    assert (event.kind, event.count) == (SourceEventKind.LOST, lost)
    assert "a.mcap: the chunk at byte" in event.why


def test_a_repair_that_saves_nothing_leaves_nothing(tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n and no more")
    with pytest.raises(BadInput, match=r"nothing can be saved \(.+\)"):
        repair_bag(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert [file.name for file in tmp_path.iterdir()] == ["a.mcap"]


def test_a_repaired_part_of_a_bag_does_not_become_another_part_of_it(tmp_path):
    bag = write_bag(tmp_path / "bag")
    assert name_of_repaired(storage_file(bag)).parent == tmp_path


def test_control_characters_in_a_topic_do_not_reach_the_terminal(tmp_path):
    topic = "/cam\x1b]0;owned\x07\x1b[2J\nworm: all is well"
    bag = write_bag(tmp_path / "bag", 3, topic=topic)
    for done in (
        worm("repair", str(storage_file(bag))),
        worm("replay", str(bag), "--topic", "/other", "--out", str(tmp_path / "out")),
    ):
        said = done.stdout + done.stderr
        assert "cam" in said
        assert not set(said) & {"\x1b", "\x07"}
        assert "\nworm: all" not in said


# What is no bag at all.


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["a pipe", "a directory"])
@pytest.mark.parametrize("salvage", [False, True])
def test_a_storage_file_that_is_no_file_is_refused(tmp_path, make, salvage):
    bag = write_bag(tmp_path / "bag")
    name = storage_file(bag)
    name.unlink()
    make(name)
    with pytest.raises(BadInput, match="not a regular file"):
        BagPictures(bag, salvage=salvage)
    if make is os.mkfifo:
        with pytest.raises(BadInput, match="not a regular file"):
            BagPictures(name, salvage=salvage)


def test_a_file_that_is_listed_twice_is_never_counted_twice(tmp_path):
    bag = write_bag(tmp_path / "bag")
    meta = bag / "metadata.yaml"
    name = storage_file(bag).name
    text = meta.read_text()
    line = next(line for line in text.splitlines() if line.strip() == f"- {name}")
    meta.write_text(text.replace(line, f"{line}\n{line}"))
    with pytest.raises(BadInput, match="twice"):
        BagPictures(bag)
    with BagPictures(bag, salvage=True) as pictures:
        assert [picture.stamp_ns for picture in pictures] == stamps(20)


@pytest.mark.parametrize("salvage", [False, True])
def test_a_name_that_no_file_system_takes_is_a_bag_that_is_not_there(tmp_path, salvage):
    with pytest.raises(BadInput, match="no such bag"):
        BagPictures(tmp_path / ("x" * 300), salvage=salvage)
    bag = write_bag(tmp_path / "bag")
    meta = bag / "metadata.yaml"
    meta.write_text(meta.read_text().replace(storage_file(bag).name, "x" * 300 + ".mcap"))
    if not salvage:
        with pytest.raises(BadInput, match="not there as a regular file"):
            BagPictures(bag)


# Bombs.


@pytest.mark.parametrize("salvage", [False, True])
def test_a_chunk_that_declares_more_than_is_allowed_is_not_decompressed(tmp_path, salvage):
    file = write(tmp_path / "a.mcap")
    with pytest.raises(BadInput, match="--max-chunk-mib"):
        BagPictures(file, max_chunk_mib=0.01, salvage=salvage)
    data = bytearray(file.read_bytes())
    at, _ = chunks(data)[4]
    struct.pack_into("<Q", data, at + HEAD.size + 16, 2**50)
    file.write_bytes(data)
    found = survey(file)
    assert found.saved == COUNT - found.losses[0].messages
    assert "--max-chunk-mib" in found.losses[0].why


@given(st.integers(0, 3000), st.sampled_from(["zstd", "lz4", ""]))
def test_no_more_is_decompressed_than_is_asked_for(limit, kind):
    plain = bytes(range(256)) * 8
    pack = {"zstd": zstandard.compress, "lz4": lz4.frame.compress, "": bytes}[kind]
    made, why = decompress(pack(plain), kind, limit)
    assert made == plain[:limit]
    assert bool(why) == (limit < len(plain))


def test_a_hundred_bags_that_are_damaged_at_random_do_no_harm():
    command = ["-m", "benchmarks.fuzz_bags", "--count", "100", "--first", "1", "--seed", "2"]
    done = subprocess.run(
        [sys.executable, *command],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "| damaged bags | 100 |" in done.stdout
