"""What the figures show is what was measured: densities, laws, signs and axes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_trial import CHAMBER, record, states, telegraph_walk, without_chamber

from worm_analysis.accumulators.bins import RADIUS_EDGES
from worm_analysis.report import theme
from worm_analysis.report.examples import count_reversals, example_spans
from worm_analysis.report.figures.body_angle import ANGLE_EDGES_DEG, angle_density, body_angle_panel
from worm_analysis.report.figures.direction_correlation import persistence_panel
from worm_analysis.report.figures.model_comparison import model_comparison
from worm_analysis.report.figures.picture_motion import picture_motion, picture_trajectories, speed
from worm_analysis.report.figures.radial_distance import radial_density, radii
from worm_analysis.report.figures.statuses import statuses, times_of_runs
from worm_analysis.report.figures.time_traces import contact_spans, time_traces, without_wraps
from worm_analysis.report.figures.trajectories import trajectories
from worm_analysis.report.figures.wall_distances import (
    exponential_above,
    length_density,
    wall_distances,
)
from worm_analysis.report.report_data import of_trial
from worm_analysis.results import read_results

angles = st.lists(st.floats(-179.99, 179.99), min_size=1, max_size=60)


@pytest.fixture(scope="module", autouse=True)
def style():
    with theme.style():
        yield


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    comparison, correlation = telegraph_walk(0.1)
    directory = tmp_path_factory.mktemp("figures") / "trial"
    return read_results(
        record(directory, states(), comparison=comparison, model_correlation=correlation)
    )


@pytest.fixture(scope="module")
def mirrored(tmp_path_factory):
    directory = tmp_path_factory.mktemp("mirror") / "trial"
    return read_results(record(directory, states(mirrored=True)))


def line(axes, colour):
    """Return the data of the only long line of a colour."""
    found = [
        item for item in axes.lines if item.get_color() == colour and len(item.get_xdata()) > 9
    ]
    assert len(found) == 1
    return np.asarray(found[0].get_xdata()), np.asarray(found[0].get_ydata())


def labelled(axes, start):
    """Return the data of the line whose label starts so."""
    (found,) = [item for item in axes.lines if str(item.get_label()).startswith(start)]
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


def test_mirrored_trial_flips_y_of_the_trajectories(results, mirrored):
    for colour in theme.COLOURS.values():
        x, y = line(trajectories(results).figure.axes[0], colour)
        mirror_x, mirror_y = line(trajectories(mirrored).figure.axes[0], colour)
        np.testing.assert_allclose(mirror_x, x, atol=1e-9)
        np.testing.assert_allclose(mirror_y, -y, atol=1e-9)


def test_mirrored_trial_flips_the_body_angle_and_leaves_the_radii(results, mirrored):
    steps = [
        [patch.get_data() for patch in make(of_trial(trial)).figure.axes[0].patches]
        for make in (body_angle_panel, radii)
        for trial in (results, mirrored)
    ]
    for here, there in zip(steps[0], steps[1], strict=True):
        np.testing.assert_allclose(there.values, here.values[::-1], atol=1e-12)
    for here, there in zip(steps[2], steps[3], strict=True):
        np.testing.assert_allclose(there.values, here.values, atol=1e-12)


@pytest.mark.parametrize(("row", "sign"), [(0, 1), (2, -1), (3, -1)])
def test_mirrored_trial_flips_the_angles_against_time(results, mirrored, row, sign):
    colour = theme.HEAD_COLOUR if row == 0 else theme.INK
    t_s, value = line(time_traces(results).figure.axes[row], colour)
    mirror_t_s, mirror_value = line(time_traces(mirrored).figure.axes[row], colour)
    np.testing.assert_allclose(mirror_t_s, t_s)
    np.testing.assert_allclose(mirror_value, sign * value, atol=1e-6)


def test_mirrored_trial_turns_the_other_way_round(results, mirrored):
    turned = [
        np.diff(line(time_traces(trial).figure.axes[1], theme.HEAD_COLOUR)[1])
        for trial in (results, mirrored)
    ]
    np.testing.assert_allclose(turned[1], -turned[0], atol=1e-6)


def test_theta_h_rises_where_the_body_points_counter_clockwise(results):
    axes = time_traces(results).figure.axes
    t_s, theta = line(axes[1], theme.HEAD_COLOUR)
    psi = line(axes[2], theme.INK)[1]
    known = np.isfinite(theta) & np.isfinite(psi)
    rate = np.gradient(theta[known], t_s[known])
    leaning = np.abs(psi[known]) > 20
    assert np.mean(np.sign(rate) == np.sign(psi[known]), where=leaning) > 0.85


@given(angles)
def test_angle_density_has_unit_area_and_mirrors(psi):
    counts = np.histogram(psi, ANGLE_EDGES_DEG)[0].astype(float)
    edges, density = angle_density(counts)
    assert density @ np.diff(edges) == pytest.approx(1)
    np.testing.assert_allclose(angle_density(counts[::-1])[1], density[::-1])


@given(st.lists(st.floats(0, 10.99), min_size=1, max_size=60), st.floats(0.5, 3))
def test_radial_density_has_unit_area_at_any_scale(r, scale):
    counts = np.histogram(np.array(r) / 10.0, RADIUS_EDGES)[0].astype(float)
    edges, density = radial_density(counts, 10.0 * scale)
    assert density @ np.diff(edges) == pytest.approx(1)
    assert len(density) == len(edges) - 1


@pytest.mark.parametrize("limit_mm", [0.0, 0.3])
def test_lengths_of_an_exponential_law_follow_it_within_their_intervals(limit_mm):
    lengths = np.random.default_rng(4).exponential(1.95, 4000)
    found = length_density(lengths, 1.95, int((lengths >= limit_mm).sum()))
    fitted = found.edges_mm[:-1] >= found.limit_mm
    assert found.limit_mm == pytest.approx(limit_mm, abs=0.01)
    middles = (found.edges_mm[1:] + found.edges_mm[:-1])[fitted] / 2
    width = np.diff(found.edges_mm)[fitted]
    # The law's mean over a bin, not its value in the middle.
    law = exponential_above(middles, 1.95, limit_mm) * np.sinh(width / 3.9) / (width / 3.9)
    inside = (found.low[fitted] <= law) & (law <= found.high[fitted])
    assert inside.mean() > 0.85
    assert (found.density * np.diff(found.edges_mm))[fitted].sum() == pytest.approx(1, abs=0.01)


@given(st.floats(0.1, 5), st.floats(0, 2))
def test_exponential_has_unit_area_above_the_limit(mean_mm, limit_mm):
    x = np.linspace(limit_mm, limit_mm + 30 * mean_mm, 20001)
    assert np.trapezoid(exponential_above(x, mean_mm, limit_mm), x) == pytest.approx(1, abs=1e-5)


def test_fit_and_paper_in_fig_3_have_the_means_that_they_say(results):
    for axes, name in zip(
        wall_distances(of_trial(results)).figure.axes, ("d_c", "d_nc", "delta_r_h"), strict=True
    ):
        quantity = results.quantity(name)
        for label, mean in (("fit", quantity.value), ("paper", quantity.paper)):
            x, y = labelled(axes, label)
            assert -np.diff(x) / np.diff(np.log(y)) == pytest.approx(mean)
        assert axes.get_yscale() == "log"
        title = axes.get_legend().get_title().get_text()
        assert title.startswith(f"n\u00a0=\u00a0{quantity.n}")


def test_fig_7a_shows_measurement_fit_walk_and_paper(results):
    axes = persistence_panel(of_trial(results)).figure.axes[0]
    t_per = results.quantity("t_per").value
    for label, decay_s in (("fit", t_per), ("boundary walk", 5.0), ("paper", 27.0)):
        lag_s, c = labelled(axes, label)
        np.testing.assert_allclose(c, np.exp(-lag_s / decay_s), atol=1e-9)
    lag_s, c = labelled(axes, "measured")
    known = np.isin(results.correlation.lag_s, lag_s)
    np.testing.assert_array_equal(c, results.correlation.c[known])
    assert results.correlation.pairs[known].min() >= results.correlation.pairs[0] / 4


def test_wall_is_open_at_the_exit_and_nowhere_else(results):
    axes = trajectories(results).figure.axes[0]
    (wall,) = axes.patches
    R, W = CHAMBER.radius_m * 1e3, CHAMBER.exit_width_m * 1e3
    assert wall.width == pytest.approx(2 * R)
    opening = np.radians(wall.theta1 + 360 - wall.theta2)
    assert 2 * R * np.sin(opening / 2) == pytest.approx(W)
    assert axes.get_aspect() == 1


def test_no_point_of_the_worm_is_drawn_beyond_the_wall(results):
    axes = trajectories(results).figure.axes[0]
    for colour in theme.COLOURS.values():
        x, y = line(axes, colour)
        assert np.nanmax(np.hypot(x, y)) <= 10.0


def test_each_chamber_has_axes_of_its_own(results):
    other = replace(CHAMBER, name="chamber_b")
    where = results.tracks["where"].copy()
    where[len(where) // 2 :] = "chamber_b"
    both = replace(results, chambers=(CHAMBER, other), tracks={**results.tracks, "where": where})
    figure = trajectories(both).figure
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["chamber a", "chamber b"]
    shown = sum(np.isfinite(line(axes, theme.HEAD_COLOUR)[0]).sum() for axes in figure.axes)
    assert shown == np.isfinite(results.tracks["head_x_mm"]).sum()


def test_head_in_the_passage_is_drawn_in_the_chamber_that_it_left(results):
    where = results.tracks["where"].copy()
    where[100:120] = "passage"
    far = replace(CHAMBER, name="chamber_b", centre_u_px=CHAMBER.centre_u_px + 2200)
    left = replace(results, chambers=(CHAMBER, far), tracks={**results.tracks, "where": where})
    (axes,) = trajectories(left).figure.axes
    shown = np.isfinite(line(axes, theme.HEAD_COLOUR)[0]).sum()
    assert shown == np.isfinite(results.tracks["head_x_mm"]).sum()


def test_long_trial_shows_a_minute_and_the_whole_thinned(tmp_path):
    long = read_results(record(tmp_path / "trial", states(130.0, 20.0)))
    minute, whole = trajectories(long).figure.axes
    assert 0.9 * 1200 <= len(line(minute, theme.HEAD_COLOUR)[0]) <= 1200
    assert len(line(whole, theme.HEAD_COLOUR)[0]) <= 1500
    panel = time_traces(long)
    assert len(panel.figure.axes) == 8
    assert "chosen by rule" in panel.reading


def test_examples_go_from_steady_to_turning(tmp_path):
    short = read_results(record(tmp_path / "trial", states()[:50]))
    t_s = np.arange(0.0, 300.0, 0.1)
    minute = (t_s // 60).astype(int)
    turns = np.array([2, 0, 6, 1, 4])[minute]
    within = t_s - 60 * minute
    theta = np.cumsum(0.02 * np.where((within * (turns + 1) // 60) % 2, -1, 1))
    long = replace(
        short,
        tracks={
            "stamp_ns": np.rint(t_s * 1e9).astype(np.int64),
            "theta_h_rad": theta,
            "where": np.full(len(t_s), "chamber_a", dtype=object),
        },
    )
    assert [minute[rows[0]] for rows in example_spans(long)] == [1, 0, 2]
    assert all(len(set(minute[rows])) == 1 for rows in example_spans(long))


@pytest.mark.parametrize("turns", [0, 1, 3])
def test_reversals_of_a_triangle_are_counted(turns):
    t_s = np.arange(0.0, 60.0, 0.05)
    theta = np.cumsum(np.where((t_s * (turns + 1) // 60) % 2, -1.0, 1.0))
    theta[100:140] = np.nan
    assert count_reversals(t_s, theta) == turns


@given(st.lists(st.sampled_from([1.0, 0.0, np.nan]), min_size=2, max_size=40))
def test_contact_spans_hold_exactly_the_frames_in_contact(contact):
    t_s = np.arange(len(contact), dtype=float)
    spans = contact_spans(t_s, np.array(contact))
    for at, touching in zip(t_s[:-1], contact[:-1], strict=True):
        assert any(start <= at < end for start, end in spans) == (touching == 1.0)


@given(angles)
def test_no_line_is_drawn_across_a_wrap(psi):
    drawn = without_wraps(np.array(psi))
    jumps = np.abs(np.diff(drawn))
    assert not (jumps[np.isfinite(jumps)] > 180).any()
    kept = np.isfinite(drawn)
    np.testing.assert_array_equal(drawn[kept], np.array(psi)[kept])


@given(st.lists(st.booleans(), min_size=2, max_size=50))
def test_status_runs_hold_each_frame_and_no_other(chosen):
    t_s = np.arange(len(chosen)) * 0.1
    found = times_of_runs(t_s, np.array(chosen))
    for at, inside in zip(t_s, chosen, strict=True):
        assert any(start <= at < start + length - 1e-9 for start, length in found) == inside


def test_status_counts_add_up(results):
    text = [item.get_text() for item in statuses(results).figure.axes[0].texts]
    assert sum(int(item.replace("\u2009", "")) for item in text) == len(results.t_s)


def test_speed_of_a_uniform_motion_is_exact_and_unknown_at_the_ends():
    t_s = np.arange(0.0, 10.0, 0.05)
    found = speed(t_s, 3.0 * t_s + 7, -4.0 * t_s)
    inside = (t_s >= 0.5) & (t_s <= t_s[-1] - 0.5)
    np.testing.assert_allclose(found[inside], 5.0)
    assert not np.isfinite(found[~inside]).any()


def test_picture_is_shown_as_it_is_v_down(tmp_path):
    bare = read_results(record(tmp_path / "bare", without_chamber(states()), chamber=False))
    axes = picture_trajectories(bare).figure.axes[0]
    bottom, top = axes.get_ylim()
    assert bottom > top
    u, v = line(axes, theme.HEAD_COLOUR)
    np.testing.assert_array_equal(u, bare.tracks["head_u_px"])
    np.testing.assert_array_equal(v, bare.tracks["head_v_px"])
    above, below = picture_motion(bare).figure.axes
    assert above.get_ylabel() == "speed (px/s)"
    assert below.get_ylabel() == "length (px)"


def test_model_is_drawn_in_units_of_the_measurement(results):
    axes = model_comparison(results).figure.axes[0]
    assert [item.get_text() for item in axes.get_yticklabels()] == [
        "$t_{per}$", "$n_s$",
    ]  # fmt: skip
    places = {
        (bar.get_label(), round(float(bar[0].get_ydata()[0]))): float(bar[0].get_xdata()[0])
        for bar in axes.containers
    }
    assert places["measured", 0] == places["measured", 1] == 1
    assert places["boundary walk", 1] == pytest.approx(12.0 / 10.0)
    assert places["boundary walk", 0] == pytest.approx(5.0 / 8.0)


@pytest.mark.parametrize(
    "make", [trajectories, radii, body_angle_panel, time_traces, persistence_panel]
)
def test_axes_have_labels_with_units(results, make):
    data = results if make in (trajectories, time_traces) else of_trial(results)
    for axes in make(data).figure.axes:
        labels = [axes.get_xlabel(), axes.get_ylabel()]
        assert any(labels) or axes.get_shared_x_axes().get_siblings(axes)
        for label in filter(None, labels):
            assert "(" in label or label == r"$C_\theta(t)$"
