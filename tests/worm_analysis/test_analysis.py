"""What must hold for a worm whose motion is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from analysed_states import CLOSED, analyse, by_name
from walked_tracks import (
    GEOMETRY,
    THRESHOLD,
    R,
    mirrored,
    rough_track,
    slides_and_hops,
    track_from_polar,
)

from worm_analysis.accumulators.direction_correlation import SignCorrelation, lag_grid
from worm_analysis.accumulators.settings import SearchSettings
from worm_analysis.analysis import Analysis, AnalysisSettings
from worm_analysis.events.contact_state import ContactStateSettings
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.statistics.block_jackknife import Units
from worm_analysis.summary.direction_persistence import correlation as correlation_with_error
from worm_analysis.summary.direction_persistence import correlation_curve, persistence_time
from worm_analysis.summary.settings import EstimateSettings
from worm_msgs_py import (
    BodyState,
    Episode,
    Geometry,
    Midline,
    Status,
    TrackedFrame,
    Where,
)

NS = 10**9


def test_the_trackers_frames_bring_their_geometry():
    states = slides_and_hops(3, 120.0, 20.0).states()
    later = replace(GEOMETRY, version=2, stamp_ns=states[len(states) // 2].stamp_ns)
    versions = [1 if state.stamp_ns < later.stamp_ns else 2 for state in states]
    states = [replace(s, geometry=v) for s, v in zip(states, versions, strict=True)]
    told, brought = Analysis(), Analysis()
    told.set_geometry(GEOMETRY)
    told.set_geometry(later)
    rigs = {1: GEOMETRY, 2: later}
    for state in states:
        frame = TrackedFrame(state, Midline.empty(), rigs[state.geometry])
        assert repr(brought.push(frame)) == repr(told.push(state))
    assert repr(brought.finish()) == repr(told.finish())
    assert repr(brought.summary()) == repr(told.summary())


def test_a_state_alone_without_its_geometry_is_refused():
    state = circling(2e-3, duration_s=1.0).states()[0]
    with pytest.raises(ValueError, match="set_geometry"):
        Analysis().push(state)
    with pytest.raises(ValueError, match="set_geometry"):
        Analysis().push(TrackedFrame(state, Midline.empty()))


def circling(speed, duration_s=200.0, rate_hz=20, psi_b=0.5):
    t = np.arange(0, duration_s, 1 / rate_hz)
    r = np.full(len(t), R - THRESHOLD / 3)
    return track_from_polar(t, r, 1.0 + speed / R * t, np.full(len(t), psi_b))


@pytest.mark.parametrize("speed", [2e-3, -1e-3])
def test_a_worm_that_circles_at_constant_speed(speed):
    psi_b = np.copysign(0.5, speed)
    analysis, rows, events = analyse(circling(speed, psi_b=psi_b).states(), CLOSED)
    late = rows[20:]
    np.testing.assert_allclose([row.theta_dot_rad_s for row in late], speed / R, rtol=1e-9)
    np.testing.assert_allclose([row.v_b_m_s for row in late], speed, rtol=1e-9)
    np.testing.assert_allclose([row.psi_b_rad for row in rows], psi_b, atol=1e-12)
    assert all(row.contact for row in rows)
    assert np.isnan([row.theta_dot_rad_s for row in rows[:20]]).all()
    c = analysis.correlation()
    np.testing.assert_array_equal(c.c, 1.0)
    found = by_name(analysis)
    assert found["v_w"].value == pytest.approx(abs(speed) / np.sin(0.5) * 1e3)
    assert found["v_b"].value == pytest.approx(abs(speed) * 1e3)
    assert found["contact_fraction"].value == 1.0
    assert found["reversal_rate"].value == 0.0
    directed_s = analysis.sums()["reversal_rate"].sum(axis=0)[0]
    assert directed_s == pytest.approx(198.95), "200 s, without 1 s before the first direction"
    assert found["t_per"].value is None
    assert "does not decay" in found["t_per"].why
    assert [type(event) for event in events].count(Episode) == 1
    assert not events[0].complete


def test_theta_h_is_unwrapped_over_many_turns():
    _, rows, _ = analyse(circling(2e-3).states())
    np.testing.assert_allclose(
        [row.theta_h_rad for row in rows], 1.0 + 0.2 * np.arange(0, 200, 0.05), atol=1e-9
    )


def test_a_body_that_trails_a_counter_clockwise_head_has_positive_psi_b():
    """docs/science.md: psi_b > 0 <=> counter-clockwise, whatever the paper's text says."""
    t = np.arange(0, 150, 0.05)
    for turn in (0.2, -0.2):
        r = np.full(len(t), R - THRESHOLD / 3)
        head = track_from_polar(t, r, turn * t, np.zeros(len(t)))
        trailing = turn * (t - 3.0)
        head.centroid[:] = 0.6 * R * np.stack([np.cos(trailing), np.sin(trailing)], axis=1)
        analysis, rows, _ = analyse(head.states())
        assert all(np.sign(row.psi_b_rad) == np.sign(turn) for row in rows)
        assert all(np.sign(row.theta_dot_rad_s) == np.sign(turn) for row in rows[20:])
        found = by_name(analysis)
        assert found["v_w"].value > 0
        assert np.sign(found["v_b_mean"].value) == np.sign(found["psi_b_mean"].value)
        assert np.sign(found["v_b_mean"].value) == np.sign(turn)


def test_a_worm_that_turns_round_within_a_window_has_the_same_v_w():
    """The sine of a mean over a turn is not the mean of the sines: v_w would be 10 % off here."""
    t = np.arange(0, 400, 0.05)
    heading = np.where(t % 23.4 < 11.7, 1.0, -1.0)
    theta = np.cumsum(heading) * 0.05 * 0.2
    track = track_from_polar(t, np.full(len(t), R - THRESHOLD / 3), theta, 1.0 * heading)
    v_w = by_name(analyse(track.states())[0])["v_w"]
    assert v_w.value == pytest.approx(2.0 / np.sin(1.0), rel=0.01)


def test_a_worm_that_turns_round_has_a_speed_that_goes_with_its_body_angle():
    """psi_b > 0 <=> counter-clockwise: theta_dot grows with psi_b, and not with the incidence."""
    analysis, _, events = analyse(slides_and_hops(2, 900.0, 20.0).states())
    found = by_name(analysis)
    body = found["theta_dot_psi_b_correlation"]
    assert 0.8 < body.low < body.value < body.high <= 1
    incidence = found["theta_dot_incidence_correlation"]
    contacts = [e for e in events if isinstance(e, Episode) and np.isfinite(e.incidence_rad)]
    assert 0.8 * len(contacts) < incidence.n <= len(contacts)
    # Here the head does come to the wall in the direction in which it moves on.
    assert incidence.low > 0


def test_a_mirrored_track_flips_the_signs_of_angles_and_nothing_else():
    states = [state for seed in range(3, 9) for state in rough_track(seed).states()]
    states = [
        replace(state, frame=frame, stamp_ns=state.stamp_ns + frame // 500 * 100 * NS)
        for frame, state in enumerate(states)
    ]
    plain, rows, events = analyse(states)
    flipped, other_rows, other_events = analyse([mirrored(state) for state in states])
    for row, other in zip(rows, other_rows, strict=True):
        for name in ("theta_h_rad", "theta_dot_rad_s", "v_b_m_s", "psi_b_rad", "psi_h_rad"):
            assert getattr(other, name) == pytest.approx(-getattr(row, name), abs=1e-9, nan_ok=True)
        assert (other.r_h_m, other.r_c_m, other.r_t_m) == pytest.approx(
            (row.r_h_m, row.r_c_m, row.r_t_m), nan_ok=True
        )
        assert (other.contact, other.where) == (row.contact, row.where)
    assert len(events) == len(other_events)
    for event, other in zip(events, other_events, strict=True):
        if isinstance(event, Episode):
            assert other.distance_m == pytest.approx(event.distance_m, abs=1e-12)
            assert other.incidence_rad == pytest.approx(-event.incidence_rad, nan_ok=True)
    np.testing.assert_array_equal(plain.correlation().c, flipped.correlation().c)
    same, mirror = by_name(plain), by_name(flipped)
    turned = {"v_b_mean": "v_b_mean", "psi_b_mean": "psi_b_mean"}
    turned |= {"psi_b_negative_peak": "psi_b_positive_peak"}
    turned |= {"psi_b_q10": "psi_b_q90", "psi_b_q50": "psi_b_q50"}
    turned |= {other: name for name, other in turned.items()}
    told = 0
    for name, quantity in same.items():
        other, sign = mirror[turned.get(name, name)], -1 if name in turned else 1
        assert other.n == quantity.n, name
        assert (other.value is None) == (quantity.value is None), name
        if quantity.value is not None:
            assert other.value == pytest.approx(sign * quantity.value, rel=1e-6, abs=1e-9), name
            told += 1
    assert told > 30, "most of the numbers can be had here"


def test_the_correlation_of_a_telegraph_process_is_exponential():
    rate, step_s, n = 0.5, 0.1, 400_000
    rng = np.random.default_rng(1)
    flips = rng.random(n) < 0.5 * (1 - np.exp(-2 * rate * step_s))
    signs = np.where(np.cumsum(flips) % 2, -1.0, 1.0)
    correlation = SignCorrelation(lag_grid(10, 10, step_s, 1.0), step_s)
    correlation.add(np.arange(n) * (NS // 10), signs)
    units = Units([correlation.sums()["c_theta"]])
    value, low, high = persistence_time(units, correlation.lag_s)
    result = correlation_with_error(units, correlation.lag_s, value)
    truth = np.exp(-2 * rate * result.lag_s)
    np.testing.assert_allclose(result.c, truth, atol=0.02)
    assert np.mean(np.abs(result.c - truth) < 2 * result.error) > 0.8
    assert value == pytest.approx(1 / (2 * rate), rel=0.02)
    assert low < 1 / (2 * rate) < high


def test_pairs_are_not_made_over_a_break():
    correlation = SignCorrelation(np.arange(21), 0.1)
    cells = np.arange(10) * (NS // 10)
    correlation.add(cells, np.ones(10))
    correlation.break_off()
    correlation.add(cells + NS, -np.ones(10))
    c, pairs = correlation_curve(Units([correlation.sums()["c_theta"]]))
    np.testing.assert_array_equal(pairs, [max(0, 2 * (10 - lag)) for lag in range(21)])
    np.testing.assert_array_equal(c[:10], 1.0)


def test_a_trial_that_is_too_short_says_so():
    analysis, _, _ = analyse(slides_and_hops(0, 5.0, 25.0).states())
    found = by_name(analysis)
    assert found["d_c"].value is None
    assert found["d_c"].why.startswith("not enough data: ")
    assert found["t_per"].value is None
    assert found["t_per"].paper == 27.0


@pytest.mark.parametrize("geometry", [None, Geometry(1, 0, 255, 221)])
def test_without_a_chamber_everything_is_null_with_a_reason(geometry):
    states = [
        BodyState(frame, frame * NS // 30, status=Status.TRACKED, geometry=1 if geometry else 0)
        for frame in range(100)
    ]
    analysis, rows, events = analyse(states, geometry)
    assert events == []
    assert [row.frame for row in rows] == list(range(100))
    assert all(row.contact is None and np.isnan(row.r_h_m) for row in rows)
    found = by_name(analysis)
    for name in ("frames_untracked", "frames_uncertain"):
        assert found.pop(name).n == 100, "frames can be counted all the same"
    assert all(quantity.value is None and quantity.why for quantity in found.values())
    assert found["d_c"].why == "no chamber in the picture"
    assert (analysis.correlation().pairs == 0).all()


def test_a_frame_without_a_head_keeps_the_turns_and_bridges_a_short_gap():
    states = circling(2e-3, 60.0).states()
    lost = [
        replace(state, head=type(state.head)(), status=Status.COILED)
        if state.frame % 7 < 3
        else state
        for state in states
    ]
    _, rows, events = analyse(lost, CLOSED)
    _, whole, _ = analyse(states, CLOSED)
    for row, full in zip(rows, whole, strict=True):
        if row.frame % 7 < 3:
            assert np.isnan(row.theta_h_rad)
            assert row.contact is None
            assert row.r_c_m == full.r_c_m
        else:
            assert row.theta_h_rad == pytest.approx(full.theta_h_rad, abs=1e-12)
    assert sum(isinstance(event, Episode) for event in events) == 1


def test_a_stamp_that_does_not_advance_adds_to_no_estimate():
    states = slides_and_hops(1, 60.0, 25.0).states()
    doubled = [state for state in states for _ in range(2)]
    once, twice = by_name(analyse(states)[0]), by_name(analyse(doubled)[0])
    for name in once.keys() - {"frames_untracked", "frames_uncertain"}:
        assert repr(once[name]) == repr(twice[name])


def test_a_head_whose_place_is_not_known_is_not_searching():
    states = [
        replace(state, where=Where.UNKNOWN) for state in slides_and_hops(1, 60.0, 25.0).states()
    ]
    analysis, rows, events = analyse(states)
    assert events == []
    assert all(np.isfinite(row.r_h_m) and row.contact is None for row in rows)
    assert by_name(analysis)["d_c"].n == 0


def test_a_state_on_a_geometry_that_was_not_given_is_an_error():
    with pytest.raises(ValueError, match="frame 0 rests on geometry 1"):
        analyse(circling(2e-3, 1.0).states(), geometry=None)


def test_hysteresis_and_a_shortest_episode_swallow_a_flicker():
    """Of the rules with a threshold; and that of the smoother, where nobody knows of noise."""
    t = np.arange(0, 10, 0.05)
    depth = np.where(np.arange(len(t)) % 10 == 9, 1.3, 0.5) * THRESHOLD
    track = track_from_polar(t, R - depth, 0.2 * t, np.full(len(t), 0.5))
    analysis, _, _ = analyse(track.states(), CLOSED)
    contacts = {name: sums[0, 2] for name, sums in analysis.sums().items() if "d_c_at_" in name}
    assert contacts["d_c_at_contact_factor_0.3"] == 19, "the first began before the film"
    assert contacts["d_c_at_release_factor_0.6"] == 0
    assert contacts["d_c_at_min_episode_s_0.1"] == 0
    calm = AnalysisParameters(min_episode_s=0.08)
    _, _, events = analyse(track.states(), CLOSED, calm)
    assert sum(isinstance(event, Episode) for event in events) == 1


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"max_gap_s": 0.0}, "max_gap_s is 0: give 0.001"),
        ({"contact_factor": float("nan")}, "contact_factor is nan"),
        ({"body_width_m": 0.4}, "if that is in mm, give 0.0004"),
        ({"release_factor": 0.2}, "below contact_factor"),
        ({"coarse_step_s": 0.25}, "multiple"),
        ({"minimum_n": 0}, "minimum_n"),
    ],
)
def test_a_parameter_out_of_range_is_named(setting, message):
    with pytest.raises(ValueError, match=message):
        AnalysisParameters(**setting)


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("d_c", AnalysisSettings(SearchSettings(contact=ContactStateSettings(first_fit_s=1e3)))),
        ("d_c_exponential_p", AnalysisSettings(SearchSettings(steps_in_limit=50.0))),
        ("v_w", AnalysisSettings(SearchSettings(least_window_seen=2.0))),
        ("t_per", AnalysisSettings(estimates=EstimateSettings(shortest_track_in_t_per=1e3))),
    ],
)
def test_a_test_can_change_a_stages_settings(name, settings):
    states = list(slides_and_hops(1, 200.0, 25.0).states())
    found = []
    for analysis in (Analysis(), Analysis(settings=settings)):
        analysis.set_geometry(GEOMETRY)
        for state in states:
            analysis.push(state)
        analysis.finish()
        found.append({quantity.name: quantity for quantity in analysis.summary()}[name])
    assert found[0] != found[1]
