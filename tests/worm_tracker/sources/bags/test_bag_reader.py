"""A bag is read whole and in order, or refused with one line that helps."""

import contextlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from picture_bags import (
    COMPRESSED,
    IMAGE,
    PERIOD_NS,
    START_NS,
    TYPESTORE,
    compressed,
    header,
    image,
    number_of,
    numbered_picture,
    serialised,
    stamps,
    storage_file,
    write_bag,
    write_messages,
)
from rosbags.rosbag2 import StoragePlugin

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.bag_repair import repair_bag
from worm_tracker.sources.bags.serialized_images import stamp_of, with_frame_id, with_stamp
from worm_tracker.sources.image_decoder import PictureDecoder


def read(path, topic=None, **kwargs):
    """Return [(stamp, picture)] of a bag."""
    decoder = PictureDecoder()
    with BagPictures(path, topic, **kwargs) as bag:
        return [
            (p.stamp_ns, decoder.decode(TYPESTORE.deserialize_cdr(p.raw, bag.message_type)))
            for p in bag
        ]


def refusal(path, topic=None, **kwargs):
    """Return the line with which a bag is refused before any picture is read."""
    with pytest.raises(BadInput) as caught, BagPictures(path, topic, **kwargs):
        pass
    line = str(caught.value)
    assert "\n" not in line
    assert str(path) in line
    return line


@pytest.mark.parametrize(
    ("storage", "zstd"),
    [
        pytest.param(StoragePlugin.MCAP, False, id="mcap"),
        pytest.param(StoragePlugin.MCAP, True, id="mcap, zstd chunks"),
        pytest.param(StoragePlugin.SQLITE3, False, id="db3"),
    ],
)
@pytest.mark.parametrize("alone", [False, True], ids=["directory", "file"])
@pytest.mark.parametrize("make", [image, compressed])
def test_every_picture_is_read_in_order(tmp_path, storage, zstd, alone, make):
    path = write_bag(tmp_path / "bag", make=make, storage=storage, compression=zstd)
    path = storage_file(path) if alone else path
    with BagPictures(path) as bag:
        assert (bag.topic, bag.count, bag.expected) == ("/image_raw", 20, 20)
        assert bag.message_type == (IMAGE if make is image else COMPRESSED)
        assert bag.duration_s == pytest.approx(19 * PERIOD_NS / 1e9)
    pictures = read(path)
    assert [stamp for stamp, _ in pictures] == stamps(20)
    for number, (_, picture) in enumerate(pictures):
        np.testing.assert_array_equal(picture, numbered_picture(number))


def test_pictures_recorded_out_of_order_are_put_right(tmp_path):
    order = [1, 0, 2, 5, 3, 4, 6, 7]
    messages = [
        ("/image_raw", START_NS + place, image(numbered_picture(n), stamps(8)[n]))
        for place, n in enumerate(order)
    ]
    pictures = read(write_messages(tmp_path / "bag", messages))
    assert [number_of(picture) for _, picture in pictures] == list(range(8))


def test_a_picture_without_a_stamp_takes_the_time_of_recording(tmp_path):
    messages = [("/image_raw", t, image(numbered_picture(i), 0)) for i, t in enumerate(stamps(3))]
    path = write_messages(tmp_path / "bag", messages)
    with BagPictures(path) as bag:
        for picture, expected in zip(bag, stamps(3), strict=True):
            message = TYPESTORE.deserialize_cdr(picture.raw, IMAGE)
            stamp = message.header.stamp
            assert picture.stamp_ns == stamp.sec * 10**9 + stamp.nanosec == expected


def test_a_part_is_what_was_recorded_in_it(tmp_path):
    path = write_bag(tmp_path / "bag")
    part = read(path, start_offset_s=0.2, playback_duration_s=0.25)
    assert [stamp for stamp, _ in part] == stamps(20)[4:9]
    with BagPictures(path, start_offset_s=0.5) as bag:
        assert bag.expected == pytest.approx(10, abs=1)


def test_other_topics_do_not_disturb(tmp_path):
    messages = [("/lamp", t, header(t)) for t in stamps(50, START_NS - 10**9, PERIOD_NS // 3)] + [
        ("/cam/image", t, image(numbered_picture(i), t)) for i, t in enumerate(stamps(5))
    ]
    path = write_messages(tmp_path / "bag", sorted(messages, key=lambda m: m[1]))
    assert [stamp for stamp, _ in read(path)] == stamps(5)
    assert [stamp for stamp, _ in read(path, "cam/image")] == stamps(5)


@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999), st.integers(0, 2**61))
def test_only_the_stamp_changes_when_it_is_set(seconds, nanoseconds, other_ns):
    stamp_ns = seconds * 10**9 + nanoseconds
    raw = bytes(TYPESTORE.serialize_cdr(image(numbered_picture(3), 77), IMAGE))
    restamped = with_stamp(raw, stamp_ns)
    assert stamp_of(restamped) == stamp_ns
    assert restamped[:4] == raw[:4]
    assert restamped[12:] == raw[12:]
    assert with_stamp(restamped, 77) == raw


# What is refused, and how.


def test_no_such_bag(tmp_path):
    assert "no such bag" in refusal(tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("notes.txt", "rosbag2 directory"),
        ("film.avi", "worm import"),
        ("old.bag", "rosbags-convert"),
        ("words.mcap", "not a bag"),
        ("words.db3", "not a bag"),
    ],
)
def test_not_a_bag(tmp_path, name, remedy):
    (tmp_path / name).write_text("These are words and not pictures.")
    assert remedy in refusal(tmp_path / name)


@pytest.mark.parametrize("name", ["nothing.mcap", "nothing.db3"])
def test_a_file_of_no_bytes(tmp_path, name):
    (tmp_path / name).touch()
    assert "0 bytes); copy it again" in refusal(tmp_path / name)


def test_a_directory_that_is_no_bag(tmp_path):
    assert "metadata.yaml" in refusal(tmp_path)


def test_a_directory_whose_recorder_was_killed(tmp_path):
    bag = write_bag(tmp_path / "bag")
    (bag / "metadata.yaml").unlink()
    assert f"`worm repair {bag}`" in refusal(bag)
    assert [stamp for stamp, _ in read(bag, salvage=True)] == stamps(20)


def test_a_metadata_file_of_something_else(tmp_path):
    (tmp_path / "metadata.yaml").write_text("name: holiday\n")
    assert "damaged" in refusal(tmp_path)


def test_no_topic_of_pictures(tmp_path):
    bag = write_messages(tmp_path / "bag", [("/lamp", t, header(t)) for t in stamps(3)])
    assert "/lamp (std_msgs/msg/Header)" in refusal(bag)


def test_several_topics_and_none_chosen(tmp_path):
    messages = [(f"/cam{k}", t, image(numbered_picture(k), t)) for k in (0, 1) for t in stamps(3)]
    bag = write_messages(tmp_path / "bag", messages)
    line = refusal(bag)
    assert "/cam0, /cam1" in line
    assert "--topic" in line
    assert number_of(read(bag, "/cam1")[0][1]) == 1


def test_a_topic_that_is_not_there(tmp_path):
    bag = write_bag(tmp_path / "bag")
    line = refusal(bag, "/camera")
    assert "/camera" in line
    assert "/image_raw" in line


def test_an_empty_bag(tmp_path):
    assert "no picture" in refusal(write_messages(tmp_path / "bag", [("/image_raw", 0, IMAGE)]))


def test_an_encoding_that_is_not_read(tmp_path):
    messages = [("/image_raw", 1, image(numbered_picture(0), 1, "bayer_rggb8"))]
    line = refusal(write_messages(tmp_path / "bag", messages))
    assert "bayer_rggb8" in line
    assert "/image_raw" in line


def test_nothing_left_after_the_offset(tmp_path):
    bag = write_bag(tmp_path / "bag")
    assert "--start-offset" in refusal(bag, start_offset_s=60.0)
    with pytest.raises(BadInput, match="--start-offset"):
        BagPictures(bag, start_offset_s=-1.0)
    with pytest.raises(BadInput, match="--playback-duration"):
        BagPictures(bag, playback_duration_s=0.0)


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize("alone", [False, True], ids=["directory", "file"])
def test_half_a_file_says_how_to_save_the_rest(tmp_path, storage, alone):
    bag = write_bag(tmp_path / "bag", storage=storage)
    file = storage_file(bag)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    line = refusal(file if alone else bag)
    assert "cut short" in line
    assert "`worm repair" in line


def test_what_cannot_be_repaired_leaves_no_file(tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n and no more")
    with pytest.raises(BadInput, match="nothing can be saved"):
        repair_bag(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert [file.name for file in tmp_path.iterdir()] == ["a.mcap"]


@given(cut=st.floats(0.0, 0.999))
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_a_cut_file_is_never_taken_for_a_whole_one(tmp_path_factory, storage, cut):
    path = tmp_path_factory.mktemp("cut") / "bag"
    file = storage_file(write_bag(path, count=6, storage=storage))
    file.write_bytes(file.read_bytes()[: int(cut * file.stat().st_size)])
    with pytest.raises(BadInput):
        read(file)


@given(place=st.floats(0.0, 1.0), byte=st.integers(1, 255))
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_damaged_bag_is_refused_or_gives_its_pictures(tmp_path_factory, place, byte):
    path = tmp_path_factory.mktemp("hurt") / "bag"
    file = storage_file(write_bag(path, count=6, compression=True))
    data = bytearray(file.read_bytes())
    data[int(place * (len(data) - 1))] ^= byte
    file.write_bytes(data)
    with contextlib.suppress(BadInput), BagPictures(file) as bag:
        assert sum(1 for _ in bag) == bag.count or bag.losses


@pytest.mark.parametrize("counted", [0, 19, 21, 10**9])
def test_all_pictures_are_read_whatever_the_index_counts(tmp_path, counted):
    bag = write_bag(tmp_path / "bag")
    meta = bag / "metadata.yaml"
    meta.write_text(meta.read_text().replace("message_count: 20", f"message_count: {counted}"))
    with BagPictures(bag) as pictures:
        assert [picture.stamp_ns for picture in pictures] == stamps(20)
        (said,) = pictures.losses
    assert said.why.startswith(f"the bag's index counts {counted} pictures")


@given(
    before=st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20),
    after=st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20),
    make=st.sampled_from([image, compressed]),
)
def test_another_frame_in_the_header_changes_nothing_else(before, after, make):
    message = make(numbered_picture(3), 123_456_789_012)
    message.header.frame_id = before
    renamed = with_frame_id(serialised(message), after)
    message.header.frame_id = after
    assert renamed == serialised(message)
