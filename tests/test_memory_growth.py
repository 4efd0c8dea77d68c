"""Growth of memory over a run: what row groups take and give back is none, a slow rise is."""

import pytest
from benchmarks.memory import MemoryTrace
from hypothesis import given
from hypothesis import strategies as st

ROW_GROUP = 2048
MIB = 250.0
frame_counts, rates = st.integers(12_000, 54_000), st.integers(20, 80)


def trace_of(frames, frames_per_s, growth=0.0, tooth_mib=0.0, phase=0):
    """Return a trace of a run: a tooth for each row group, on a level that rises by `growth`."""
    trace = MemoryTrace()
    for second in range(frames // frames_per_s):
        trace.progress(sent := second * frames_per_s)
        tooth = tooth_mib * ((sent + phase) % ROW_GROUP) / ROW_GROUP
        trace.sample(second, MIB * (1.0 + growth * sent / frames) + tooth)
    return trace


@given(frame_counts, rates, st.floats(0.0, 20.0), st.integers(0, ROW_GROUP))
def test_what_row_groups_take_and_give_back_is_no_growth(frames, rate, tooth_mib, phase):
    growth = trace_of(frames, rate, tooth_mib=tooth_mib, phase=phase).growth()
    assert abs(growth) < 0.005


@given(frame_counts, rates, st.floats(-0.2, 0.2))
def test_a_slow_rise_is_growth(frames, rate, growth):
    after = frames - 60 * rate
    apart = after - max(1, after // 10 // ROW_GROUP) * ROW_GROUP
    start = 1.0 + growth * (frames - after) / frames
    measured = trace_of(frames, rate, growth).growth()
    assert measured == pytest.approx(growth * apart / frames / start, rel=0.15)


def test_the_report_after_the_last_frame_is_no_growth():
    trace = trace_of(20_000, 50)
    for second in range(400, 440):
        trace.sample(second, 2 * MIB)
    assert abs(trace.growth()) < 0.01


def test_a_run_without_two_row_groups_after_its_first_minute_has_no_growth_to_tell():
    with pytest.raises(ValueError, match="4096 are needed"):
        trace_of(6_000, 50).growth()
