"""A gap is an outage where it is longer than a stall or the camera was looked for, told once."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.sources.cameras import outages
from worm_tracker.sources.cameras.outages import LONGEST_PAUSE_S, Outage, OutageWatch

S_NS = 10**9


@given(st.lists(st.integers(1, 20 * S_NS), max_size=30))
def test_every_gap_longer_than_a_stall_is_an_outage_and_no_other(gaps_ns):
    watch = OutageWatch(reconnect_s=60.0, first_pause_s=0.5, stall_s=5.0, began_ns=0)
    stamps_ns = list(itertools.accumulate(gaps_ns, initial=0))
    for stamp_ns in stamps_ns[1:]:
        watch.frame_came(stamp_ns)
    assert watch.take_over() == [
        Outage(before, gap / S_NS, 0)
        for before, gap in zip(stamps_ns, gaps_ns, strict=False)
        if gap > 5 * S_NS
    ]
    assert watch.take_over() == []


def test_a_camera_that_stopped_was_out_however_soon_it_is_back():
    watch = OutageWatch(reconnect_s=60.0, first_pause_s=0.5, stall_s=math.inf, began_ns=7)
    assert watch.outage(8) is None
    watch.stop()
    watch.attempts += 2
    assert watch.outage(8) == Outage(7, 1 / S_NS, 2)
    watch.frame_came(9)
    assert watch.take_over() == [Outage(7, 2 / S_NS, 2)]
    assert watch.outage(10 * S_NS) is None
    assert watch.attempts == 0


def test_pauses_double_up_to_the_longest_and_never_outlast_the_search(monkeypatch):
    now_s = 100.0
    monkeypatch.setattr(outages.time, "monotonic", lambda: now_s)
    watch = OutageWatch(reconnect_s=20.0, first_pause_s=1.0, stall_s=5.0, began_ns=0)
    watch.stop()
    pauses_s = []
    while (pause_s := watch.pause_s()) is not None:
        pauses_s.append(pause_s)
        watch.attempts += 1
        now_s += pause_s
    assert pauses_s == [1.0, 2.0, 4.0, LONGEST_PAUSE_S, LONGEST_PAUSE_S, 3.0]
    assert sum(pauses_s) == pytest.approx(20.0)
