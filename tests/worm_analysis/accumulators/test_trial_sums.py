"""One pass over the frames gives what the plain computation over the whole track gives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from offline_analysis import Offline
from threshold_contact import ThresholdContact
from walked_tracks import GEOMETRY, R, rough_track, slides_and_hops

from worm_analysis.accumulators import wall_search
from worm_analysis.accumulators.contact_sensitivity import ContactRule
from worm_analysis.accumulators.direction_correlation import SignCorrelation, lag_grid
from worm_analysis.accumulators.frame_rows import FrameRows
from worm_analysis.analysis import Analysis
from worm_analysis.events.contact_state import HiddenContact
from worm_analysis.statistics.block_jackknife import Units
from worm_analysis.summary.direction_persistence import correlation_curve
from worm_analysis.summary.estimates import direction, pearson_of
from worm_analysis.summary.sums import Sums
from worm_msgs_py import Episode, EpisodeKind, Visit

seeds = st.integers(0, 2**32 - 1)


def run(track, contact=ThresholdContact):
    """Analyse a track, with contacts told by the paper's threshold unless said otherwise."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wall_search, "HiddenContact", contact)
        analysis = Analysis()
        analysis.set_geometry(GEOMETRY)
        results = [analysis.push(state) for state in track.states()]
    events = [event for _, closed in results for event in closed] + analysis.finish()
    return analysis, [observables for observables, _ in results], events


def column(rows, name):
    return np.array([getattr(row, name) for row in rows], dtype=float)


@settings(max_examples=25)
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


@settings(max_examples=25)
@given(seeds)
def test_episodes_equal_the_plain_computation(seed):
    track = rough_track(seed)
    _, _, events = run(track)
    found = sorted(
        (event for event in events if isinstance(event, Episode)), key=lambda event: event.start_ns
    )
    expected = Offline(track).episodes()
    assert len(found) == len(expected)
    for event, item in zip(found, expected, strict=True):
        assert event.chamber == item["chamber"]
        assert event.kind is (EpisodeKind.CONTACT if item["in_contact"] else EpisodeKind.FREE)
        times = (item["start_ns"], item["end_ns"], item["complete"])
        assert (event.start_ns, event.end_ns, event.complete) == times
        assert event.distance_m == pytest.approx(item["distance"], abs=1e-9)
        assert event.delta_r_m == pytest.approx(item["depth"], abs=1e-9, nan_ok=True)


@settings(max_examples=15)
@given(seeds, st.booleans())
def test_correlation_and_speed_law_equal_the_plain_computation(seed, hops):
    track = rough_track(seed, 1500, hops)
    offline, (analysis, _, _) = Offline(track), run(track)
    c, pairs = offline.correlation(lag_grid(120, 10, 0.1, 1.0), 100_000_000)
    result = analysis.correlation()
    np.testing.assert_array_equal(result.pairs, pairs)
    np.testing.assert_allclose(result.c, c, atol=1e-9)
    windows = offline.windows()
    n, along, square = analysis.sums()["v_w"].sum(axis=0) if len(windows) else (0, 0, 0)
    assert n == len(windows)
    if len(windows):
        v, s = windows.T
        assert along / square == pytest.approx((v @ s) / (s @ s), abs=1e-9)


@settings(max_examples=25)
@given(seeds)
def test_what_goes_with_the_speed_equals_the_plain_computation(seed):
    track = rough_track(seed, hops=seed % 2 == 0)
    offline, (analysis, _, _) = Offline(track), run(track)
    sums = Sums([analysis.sums()])
    rows = np.isfinite(offline.theta_dot) & np.isfinite(offline.psi_b)
    assert sums.total("theta_dot_psi_b")[0] == rows.sum()
    if rows.sum() > 2:
        r = np.corrcoef(offline.theta_dot[rows], offline.psi_b[rows])[0, 1]
        assert pearson_of("theta_dot_psi_b")(sums)[0] == pytest.approx(r, abs=1e-9)
    pairs = offline.collisions()
    assert sums.total("theta_dot_incidence")[0] == len(pairs)
    if len(pairs) > 2:
        r = np.corrcoef(pairs.T)[0, 1]
        assert pearson_of("theta_dot_incidence")(sums)[0] == pytest.approx(r, abs=1e-9)
    turns, directed_s = offline.turns()
    assert sums.total("reversal_rate") == pytest.approx([directed_s, turns], abs=1e-9)
    assert sums.total("reversal_rate_gaps") == pytest.approx(offline.gaps(), abs=1e-9)
    v = R * offline.theta_dot[np.isfinite(offline.theta_dot)]
    assert sums.total("v_b") == pytest.approx(offline.way_near_wall(), abs=1e-9)
    assert sums.total("v_b_mean")[1] == pytest.approx(v.sum(), abs=1e-9)
    if rows.any():
        psi = offline.psi_b[offline.valid]
        mean = np.angle(np.nansum(np.exp(1j * psi)))
        assert direction("psi_b_mean")(sums)[0] == pytest.approx(mean, abs=1e-9)


def test_angles_that_point_everywhere_have_no_mean():
    angles = np.arange(16) * 2.4
    rows = np.column_stack([np.full(16, 5.0), np.sin(angles), np.cos(angles)])
    assert np.isnan(direction("psi_b_mean")(Sums([{"psi_b_mean": rows}]))).all()


@settings(max_examples=12)
@given(seeds, st.sampled_from([1, 7, 1024]))
def test_lengths_under_every_rule_of_contact_equal_the_plain_computation(seed, at_once):
    """Also however the frames are bunched on their way to the sums."""
    track = rough_track(seed)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FrameRows, "MOST", at_once)
        analysis, _, _ = run(track)
    offline = Offline(track)
    own = (ContactRule("", 0.3, 0.3, 0.0), analysis._search.episodes.lengths)
    sensitivity = analysis._search.sensitivity
    for rule, lengths in (own, *zip(sensitivity.rules, sensitivity.lengths, strict=True)):
        given_rule = {
            "on": rule.contact_factor,
            "off": rule.release_factor,
            "min_ns": round(rule.min_episode_s * 1e9),
        }
        for in_contact, sums in ((True, lengths.d_c), (False, lengths.d_nc)):
            for cutoff in (0.0, 1e-4):
                n, excess, _ = sums.above(cutoff)
                expected = offline.excess(in_contact, cutoff, **given_rule)
                assert (n, excess) == pytest.approx(expected, abs=1e-9), rule.label


@settings(max_examples=12)
@given(seeds)
def test_skips_and_what_is_left_out_equal_the_plain_computation(seed):
    track = rough_track(seed, 1000, hops=True)
    offline, (analysis, _, events) = Offline(track), run(track)
    assert analysis._position.skips[0] == offline.skips()
    assert sum(e.skips for e in events if isinstance(e, Visit)) == offline.skips()
    found = {quantity.name: quantity for quantity in analysis.summary()}
    tracked = np.isfinite(track.head[:, 0])
    assert found["frames_untracked"].value == pytest.approx(1 - tracked.mean(), abs=1e-12)
    doubted = tracked & (track.certainty < 0.9)
    assert found["frames_uncertain"].value == pytest.approx(doubted.mean(), abs=1e-12)
    assert found["frames_uncertain"].n == len(track.stamp_ns)


def test_the_rough_tracks_hold_what_they_are_to_test():
    """Skips, windows, collisions, excursions into the exit, and rules of contact that matter."""
    held = np.zeros(5)
    for seed in range(5):
        offline = Offline(rough_track(seed, 1500, hops=True))
        episodes, calmer = offline.episodes(), offline.episodes(0.3, 0.6, 200_000_000)
        landed = sum(e["cut"] and e["complete"] for e in episodes)
        held += (
            offline.skips(),
            len(offline.windows()),
            len(offline.collisions()),
            landed,
            len(episodes) - len(calmer),
        )
    assert (held > [2, 5, 50, 0, 50]).all(), held


def test_frames_that_are_not_certain_of_the_head_do_not_poison_the_estimates():
    """Head and tail exchanged in every tenth second, and said to be in doubt."""
    track = slides_and_hops(0, 300.0, 25.0)
    doubted = track.stamp_ns // 10**9 % 10 == 3
    honest = replace(track, certainty=np.where(doubted, 0.6, 0.99))
    swapped = replace(
        honest,
        head=np.where(doubted[:, None], track.tail, track.head),
        tail=np.where(doubted[:, None], track.head, track.tail),
    )
    assert repr(run(swapped, HiddenContact)[2]) == repr(run(honest, HiddenContact)[2])
    lost = replace(track, head=np.where(doubted[:, None], np.nan, track.head))
    told, without = (
        {q.name: q for q in run(t, HiddenContact)[0].summary() if "frames" not in q.name}
        for t in (swapped, lost)
    )
    for name in ("d_c", "d_nc", "delta_r_h", "t_per", "v_w", "theta_dot_psi_b_correlation"):
        assert repr(told[name]) == repr(without[name]), name


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
    cell, stretch, seen, waiting = 0, 0, [], []

    def hand_on():
        stamps, signs = np.array(waiting).reshape(-1, 2).T
        correlation.add(stamps.astype(np.int64) * 100_000_000, signs)
        waiting.clear()

    for skipped, sign, broken in steps:
        if broken and skipped > 5:
            hand_on()
            correlation.break_off()
            stretch += 1
        elif broken:
            hand_on()
        cell += skipped
        seen.append((cell, sign, stretch))
        waiting.append((cell, sign))
    hand_on()
    c, pairs = correlation_curve(Units([correlation.sums()["c_theta"]]))
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
    complete = [item for item in offline.episodes() if item["complete"] and item["in_contact"]]
    expected, _ = np.histogram([item["distance"] for item in complete], by_name["d_c"].edges)
    np.testing.assert_array_equal(by_name["d_c"].counts, expected)


def test_the_same_states_give_the_same_numbers_to_the_last_bit():
    track = rough_track(7, n=3000)
    first, second = run(track, HiddenContact), run(track, HiddenContact)
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
    plain, _, _ = run(track, HiddenContact)
    assert repr(asked.summary()) == repr(plain.summary())
    assert asked.correlation().error.tobytes() == plain.correlation().error.tobytes()
