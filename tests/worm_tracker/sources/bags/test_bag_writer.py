"""A record is whole however it ends: in several files, compressed as asked, cut at any byte."""

import os
import shutil
import signal
import subprocess
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
import yaml
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from picture_bags import START_NS, image, numbered_picture, serialised
from rosbags.rosbag2 import Reader

from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.bag_repair import repair_bag
from worm_tracker.sources.bags.bag_writer import PictureRecorder
from worm_tracker.sources.bags.pictures import pictures_of_bag
from worm_tracker.sources.cameras.live_record import LiveRecord, RecordAs, RecordForm
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame
from worm_tracker.sources.image_decoder import IMAGE_TYPE

PERIOD_NS = 10**8


def frame(number, shape=(48, 64)):
    return CapturedFrame(numbered_picture(number, shape), START_NS + number * PERIOD_NS)


def write(record, numbers, shape=(48, 64)):
    for number in numbers:
        one = frame(number, shape)
        record.write(one, serialised(image(one.picture, one.stamp_ns)))


def stamps_of(bag):
    with BagPictures(bag) as pictures:
        return [picture.stamp_ns for picture in pictures]


@pytest.mark.parametrize(
    ("split", "files"),
    [
        pytest.param({"split_min": 1.0 / 60.0}, 3, id="a second"),
        pytest.param({"split_mib": 1.0}, 2, id="a mebibyte"),
        pytest.param({"split_mib": 0.0, "split_min": 0.0}, 1, id="never"),
    ],
)
def test_a_record_in_several_files_is_one_bag(tmp_path, split, files):
    record = LiveRecord(tmp_path / "bag", "/image_raw", RecordForm(**split))
    noise = np.random.default_rng(0).integers(0, 256, (300, 400), np.uint8)
    for number in range(25 if "split_min" in split else 15):
        one = CapturedFrame(noise, START_NS + number * PERIOD_NS)
        record.write(one, serialised(image(noise, one.stamp_ns)))
    record.close()
    names = [f"bag_{number}.mcap" for number in range(files)]
    assert sorted(file.name for file in (tmp_path / "bag").glob("*.mcap")) == names
    with Reader(tmp_path / "bag") as reader:  # by another library
        found = [stamp for _, stamp, _ in reader.messages()]
    assert found == stamps_of(tmp_path / "bag")
    assert len(found) == record.count
    assert (np.diff(found) == PERIOD_NS).all()


@pytest.mark.parametrize("form", list(RecordAs))
def test_pictures_are_recorded_as_asked_and_the_record_says_how(tmp_path, form):
    record = LiveRecord(tmp_path / "bag", "/rig1/image_raw", RecordForm(form, jpeg_quality=95))
    write(record, range(8))
    record.close()
    for number, (grey, stamp_ns) in enumerate(pictures_of_bag(tmp_path / "bag")):
        assert stamp_ns == frame(number).stamp_ns
        off = np.abs(grey.astype(int) - frame(number).picture).max()
        assert off == 0 if form is not RecordAs.JPEG else off < 60
    text = (tmp_path / "bag" / "metadata.yaml").read_text()
    notes = yaml.safe_load(text)["rosbag2_bagfile_information"]["custom_data"]
    assert notes["recorded_as"] == form
    assert ("jpeg_quality" in notes) is (form is RecordAs.JPEG)
    with BagPictures(tmp_path / "bag") as pictures:
        compressed = "" if form is RecordAs.ZSTD else "/compressed"
        assert pictures.topic == "/rig1/image_raw" + compressed


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """A record that was never closed, and how long its file was after each picture."""
    folder = tmp_path_factory.mktemp("cut") / "bag"
    recorder = PictureRecorder(folder, "/image_raw", IMAGE_TYPE)
    lengths = []
    for number in range(20):
        one = frame(number)
        recorder.write(one.stamp_ns, serialised(image(one.picture, one.stamp_ns)))
        lengths.append(recorder.bytes_on_disk)
    return folder / "bag_0.mcap", lengths


@settings(max_examples=60, deadline=None)
@given(share=st.floats(0.2, 1.0))
def test_a_file_that_is_cut_anywhere_has_every_picture_before_the_cut(cut, tmp_path_factory, share):
    file, lengths = cut
    folder = tmp_path_factory.mktemp("again") / "bag"
    folder.mkdir()
    shutil.copy(file, folder)
    length = max(lengths[0], round(share * lengths[-1]))
    os.truncate(folder / file.name, length)
    saved = folder.with_name("saved.mcap")
    repair_bag(folder, saved)
    whole = sum(end <= length for end in lengths)
    assert stamps_of(saved)[:whole] == [frame(number).stamp_ns for number in range(whole)]
    assert len(stamps_of(saved)) <= whole + 1  # the one that was being written


def test_no_picture_that_is_older_than_half_a_second_waits_for_the_medium(tmp_path, monkeypatch):
    now, synced, asked = [0.0], [], []
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(os, "fdatasync", lambda handle: synced.append(now[0]))
    recorder = PictureRecorder(tmp_path / "bag", "/image_raw", IMAGE_TYPE, sync_s=0.5)
    for number in range(50):
        now[0] += 0.04
        one = frame(number)
        recorder.write(one.stamp_ns, serialised(image(one.picture, one.stamp_ns)))
        asked.append(now[0] - (synced[-1] if synced else 0.0))
    assert max(asked) < 0.5 + 0.04
    assert len(synced) == 2.0 // 0.52


KILLED = """
import sys
from test_bag_writer import *
record = LiveRecord(Path(sys.argv[1]), "/image_raw", RecordForm(split_min=1 / 60))
for number in range(10**6):
    write(record, [number], (300, 400))
    if number == 60:
        print("going", flush=True)
"""


def test_what_a_killed_recorder_leaves_is_saved_out_of_all_its_files(tmp_path):
    bag = tmp_path / "bag"
    environment = os.environ | {"PYTHONPATH": ":".join([*sys.path, str(Path(__file__).parent)])}
    command = [sys.executable, "-c", KILLED, bag]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout.readline() == b"going\n"
        process.send_signal(signal.SIGKILL)
    assert len(list(bag.glob("*.mcap"))) > 1
    repair_bag(bag, tmp_path / "saved.mcap")
    stamps = stamps_of(tmp_path / "saved.mcap")
    assert stamps == [frame(number).stamp_ns for number in range(len(stamps))]
    assert len(stamps) >= 60 - 30  # those that waited for the writer are gone


def test_chunks_are_compressed_quickly(tmp_path):
    record = LiveRecord(tmp_path / "bag", "/image_raw", RecordForm())
    noisy = np.random.default_rng(0).normal(128.0, 3.0, (300, 400)).astype(np.uint8)
    record.write(CapturedFrame(noisy, START_NS), serialised(image(noisy, START_NS)))
    record.close()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as file:
        records = StreamReader(file, emit_chunks=True).records
        chunk = next(record for record in records if isinstance(record, Chunk))
    whole = zstandard.decompress(chunk.data)
    assert zlib.crc32(whole) == chunk.uncompressed_crc
    quickly = zstandard.ZstdCompressionParameters.from_level(1, min_match=6)
    assert chunk.data == zstandard.ZstdCompressor(compression_params=quickly).compress(whole)
    assert chunk.data != zstandard.compress(whole)  # as mcap's writer does by itself
