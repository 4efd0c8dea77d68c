"""The newest frame that is whole is given once, whatever comes late or never."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from picture_bags import header, serialised

from worm_bringup.overlay.latest_frames import LatestFrames

PARTS = ("state", "midline", "picture")


def part(stamp):
    return serialised(header(stamp * 10**9))


def test_a_frame_is_whole_with_its_last_part_and_given_once():
    frames = LatestFrames(PARTS)
    assert [frames.add(name, part(1)) for name in PARTS] == [False, False, True]
    stamp_ns, parts = frames.take()
    assert (stamp_ns, set(parts)) == (10**9, set(PARTS))
    assert frames.take() is None


def test_of_a_burst_the_newest_is_shown():
    frames = LatestFrames(PARTS)
    for stamp in range(1, 9):
        for name in PARTS:
            frames.add(name, part(stamp))
    assert frames.take()[0] == 8 * 10**9


@given(st.lists(st.tuples(st.integers(1, 400), st.sampled_from(PARTS)), max_size=200))
def test_parts_of_one_frame_alone_are_put_together_and_little_is_kept(messages):
    frames = LatestFrames(PARTS)
    for stamp, name in messages:
        frames.add(name, part(stamp))
        assert len(frames._waiting) <= 17
        taken = frames.take()
        if taken is not None:
            assert taken[0] == stamp * 10**9
            assert all(data == part(stamp) for data in taken[1].values())


def test_a_picture_whose_state_comes_much_later_is_gone():
    frames = LatestFrames(PARTS)
    for stamp in range(1, 40):
        frames.add("picture", part(stamp))
    for name in ("state", "midline"):
        assert not frames.add(name, part(1))


def test_a_message_without_a_header_is_refused():
    with pytest.raises(ValueError, match="no header"):
        LatestFrames(PARTS).add("state", b"\0\1")
