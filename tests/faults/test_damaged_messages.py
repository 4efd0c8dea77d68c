"""One bad message is one frame with the status `bad_image`, told with its number; never the end."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from picture_bags import (
    COMPRESSED,
    IMAGE,
    PERIOD_NS,
    START_NS,
    compressed,
    image,
    numbered_picture,
    serialised,
    stamps,
)
from played_bags import Played, write_raw_mcap
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage, Image

from worm_analysis.results.summary import TrialRecord, build_summary
from worm_msgs_py import SourceEvent, SourceEventKind
from worm_msgs_py.errors import BadInput, BadPicture
from worm_tracker.sources.bags.bad_messages import MOST_EVENTS, BadMessages
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.serialized_images import empty_picture, read_picture, stamp_of
from worm_tracker.sources.image_decoder import PictureDecoder
from worm_tracker.sources.jpeg_png import size_of_whole

SHAPE = (48, 64)


def raw(number, make=image, shape=SHAPE, **kwargs):
    return serialised(make(numbered_picture(number, shape), stamps(20)[number], **kwargs))


def half_file(number, kind):
    message = compressed(numbered_picture(number, SHAPE), stamps(20)[number], kind)
    message.data = message.data[: len(message.data) // 2]
    return serialised(message)


def bomb(number, kind):
    """A picture of 30000 × 30000 pixels by its header, of a few bytes."""
    message = compressed(np.zeros((16, 16), np.uint8), stamps(20)[number], kind)
    data = bytearray(message.data.tobytes())
    if kind == "png":
        data[16:24] = struct.pack(">II", 30_000, 30_000)
        data[29:33] = struct.pack(">I", zlib.crc32(bytes(data[12:29])))
    else:
        at = data.index(b"\xff\xc0")
        data[at + 5 : at + 9] = struct.pack(">HH", 30_000, 30_000)
    message.data = np.frombuffer(bytes(data), np.uint8)
    return serialised(message)


BAD = [
    pytest.param(IMAGE, lambda: raw(8)[: len(raw(8)) // 2], "ends in its data", id="cut in data"),
    pytest.param(IMAGE, lambda: raw(8)[:30], "ends in its frame_id", id="cut in its header"),
    pytest.param(IMAGE, lambda: b"", "empty", id="empty"),
    pytest.param(IMAGE, lambda: b"\x07" * 900, "not in CDR form", id="something else"),
    pytest.param(IMAGE, lambda: raw(8, encoding="bayer_rggb8"), "bayer_rggb8", id="encoding"),
    pytest.param(IMAGE, lambda: raw(8, encoding="mono16"), "needs 128 bytes", id="too few bytes"),
    pytest.param(IMAGE, lambda: raw(8, shape=(40, 30)), "30 × 40", id="another size"),
    pytest.param(COMPRESSED, lambda: half_file(8, "jpg"), "its end is missing", id="half a JPEG"),
    pytest.param(COMPRESSED, lambda: half_file(8, "png"), "its end is missing", id="half a PNG"),
    pytest.param(COMPRESSED, lambda: bomb(8, "png"), "max_megapixels", id="PNG bomb"),
    pytest.param(COMPRESSED, lambda: bomb(8, "jpg"), "max_megapixels", id="JPEG bomb"),
]


@pytest.mark.parametrize(("kind", "bad", "why"), BAD)
def test_one_bad_message_is_one_bad_frame(tmp_path, ros_context, run_graph, kind, bad, why):
    make = image if kind == IMAGE else compressed
    messages = [(t, bad() if k == 8 else raw(k, make)) for k, t in enumerate(stamps(20))]
    played = Played(run_graph, ros_context, write_raw_mcap(tmp_path / "a.mcap", messages, kind))
    assert [state.frame for state in played.states] == list(range(20))
    assert [state.stamp_ns for state in played.states] == stamps(20)
    assert played.bad_frames == [8]
    (event,) = played.events
    assert (event.kind, event.frame, event.count) == (SourceEventKind.BAD_MESSAGE, 8, 1)
    assert why in event.why


def test_a_resolution_that_changes_for_good_is_told_once_and_never_rescaled(
    tmp_path, ros_context, run_graph
):
    messages = [(t, raw(k, shape=SHAPE if k < 12 else (96, 128))) for k, t in enumerate(stamps(20))]
    played = Played(run_graph, ros_context, write_raw_mcap(tmp_path / "a.mcap", messages, IMAGE))
    assert played.bad_frames == list(range(12, 20))
    (event,) = played.events
    assert (event.frame, event.count) == (12, 8)
    assert "128 × 96" in event.why
    assert "not rescaled" in event.why


@pytest.mark.parametrize("bad", [[0], [0, 1, 2], [19], list(range(19))], ids=str)
def test_bad_messages_at_either_end_are_frames_too(tmp_path, ros_context, run_graph, bad):
    messages = [(t, b"" if k in bad else raw(k)) for k, t in enumerate(stamps(20))]
    played = Played(run_graph, ros_context, write_raw_mcap(tmp_path / "a.mcap", messages, IMAGE))
    assert played.bad_frames == bad
    assert sum(event.count for event in played.events) == len(bad)


def test_a_topic_of_which_no_message_can_be_read_is_refused_at_once(tmp_path):
    messages = [(t, raw(k, encoding="bayer_rggb8")) for k, t in enumerate(stamps(20))]
    with pytest.raises(BadInput, match=r"no message can be read.*bayer_rggb8"):
        BagPictures(write_raw_mcap(tmp_path / "a.mcap", messages, IMAGE))


@given(st.lists(st.sampled_from(["", "", "cut", "empty"]), max_size=400))
def test_every_bad_message_is_counted_whatever_their_number(whys):
    bad, events = BadMessages(), []
    for frame, why in enumerate(whys):
        events += bad.bad(frame, frame, why) if why else bad.good()
    events += bad.end()
    assert sum(event.count for event in events) == sum(why != "" for why in whys)
    assert len(events) <= MOST_EVENTS + 1
    assert [event.frame for event in events] == sorted(event.frame for event in events)


# The time of a picture.


def stamped(header_ns, logs=None):
    """Return the stamps with which pictures of these headers are played."""

    def play(folder: Path):
        messages = []
        for k, stamp_ns in enumerate(header_ns):
            data = bytearray(raw(k % 20))
            seconds, nanoseconds = divmod(stamp_ns, 10**9)
            data[4:12] = struct.pack("<iI", seconds, nanoseconds)
            messages.append(((logs or stamps(len(header_ns)))[k], bytes(data)))
        with BagPictures(write_raw_mcap(folder / "a.mcap", messages, IMAGE)) as bag:
            return [(p.stamp_ns, p.index, p.why_bad) for p in bag]

    return play


@pytest.mark.parametrize("wrong", [-(10**18), -1, 0, 5 * 10**18 // 4, 2**31 * 10**9 - 1])
@pytest.mark.parametrize("place", [0, 7, 19])
def test_a_stamp_that_cannot_be_right_gives_way_to_the_time_of_recording(tmp_path, wrong, place):
    header_ns = stamps(20)
    header_ns[place] = wrong
    played = stamped(header_ns)(tmp_path)
    assert played == [(t, k, "") for k, t in enumerate(stamps(20))]


def test_the_usual_delay_of_the_recording_is_kept(tmp_path):
    header_ns = [t - 123_456 for t in stamps(20)]
    expected = list(header_ns)
    header_ns[7] = 0
    assert [t for t, _, _ in stamped(header_ns)(tmp_path)] == expected


def test_a_clock_that_is_set_during_the_recording_is_believed(tmp_path):
    header_ns = stamps(10) + [t + 10**13 for t in stamps(20)[10:]]
    assert [t for t, _, _ in stamped(header_ns)(tmp_path)] == header_ns


@pytest.mark.parametrize("place", [0, 7, 19])
def test_a_time_of_recording_beyond_all_clocks_does_no_harm(tmp_path, place):
    logs = stamps(20)
    logs[place] = 2**63 + 5
    assert stamped(stamps(20), logs)(tmp_path) == [(t, k, "") for k, t in enumerate(stamps(20))]


def test_a_picture_without_any_time_is_a_bad_one_at_the_time_of_the_one_before(tmp_path):
    header_ns, logs = stamps(20), stamps(20)
    header_ns[7], logs[7] = -5, 2**64 - 1
    played = stamped(header_ns, logs)(tmp_path)
    assert played[7][0] == START_NS + 6 * PERIOD_NS
    assert [k for _, k, why in played if why] == [7]


# What the decoder and the parser make of bytes.


@given(st.data())
def test_a_picture_file_that_is_cut_is_never_taken_for_a_whole_one(data):
    kind = data.draw(st.sampled_from([".jpg", ".png"]))
    whole = cv2.imencode(kind, numbered_picture(1, (20, 30)))[1].tobytes()
    assert size_of_whole(whole) == (30, 20)
    with pytest.raises(BadPicture):
        size_of_whole(whole[: data.draw(st.integers(0, len(whole) - 1))])


@given(st.binary(max_size=200))
def test_any_bytes_are_a_picture_or_not(data):
    for kind in (IMAGE, COMPRESSED):
        try:
            fields = read_picture(data, kind)
            PictureDecoder().decode(fields)
        except (ValueError, BadPicture, BadInput):
            pass


@given(st.integers(0, 2**31 * 10**9 - 1))
def test_what_stands_for_a_bad_message_can_be_read_by_everyone(stamp_ns):
    for kind, message in ((IMAGE, Image), (COMPRESSED, CompressedImage)):
        stand_in = empty_picture(stamp_ns, kind)
        assert stamp_of(stand_in) == stamp_ns
        assert len(read_picture(stand_in, kind).data) == 0
        assert len(deserialize_message(stand_in, message).data) == 0


def test_a_recording_may_begin_at_zero(tmp_path):
    from_zero = [k * PERIOD_NS for k in range(20)]
    played = stamped(from_zero, from_zero)(tmp_path)
    assert played == [(t, k, "") for k, t in enumerate(from_zero)]


def test_the_summary_lists_events_alike_whichever_node_was_heard_first():
    events = [
        SourceEvent(kind, frame, frame, why, count=1)
        for frame in (3, 9)
        for kind, why in ((SourceEventKind.LOST, "a chunk"), (SourceEventKind.BAD_MESSAGE, "cut"))
    ]
    one, other = (
        build_summary(TrialRecord(source_events=order), {})["source_events"]
        for order in (events, events[::-1])
    )
    assert one == other
    assert [entry["frame"] for entry in one] == [3, 3, 9, 9]
