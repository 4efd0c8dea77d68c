"""Any picture of a bag is found by its stamp, whichever way the bag is stored, and quickly."""

import numpy as np
import pytest
from picture_bags import (
    IMAGE,
    PERIOD_NS,
    START_NS,
    compressed,
    image,
    number_of,
    numbered_picture,
    serialised,
    stamps,
)
from picture_bags import write_messages as write
from played_bags import write_raw_mcap
from rosbags.rosbag2 import StoragePlugin

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.one_picture import picture_at
from worm_tracker.sources.bags.scan import decompression, mcap_scan

COUNT = 400


def messages_of(kind, late_ns=0, count=COUNT):
    times = stamps(count)
    return [
        ("/image_raw", at + late_ns, kind(numbered_picture(number), at))
        for number, at in enumerate(times)
    ]


@pytest.fixture(
    scope="module",
    params=["mcap", "mcap of small chunks", "mcap without chunks", "db3", "late by a second"],
)
def bag(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "bag"
    if request.param == "db3":
        return write(path, messages_of(compressed), StoragePlugin.SQLITE3)
    if request.param == "mcap":
        return write(path, messages_of(image))
    if request.param == "late by a second":
        return write(path, messages_of(image, late_ns=10**9))
    chunk = 10_000 if "small" in request.param else 0
    raw = [(at, serialised(message)) for _, at, message in messages_of(image)]
    return write_raw_mcap(path.with_suffix(".mcap"), raw, IMAGE, chunk=chunk)


def test_any_picture_of_an_open_bag_is_found(bag):
    with BagPictures(bag) as pictures:
        for frame in (0, 1, 7, 8, 200, COUNT - 9, COUNT - 1):
            after_s = frame * PERIOD_NS / 1e9
            found = picture_at(pictures.part, START_NS + frame * PERIOD_NS, after_s)
            assert number_of(found) == frame


def test_a_picture_that_is_not_there_is_told(bag):
    with BagPictures(bag) as pictures, pytest.raises(BadInput, match="no picture of the bag"):
        picture_at(pictures.part, START_NS + 7, 0.0)


def test_a_part_of_an_open_bag_is_what_the_bag_gives_that_is_opened_for_it(bag):
    with BagPictures(bag) as pictures:
        for start_s, duration_s in ((0.0, None), (3.0, 2.0), (19.5, 5.0), (0.0, 1.0)):
            with BagPictures(
                bag, start_offset_s=start_s, playback_duration_s=duration_s
            ) as opened_for_it:
                assert list(pictures.part(start_s, duration_s)) == list(opened_for_it)
        assert list(pictures.part(1e6, 1.0)) == []


def test_only_what_is_near_a_picture_is_unpacked(tmp_path, monkeypatch):
    raw = [(at, serialised(message)) for _, at, message in messages_of(image)]
    bag = write_raw_mcap(tmp_path / "bag.mcap", raw, IMAGE, chunk=10_000)
    unpacked = []

    def counted(data, compression, limit):
        unpacked.append(len(data))
        return decompression.decompress(data, compression, limit)

    with BagPictures(bag) as pictures:
        monkeypatch.setattr(mcap_scan, "decompress", counted)
        picture_at(pictures.part, START_NS + 300 * PERIOD_NS, 300 * PERIOD_NS / 1e9)
    chunks = COUNT * np.mean([len(data) for _, data in raw]) / 10_000
    assert 0 < len(unpacked) < 0.1 * chunks
