"""One pass over the frames gives what the plain computation over the whole track gives."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from offline_analysis import Offline
from walked_tracks import GEOMETRY, rough_track

from worm_analysis.analysis import Analysis
from worm_analysis.correlation import SignCorrelation, lag_grid
from worm_msgs_py import Episode, EpisodeKind

seeds = st.integers(0, 2**32 - 1)


def run(track):
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    results = [analysis.push(state) for state in track.states()]
    events = [event for _, closed in results for event in closed] + analysis.finish()
    return analysis, [observables for observables, _ in results], events


def column(rows, name):
    return np.array([getattr(row, name) for row in rows], dtype=float)


@settings(max_examples=40)
@given(seeds)
@example(0)
def test_observables_equal_the_plain_computation(seed):
    track = rough_track(seed)
    offline, (_, rows, _) = Offline(track), run(track)
    for name in ("r_h_m", "r_c_m", "r_t_m", "psi_b_rad", "psi_h_rad"):
        np.testing.assert_allclose(
            column(rows, name), getattr(offline, name.rsplit("_", 1)[0]), atol=1e-9, err_msg=name
        )
    searching = offline.valid
    np.testing.assert_allclose(
        column(rows, "theta_h_rad")[searching], offline.theta[searching], atol=1e-9
    )
    np.testing.assert_allclose(column(rows, "theta_dot_rad_s"), offline.theta_dot, atol=1e-9)
    np.testing.assert_array_equal(column(rows, "contact"), offline.contact)


@settings(max_examples=40)
@given(seeds)
def test_episodes_equal_the_plain_computation(seed):
    track = rough_track(seed)
    _, _, events = run(track)
    found = sorted(
        (event for event in events if isinstance(event, Episode)), key=lambda event: event.start_ns
    )
    expected = Offline(track).episodes()
    assert len(found) == len(expected)
    for event, (chamber, in_contact, start, end, distance, depth, complete) in zip(
        found, expected, strict=True
    ):
        assert event.chamber == chamber
        assert event.kind is (EpisodeKind.CONTACT if in_contact else EpisodeKind.FREE)
        assert (event.start_ns, event.end_ns, event.complete) == (start, end, complete)
        assert event.distance_m == pytest.approx(distance, abs=1e-9)
        assert event.delta_r_m == pytest.approx(depth, abs=1e-9, nan_ok=True)


@settings(max_examples=40)
@given(seeds)
def test_correlation_and_speed_law_equal_the_plain_computation(seed):
    track = rough_track(seed)
    offline, (analysis, _, _) = Offline(track), run(track)
    c, pairs = offline.correlation(lag_grid(120, 10, 0.1, 1.0), 100_000_000)
    result = analysis.correlation()
    np.testing.assert_array_equal(result.pairs, pairs)
    np.testing.assert_allclose(result.c, c, atol=1e-9)
    sums = analysis._search.frames
    if sums.total("sin_sin"):
        slope, _ = sums.ratio("v_sin", "sin_sin")
        assert slope == pytest.approx(offline.slope_of_speed(), abs=1e-9)


@given(
    st.lists(
        st.tuples(st.integers(1, 9), st.sampled_from([-1.0, 0.0, 1.0]), st.booleans()),
        max_size=120,
    )
)
def test_the_ring_of_past_signs_equals_the_plain_double_sum(steps):
    """Cells are skipped, stretches are broken, and the ring of 8 cells goes round many times."""
    lags = np.array([0, 1, 3, 7])
    correlation = SignCorrelation(lags, 0.1)
    cell, stretch, seen = 0, 0, []
    for skipped, sign, broken in steps:
        if broken and skipped > 5:
            correlation.break_off()
            stretch += 1
        cell += skipped
        seen.append((cell, sign, stretch))
        correlation.push(cell * 100_000_000, sign)
    c, pairs = correlation.curve()
    for k, lag in enumerate(lags):
        products = [
            one * other
            for at, one, here in seen
            for then, other, there in seen
            if at - then == lag and here == there
        ]
        assert pairs[k] == len(products)
        assert c[k] == pytest.approx(np.mean(products) if products else np.nan, nan_ok=True)


@settings(max_examples=20)
@given(seeds)
def test_histograms_count_every_frame_in_a_chamber(seed):
    track = rough_track(seed)
    offline, (analysis, _, _) = Offline(track), run(track)
    by_name = {item.name: item for item in analysis.distributions()}
    for name in ("r_h", "r_c", "r_t", "psi_b", "psi_h"):
        values = getattr(offline, name)[offline.valid]
        expected, _ = np.histogram(values, by_name[name].edges)
        # A value on an edge may fall to either side by rounding; none does but by chance.
        assert np.abs(by_name[name].counts - expected).sum() <= 2
        assert by_name[name].counts.sum() == expected.sum()
    complete = [item for item in offline.episodes() if item[-1] and item[1]]
    expected, _ = np.histogram([item[4] for item in complete], by_name["d_c"].edges)
    np.testing.assert_array_equal(by_name["d_c"].counts, expected)


def test_the_same_states_give_the_same_numbers_to_the_last_bit():
    track = rough_track(7, n=3000)
    first, second = run(track), run(track)
    assert repr(first[0].summary()) == repr(second[0].summary())
    assert repr(first[1:]) == repr(second[1:])


def test_asking_for_estimates_on_the_way_changes_nothing():
    track = rough_track(11, n=1500)
    asked = Analysis()
    asked.set_geometry(GEOMETRY)
    for state in track.states():
        asked.push(state)
        if state.frame % 400 == 0:
            asked.summary(), asked.correlation(), asked.distributions()
    asked.finish()
    assert repr(asked.summary()) == repr(run(track)[0].summary())
