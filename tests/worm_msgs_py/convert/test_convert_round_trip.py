"""What goes through a message comes back to the last bit, over the wire, with NaN and empty."""

import math
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rclpy.serialization import deserialize_message, serialize_message

from worm_msgs_py import (
    Attempt,
    BodyState,
    Chamber,
    Comparison,
    Correlation,
    Distribution,
    Episode,
    EpisodeKind,
    Forecast,
    Geometry,
    Keypoint,
    Midline,
    ModelQuantity,
    NeededReversal,
    Observables,
    Quantity,
    Status,
    StrokePhase,
    Visit,
    Where,
)
from worm_msgs_py import convert as c

reals = st.floats(allow_nan=True, allow_infinity=True, width=64)
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
stamps = st.integers(0, (2**31 - 1) * 10**9)
counts = st.integers(0, 2**53)
names = st.text("abcdefghijklmnopqrstuvwxyz_", min_size=1, max_size=12)
texts = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=40)

keypoints = st.builds(Keypoint, reals, reals, reals, reals, reals)
states = st.builds(
    BodyState,
    frame=counts,
    stamp_ns=stamps,
    frame_id=st.sampled_from(["chamber_a", "chamber_b", "camera_optical_frame"]),
    where=st.sampled_from(Where),
    status=st.sampled_from(Status),
    geometry=counts,
    confidence=reals,
    head_certainty=reals,
    head=keypoints,
    centroid=keypoints,
    tail=keypoints,
    length_px=reals,
    width_px=reals,
    length_m=reals,
    width_m=reals,
    head_sd_m=reals,
)
chambers = st.builds(Chamber, st.just("chamber_a"), *[finite] * 4, st.floats(1e-3, 1), *[reals] * 5)
geometries = st.builds(
    Geometry,
    version=counts,
    stamp_ns=stamps,
    picture_width_px=counts,
    picture_height_px=counts,
    chambers=st.one_of(
        st.just(()),
        st.tuples(chambers),
        st.tuples(chambers, st.builds(Chamber, st.just("chamber_b"), *[st.floats(1, 9)] * 5)),
    ),
    depth_m=reals,
    passage_length_m=reals,
)
observables = st.builds(
    Observables,
    frame=counts,
    stamp_ns=stamps,
    where=st.sampled_from(Where),
    contact=st.sampled_from([None, True, False]),
    **{f.name: reals for f in fields(Observables) if f.type is float or f.type == "float"},
)
quantities = st.builds(
    Quantity,
    name=names,
    value=st.none() | reals,
    low=st.none() | reals,
    high=st.none() | reals,
    n=counts,
    unit=texts,
    paper=st.none() | reals,
    why=texts,
)
episodes = st.builds(
    Episode, names, st.sampled_from(EpisodeKind), stamps, stamps, reals, reals, reals, st.booleans()
)
visits = st.builds(
    Visit, names, stamps, stamps, st.none() | stamps, reals, reals, counts, st.booleans()
)
attempts = st.builds(
    Attempt,
    names,
    stamps,
    stamps,
    reals,
    st.booleans(),
    st.none() | st.booleans(),
    st.sampled_from(StrokePhase),
    st.booleans(),
)
comparisons = st.builds(
    Comparison,
    stamps,
    st.lists(st.tuples(names, reals), unique_by=lambda p: p[0]).map(tuple),
    st.lists(
        st.builds(ModelQuantity, names, st.sampled_from(["s", "m", "1", "m/s"]), *[reals] * 6),
        unique_by=lambda q: q.name,
        max_size=4,
    ).map(tuple),
    st.lists(
        st.builds(
            NeededReversal,
            st.sampled_from(["per_cycle", "rate"]),
            st.sampled_from(["v_w", "v_b"]),
            names,
            *[reals] * 3,
            st.booleans(),
        ),
        unique_by=lambda n: (n.rule, n.speed, n.observation),
        max_size=4,
    ).map(tuple),
    st.lists(st.tuples(names, reals), unique_by=lambda p: p[0], max_size=3).map(tuple),
)
forecasts = st.builds(
    Forecast,
    frame=counts,
    stamp_ns=stamps,
    where=st.sampled_from(Where),
    measured=st.lists(st.tuples(names, st.booleans()), unique_by=lambda p: p[0]).map(tuple),
    **{f.name: reals for f in fields(Forecast) if f.type is float or f.type == "float"},
)


def same(a, b):
    """Equality in which NaN equals NaN, through dataclasses, tuples and arrays."""
    if is_dataclass(a):
        return type(a) is type(b) and all(
            same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a)
        )
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, float):
        return isinstance(b, float) and (a == b or (math.isnan(a) and math.isnan(b)))
    return type(a) is type(b) and a == b


def over_the_wire(msg):
    return deserialize_message(serialize_message(msg), type(msg))


@given(states)
def test_body_state_survives_the_wire(state):
    assert same(c.body_state_from_msg(over_the_wire(c.body_state_to_msg(state))), state)


@given(states)
def test_a_tracker_need_not_say_how_sure_the_place_of_the_head_is(state):
    msg = c.body_state_to_msg(state)
    at = list(msg.name).index("head_sd_m")
    msg.name, msg.position = (
        [*values[:at], *values[at + 1 :]] for values in (msg.name, msg.position)
    )
    assert same(c.body_state_from_msg(over_the_wire(msg)), replace(state, head_sd_m=0.0))


@given(geometries)
def test_geometry_survives_the_wire(geometry):
    assert same(c.geometry_from_msg(over_the_wire(c.geometry_to_msg(geometry))), geometry)


@given(observables)
def test_observables_survive_the_wire(value):
    assert same(c.observables_from_msg(over_the_wire(c.observables_to_msg(value))), value)


@given(st.lists(quantities, max_size=5), stamps)
def test_quantities_survive_the_wire(values, stamp_ns):
    back = c.quantities_from_msg(over_the_wire(c.quantities_to_msg(values, stamp_ns)))
    assert same(back, tuple(values))


@given(st.lists(episodes | visits | attempts, max_size=5), stamps)
def test_events_survive_the_wire(events, stamp_ns):
    assert same(c.events_from_msg(over_the_wire(c.events_to_msg(events, stamp_ns))), tuple(events))


@given(comparisons)
def test_comparison_survives_the_wire(comparison):
    assert same(c.comparison_from_msg(over_the_wire(c.comparison_to_msg(comparison))), comparison)


@given(forecasts)
def test_forecast_survives_the_wire(forecast):
    assert same(c.forecast_from_msg(over_the_wire(c.forecast_to_msg(forecast))), forecast)


@given(observables, st.tuples(counts, counts))
def test_what_was_sent_before_observables_survives_the_wire(value, before):
    msg = over_the_wire(c.observables_to_msg(value, before))
    assert c.before_from_msg(msg) == before
    assert same(c.observables_from_msg(msg), value)


@given(st.integers(0, 20), st.data())
def test_correlation_survives_the_wire(n, data):
    lag_ns = np.array(sorted(data.draw(st.sets(st.integers(0, 2**40), min_size=n, max_size=n))))
    curve = arrays(np.float64, n, elements=reals)
    correlation = Correlation(
        lag_s=lag_ns.astype(np.float64) / 1e9,
        c=data.draw(curve),
        error=data.draw(curve),
        pairs=data.draw(arrays(np.int64, n, elements=st.integers(0, 2**53))),
        model=data.draw(curve),
    )
    back = c.correlation_from_msg(over_the_wire(c.correlation_to_msg(correlation, 5)))
    assert np.allclose(back.lag_s, correlation.lag_s, rtol=0, atol=1e-9)
    for name in ("c", "error", "pairs", "model"):
        assert same(getattr(back, name), getattr(correlation, name))


@given(st.integers(1, 20), names, st.sampled_from(["m", "rad"]), st.data())
def test_distribution_survives_the_wire(n, name, unit, data):
    edges = np.array(sorted(data.draw(st.sets(finite, min_size=n + 1, max_size=n + 1))))
    table = data.draw(arrays(np.int64, n, elements=st.integers(0, 2**53)))
    distribution = Distribution(name, unit, edges, table)
    assert same(
        c.distribution_from_msg(over_the_wire(c.distribution_to_msg(distribution))), distribution
    )


@given(st.integers(0, 64), st.data())
def test_midline_survives_the_wire_to_single_precision(n, data):
    column = arrays(np.float64, n, elements=st.floats(width=32))
    midline = Midline(*(data.draw(column) for _ in range(6)))
    state = BodyState(frame=0, stamp_ns=0, length_px=800.0, length_m=0.02)
    assert same(c.midline_from_msg(over_the_wire(c.midline_to_msg(midline, state))), midline)


def test_midline_carries_metres_for_viewers():
    n = 5
    line = np.linspace(0.0, 800.0, n)
    midline = Midline(line, line, line / 4e4, line / 4e4, line, np.full(n, 16.0))
    state = BodyState(frame=0, stamp_ns=0, length_px=800.0, length_m=0.02)
    msg = c.midline_to_msg(midline, state)
    floats = np.frombuffer(msg.data, "<f4").reshape(n, -1)
    by_name = {field.name: floats[:, i] for i, field in enumerate(msg.fields)}
    assert by_name["s"][-1] == pytest.approx(0.02)
    assert by_name["width"] == pytest.approx(np.full(n, 16.0 / 4e4))
    assert not by_name["z"].any()


@given(stamps)
def test_stamp_survives(stamp_ns):
    assert c.stamp_to_ns(over_the_wire(c.stamp_to_msg(stamp_ns))) == stamp_ns


@given(st.lists(st.integers(0, 2**63), max_size=4))
def test_counters_survive(values):
    assert c.counts_from_msg(over_the_wire(c.counts_to_msg(values))) == tuple(values)
    for value in values:
        assert c.count_from_msg(over_the_wire(c.count_to_msg(value))) == value


@given(finite, finite, st.floats(-math.pi, math.pi))
def test_pose_carries_position_and_heading(x, y, yaw):
    point = Keypoint(x_m=x, y_m=y, yaw_rad=yaw)
    state = BodyState(frame=0, stamp_ns=1, frame_id="chamber_a")
    pose = over_the_wire(c.keypoint_to_pose(state, point))
    assert (pose.pose.position.x, pose.pose.position.y) == (x, y)
    q = pose.pose.orientation
    assert 2 * math.atan2(q.z, q.w) == pytest.approx(yaw, abs=1e-12)
    assert pose.header.frame_id == "chamber_a"


def test_picture_survives_the_wire():
    picture = np.arange(12, dtype=np.uint8).reshape(3, 4)
    msg = over_the_wire(c.picture_to_msg(picture, 123_000_000_456))
    assert (msg.encoding, msg.height, msg.width, msg.step) == ("mono8", 3, 4, 4)
    assert np.array_equal(np.frombuffer(msg.data, np.uint8).reshape(3, 4), picture)
    assert c.stamp_to_ns(msg.header.stamp) == 123_000_000_456


def test_markers_leave_the_exit_open_and_draw_the_wall_in_metres():
    chamber = Chamber("chamber_a", 512, 512, 400, 0.3, 0.01, exit_width_m=2e-3)
    (marker,) = c.geometry_to_markers(Geometry(1, 0, 1024, 1024, (chamber,))).markers
    points = np.array([(p.x, p.y) for p in marker.points])
    assert np.hypot(*points.T) == pytest.approx(0.01)
    assert abs(points[0, 1] - points[-1, 1]) == pytest.approx(2e-3)
    assert marker.header.frame_id == "chamber_a"


@given(st.integers(1, 5), st.integers(1, 7), st.text("abc_.", min_size=1), st.data())
def test_sums_survive_the_wire(blocks, columns, name, data):
    sums = np.array(
        data.draw(st.lists(finite, min_size=blocks * columns, max_size=blocks * columns))
    )
    back, rows = c.sums_from_msg(over_the_wire(c.sums_to_msg(name, sums.reshape(blocks, columns))))
    assert back == name
    np.testing.assert_array_equal(rows, sums.reshape(blocks, columns))
