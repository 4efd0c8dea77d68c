"""A node finishes once, when it has all that was said to be sent, in whatever order that came."""

import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import convert, topics
from worm_msgs_py.errors import MalformedMessage
from worm_msgs_py.ros.stream_end import StreamEnd


def announcement(name, **sent):
    values = [KeyValue(key=topic, value=str(count)) for topic, count in sent.items()]
    return DiagnosticStatus(name=name, message="finished", values=values)


@given(st.integers(0, 20), st.data())
def test_it_finishes_once_with_the_last_of_the_frames_and_their_end(frames, data):
    finished = []
    stream = StreamEnd(lambda: finished.append(stream.taken))
    told_after = data.draw(st.integers(0, frames))
    for taken in range(frames + 1):
        if taken == told_after:
            assert not stream.done
            stream.on_end(convert.count_to_msg(frames))
        if taken < frames:
            assert not stream.done
            assert stream.missing.startswith(f"{taken} of ")
            stream.taken += 1
            stream.finish_if_whole()
    assert (finished, stream.done, stream.missing) == ([frames], True, "")
    stream.finish_if_whole()
    assert finished == [frames]


def test_an_end_before_what_has_come_and_an_end_after_the_end_are_not_ours():
    stream = StreamEnd(lambda: None)
    stream.taken = 3
    with pytest.raises(MalformedMessage):
        stream.on_end(convert.count_to_msg(2))
    assert stream.frames is None
    stream.on_end(convert.count_to_msg(3))
    assert stream.done
    with pytest.raises(MalformedMessage):
        stream.on_end(convert.count_to_msg(3))


@given(st.permutations(["analysis", "model", "tracker"]))
def test_each_node_that_is_waited_for_announces_itself_once(names):
    finished = []
    stream = StreamEnd(lambda: finished.append(1), lambda: not stream.silent, names)
    for k, name in enumerate(names):
        assert stream.silent == sorted(names[k:])
        assert not stream.done
        stream.on_announcement(announcement(name, **{topics.WORM_STATE: k}))
        with pytest.raises(MalformedMessage):
            stream.on_announcement(announcement(name))
    with pytest.raises(MalformedMessage):
        stream.on_announcement(announcement("stranger"))
    assert finished == [1]
    assert [said.sent for said in stream.announced.values()] == [
        {topics.WORM_STATE: k} for k in range(3)
    ]


def test_a_node_whose_last_step_fails_has_not_finished():
    def finish():
        raise OSError("the disk is full")

    stream = StreamEnd(finish)
    with pytest.raises(OSError, match="full"):
        stream.on_end(convert.count_to_msg(0))
    assert not stream.done
