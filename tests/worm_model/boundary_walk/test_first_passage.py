"""The exact law of τ_h against the Monte Carlo, closed forms, other solvers, and itself."""

from dataclasses import replace
from math import exp, hypot, nan, pi, radians

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_bvp
from scipy.linalg import expm
from scipy.stats import binom

from worm_model.boundary_walk.first_passage import HIGHEST_PROBABILITY, SolvedWalk
from worm_model.boundary_walk.monte_carlo import simulate_walks
from worm_model.boundary_walk.parameters import ReversalRule, WalkParameters
from worm_model.boundary_walk.state import Direction, Phase, WalkState

PAPER = WalkParameters()
CCW, CW = Direction.COUNTER_CLOCKWISE, Direction.CLOCKWISE
STARTS = {
    "anywhere": None,
    "slide": WalkState(radians(-50.0), CCW),
    "hop": WalkState(radians(140.0), CW, Phase.HOP),
    "hop above the exit": WalkState(radians(2.0), CCW, Phase.HOP),
}


@st.composite
def walks(draw):
    rule = draw(st.sampled_from(ReversalRule))
    return WalkParameters(
        radius_mm=draw(st.floats(2.0, 30.0)),
        exit_width_mm=draw(st.floats(0.0, 5.0)),
        speed_mm_s=draw(st.floats(0.1, 10.0)),
        mean_slide_mm=draw(st.floats(0.05, 50.0)),
        mean_hop_mm=draw(st.floats(0.05, 50.0)),
        reversal=draw(st.floats(0.0, 1.0)),
        rule=rule,
        hop_may_land=draw(st.booleans()),
    )


@st.composite
def states(draw):
    phase = draw(st.sampled_from(Phase))
    theta_rad = draw(st.floats(-pi, pi) if phase is Phase.HOP else st.floats(1.6, 2 * pi - 1.6))
    return WalkState(theta_rad, draw(st.sampled_from(Direction)), phase)


@pytest.mark.parametrize(
    ("reversal", "rule", "tau_s", "skips"),
    [(0.30, ReversalRule.PER_CYCLE, 50.88, 0.151), (0.45, ReversalRule.PER_PHASE, 98.84, 0.129)],
)
def test_known_values_at_one_millimetre(reversal, rule, tau_s, skips):
    law = SolvedWalk(replace(PAPER, reversal=reversal, rule=rule)).first_passage()
    assert law.mean_s == pytest.approx(tau_s, abs=0.005)
    assert law.skips == pytest.approx(skips, abs=0.0005)


def test_the_law_is_that_of_the_monte_carlo():
    """Each figure within 3 standard errors, but for as many as chance would have once in 1000."""
    deviations = []
    for seed, rule in enumerate(ReversalRule):
        for lands in (True, False):
            walk = replace(PAPER, rule=rule, reversal=0.25, hop_may_land=lands)
            for start in STARTS.values():
                deviations.extend(standard_errors_off(walk, start, seed=10 * seed + lands))
    far = sum(abs(z) > 3.0 for z in deviations)
    assert far <= binom.ppf(0.999, len(deviations), 0.0027)
    # Standard deviations are no smaller than the figures' correlation allows.
    assert np.sqrt(np.mean(np.square(deviations))) < 1.3


def standard_errors_off(walk, start, seed, count=4000):
    law, result = (
        SolvedWalk(walk).first_passage(start),
        simulate_walks(walk, count, seed, start=start),
    )
    times_s = np.array([0.2, 0.7, 1.5, 3.0]) * law.mean_s
    survival = law.survival(times_s)
    measured = (result.tau_h_s[:, np.newaxis] > times_s).mean(axis=0)
    error = np.sqrt(np.maximum(survival * (1 - survival), 1 / count**2) / count)
    root = np.sqrt(count)
    return [
        (result.tau_h_s.mean() - law.mean_s) / (result.tau_h_s.std() / root),
        (result.skips.mean() - law.skips) / (result.skips.std() / root),
        *((measured - survival) / error),
    ]


def test_a_head_that_never_turns_nor_leaves_the_wall_finds_the_exit_uniformly_in_one_round():
    law = SolvedWalk(replace(PAPER, reversal=0.0, mean_hop_mm=1e-9)).first_passage()
    round_s = PAPER.wall_mm / PAPER.speed_mm_s
    assert law.mean_s == pytest.approx(round_s / 2, rel=1e-6)
    assert law.variance_s2 == pytest.approx(round_s**2 / 12, rel=1e-6)
    part = np.array([0.1, 0.5, 0.93])
    np.testing.assert_allclose(law.within(part * round_s), part, atol=2e-6)
    np.testing.assert_allclose(law.density(part * round_s) * round_s, 1.0, atol=1e-3)


@pytest.mark.parametrize("rate_s", [1e-6, 0.02, 1.0, 1e4])
def test_a_sliding_head_that_turns_at_random_takes_the_telegraph_time(rate_s):
    """⟨τ⟩ = L/2v + λL²/6v²: ballistic, then diffusive with D = v²/2λ (L²/12D)."""
    walk = replace(PAPER, rule=ReversalRule.RATE, reversal=rate_s, mean_hop_mm=1e-9)
    length, v = walk.wall_mm, walk.speed_mm_s
    mean = length / (2 * v) + rate_s * length**2 / (6 * v**2)
    assert SolvedWalk(walk).first_passage().mean_s == pytest.approx(mean, rel=1e-6)


def test_a_diffusing_head_is_left_on_the_wall_by_the_series_of_an_interval():
    """S(t) = Σ 8/π²n² exp(−Dn²π²t/L²) over odd n, with D = v²/2λ."""
    walk = replace(PAPER, rule=ReversalRule.RATE, reversal=1e5, mean_hop_mm=1e-9)
    law, length = SolvedWalk(walk).first_passage(), walk.wall_mm
    diffusion = walk.speed_mm_s**2 / (2 * walk.reversal)
    times_s = np.array([0.02, 0.05, 0.1, 0.3]) * length**2 / diffusion
    n = np.arange(1, 60, 2)[:, np.newaxis]
    series = (8 / (pi * n) ** 2 * np.exp(-diffusion * (n * pi / length) ** 2 * times_s)).sum(0)
    np.testing.assert_allclose(law.survival(times_s), series, atol=1e-5)


def test_reversal_1_of_a_head_that_hardly_hops_is_a_turn_after_each_slide():
    walk = replace(PAPER, reversal=1.0, mean_hop_mm=1e-9)
    length, v = walk.wall_mm, walk.speed_mm_s
    turning = length / (2 * v) + length**2 / (6 * v * walk.mean_slide_mm)
    assert SolvedWalk(walk).first_passage().mean_s == pytest.approx(turning, rel=1e-6)
    twice = replace(walk, rule=ReversalRule.PER_PHASE)  # after the slide, and after the hop again
    assert SolvedWalk(twice).first_passage().mean_s == pytest.approx(length / (2 * v), rel=1e-6)


def test_skips_of_a_head_that_never_turns_follow_their_closed_form():
    """At each meeting it flies with the share of hops, and over with exp(−w_s/⟨d_nc⟩)."""
    walk = replace(PAPER, reversal=0.0)
    slide, hop, arc = walk.mean_slide_mm, walk.mean_hop_mm, walk.exit_arc_mm
    rates = 1 / slide + 1 / hop
    share, reach = hop / (slide + hop), rates * walk.wall_mm
    first = share * exp(-arc / hop) * (1 - (1 - exp(-reach)) / reach)
    # One that flew over starts its next round as a hop.
    again = exp(-arc / hop) * (share + (1 - share) * exp(-reach))
    skips = SolvedWalk(walk).first_passage().skips
    assert skips == pytest.approx(first / (1 - again), rel=1e-12)


def test_a_head_that_never_turns_is_found_at_exact_times():
    """It slides at the exit with probability (⟨d_c⟩ + ⟨d_nc⟩ e^{−ℓ/λ})/(⟨d_c⟩ + ⟨d_nc⟩)."""
    walk = replace(PAPER, reversal=0.0)
    slide, hop = walk.mean_slide_mm, walk.mean_hop_mm
    ahead_mm = 3.0
    start = WalkState(-(ahead_mm + walk.exit_arc_mm / 2) / walk.radius_mm, CCW)
    law = SolvedWalk(walk).first_passage(start)
    sliding = (slide + hop * exp(-ahead_mm * (1 / slide + 1 / hop))) / (slide + hop)
    times_s, probabilities = law.atoms(60.0)
    np.testing.assert_allclose(times_s, (ahead_mm + np.array([0, 20 * pi])) / walk.speed_mm_s)
    assert probabilities[0] == pytest.approx(sliding, rel=1e-12)
    just_before, just_after = law.within(times_s[0] * (1 + np.array([-1e-9, 1e-9])))
    assert just_before == pytest.approx(0.0, abs=1e-6)
    assert just_after == pytest.approx(sliding, abs=1e-6)
    assert law.quantile(sliding / 2) == pytest.approx(times_s[0], rel=1e-6)


@pytest.mark.parametrize("lands", [True, False])
@pytest.mark.parametrize("rule", [ReversalRule.PER_CYCLE, ReversalRule.PER_PHASE])
def test_means_from_every_state_are_those_of_a_general_boundary_value_solver(rule, lands):
    walk = replace(PAPER, rule=rule, hop_may_land=lands, mean_slide_mm=4.0, mean_hop_mm=3.0)
    solved, place_mm, means = SolvedWalk(walk), *means_by_collocation(walk)
    for row, (direction, phase) in enumerate(
        [(CCW, Phase.SLIDE), (CW, Phase.SLIDE), (CCW, Phase.HOP), (CW, Phase.HOP)]
    ):
        for x, mean in zip(place_mm[5:-5:40], means[row, 5:-5:40], strict=True):
            theta_rad = (x + walk.exit_arc_mm / 2) / walk.radius_mm
            law = solved.first_passage(WalkState(theta_rad, direction, phase))
            assert law.mean_s == pytest.approx(mean, rel=1e-6)


def means_by_collocation(walk):
    """Mean times, s, of the states slide ±, hop ± on the wall: no symmetry, no modes."""
    v, arc = walk.speed_mm_s, walk.exit_arc_mm
    sigma, eta = v / walk.mean_slide_mm, v / walk.mean_hop_mm
    q_s, q_h = walk.flip_after_slide, walk.flip_after_hop
    over, lands = exp(-arc / walk.mean_hop_mm), walk.hop_may_land
    # A hop above the exit that lands is found as it lands; else it takes the whole arc.
    arc_s = (1 - over) / eta if lands else arc / v

    def slopes(_, m):
        sp, sm, hp, hm = m
        to_hop_p, to_hop_m = (1 - q_s) * hp + q_s * hm, (1 - q_s) * hm + q_s * hp
        to_slide_p, to_slide_m = (1 - q_h) * sp + q_h * sm, (1 - q_h) * sm + q_h * sp
        return np.array(
            [
                (sigma * (sp - to_hop_p) - 1) / v,
                -(sigma * (sm - to_hop_m) - 1) / v,
                (eta * (hp - to_slide_p) - 1) / v,
                -(eta * (hm - to_slide_m) - 1) / v,
            ]
        )

    def ends(first, last):
        ended = 0.0 if lands else (1 - over) * (1 - q_h)
        return np.array(
            [
                last[0],
                first[1],
                last[2] - (arc_s + over * first[2] + ended * first[0]),
                first[3] - (arc_s + over * last[3] + ended * last[1]),
            ]
        )

    x = np.linspace(0.0, walk.wall_mm, 401)
    found = solve_bvp(slopes, ends, x, np.full((4, len(x)), 30.0), tol=1e-9, max_nodes=20_000)
    assert found.success
    return x, found.sol(x)


@pytest.mark.parametrize("rule", list(ReversalRule))
def test_survival_is_that_of_probability_carried_around_a_grid(rule):
    """Extrapolated from two grids that fit both the wall and the exit."""
    walk = replace(PAPER, exit_width_mm=PAPER.circumference_mm / 25, effective_width=False)
    walk = replace(walk, rule=rule, reversal=0.2)
    times_s, coarse = survival_on_grid(walk, 500)
    fine = survival_on_grid(walk, 1000)[1]
    extrapolated = (4 * fine - coarse) / 3
    found = SolvedWalk(walk).first_passage().survival(times_s)
    np.testing.assert_allclose(found, extrapolated, atol=2e-6)
    assert np.abs(fine - found).max() < 0.3 * np.abs(coarse - found).max()


def survival_on_grid(walk, cells):
    """Split steps: phases and reversals for half a step, one cell on, and half a step again."""
    step_s = walk.circumference_mm / walk.speed_mm_s / cells
    exit_cells, rate = cells // 25, walk.flip_rate_s
    sigma, eta = walk.speed_mm_s / walk.mean_slide_mm, walk.speed_mm_s / walk.mean_hop_mm
    q_s, q_h = walk.flip_after_slide, walk.flip_after_hop
    # Order: slide +, slide −, hop +, hop −; rates from row to column.
    wall = np.zeros((4, 4))
    wall[0, 2:] = wall[1, :1:-1] = sigma * (1 - q_s), sigma * q_s
    wall[2, :2] = wall[3, 1::-1] = eta * (1 - q_h), eta * q_h
    wall[[0, 1, 2, 3], [1, 0, 3, 2]] += rate
    wall -= np.diag(np.array([sigma, sigma, eta, eta]) + rate)
    over = np.diag([0.0, 0.0, -eta - rate, -eta - rate])
    over[2, 3] = over[3, 2] = rate
    on_wall, above = expm(wall * step_s / 2), expm(over * step_s / 2)
    p = np.zeros((4, cells))
    p[:2, exit_cells:] = 0.5 / (cells - exit_cells)
    steps = cells * np.array([1, 2, 5, 9])
    alive = []
    for number in range(1, steps[-1] + 1):
        for half in range(2):
            p[:, exit_cells:] = on_wall.T @ p[:, exit_cells:]
            p[:, :exit_cells] = above.T @ p[:, :exit_cells]
            if half == 0:
                p[::2], p[1::2] = np.roll(p[::2], 1, axis=1), np.roll(p[1::2], -1, axis=1)
                p[:2, :exit_cells] = 0.0
        if number in steps:
            alive.append(p.sum())
    return steps * step_s, np.array(alive)


@given(walk=walks(), state=states())
@settings(max_examples=25, deadline=None)
def test_a_mirror_image_takes_as_long(walk, state):
    assume(abs(state.theta_rad) > 1e-9)
    other = CW if state.direction is CCW else CCW
    mirrored = replace(state, theta_rad=-state.theta_rad, direction=other)
    one, two = law_of(walk, state), law_of(walk, mirrored)
    assert one.mean_s == pytest.approx(two.mean_s, rel=1e-9)
    assert one.skips == pytest.approx(two.skips, rel=1e-9)
    times_s = np.array([0.31, 1.7]) * one.mean_s
    np.testing.assert_allclose(one.within(times_s), two.within(times_s), atol=1e-6)


def law_of(walk, state):
    try:
        return SolvedWalk(walk).first_passage(state)
    except ValueError:  # a slide within a wide exit
        assume(False)


@given(walk=walks(), scale=st.floats(0.1, 10.0))
@settings(max_examples=25, deadline=None)
def test_a_rig_of_twice_the_size_and_speed_takes_as_long(walk, scale):
    larger = replace(
        walk,
        **{
            name: scale * getattr(walk, name)
            for name in (
                "radius_mm",
                "exit_width_mm",
                "depth_mm",
                "speed_mm_s",
                "mean_slide_mm",
                "mean_hop_mm",
            )
        },
    )
    one, two = SolvedWalk(walk).first_passage(), SolvedWalk(larger).first_passage()
    assert two.mean_s == pytest.approx(one.mean_s, rel=1e-8)
    assert two.sd_s == pytest.approx(one.sd_s, rel=1e-8)
    assert two.skips == pytest.approx(one.skips, rel=1e-8)


@given(walk=walks(), scale=st.floats(0.1, 10.0))
@settings(max_examples=25, deadline=None)
def test_twice_the_speed_takes_half_the_time(walk, scale):
    rate = scale if walk.rule is ReversalRule.RATE else 1.0
    faster = replace(walk, speed_mm_s=scale * walk.speed_mm_s, reversal=rate * walk.reversal)
    one, two = SolvedWalk(walk).first_passage(), SolvedWalk(faster).first_passage()
    assert two.mean_s * scale == pytest.approx(one.mean_s, rel=1e-8)
    assert two.skips == pytest.approx(one.skips, rel=1e-8)
    t_s = 0.8 * one.mean_s
    assert float(two.within(t_s / scale)) == pytest.approx(float(one.within(t_s)), abs=1e-6)


@given(walk=walks())
@settings(max_examples=15, deadline=None)
def test_the_uniform_start_is_the_average_over_the_wall(walk):
    solved = SolvedWalk(walk)
    node, weight = np.polynomial.legendre.leggauss(60)
    # Few nodes only resolve what is not much shorter than the wall.
    assume(min(walk.mean_slide_mm, walk.mean_hop_mm) > walk.wall_mm / 20)
    theta = (0.5 * walk.exit_arc_mm + (node + 1) / 2 * walk.wall_mm) / walk.radius_mm
    laws = [solved.first_passage(WalkState(angle, CCW)) for angle in theta]
    law = solved.first_passage()
    assert law.mean_s == pytest.approx(np.dot(weight, [x.mean_s for x in laws]) / 2, rel=1e-6)
    assert law.skips == pytest.approx(np.dot(weight, [x.skips for x in laws]) / 2, rel=1e-6)


@pytest.mark.parametrize("rule", list(ReversalRule))
def test_mean_and_variance_are_integrals_of_the_survival_function(rule):
    law = SolvedWalk(replace(PAPER, rule=rule, reversal=0.2)).first_passage()
    t_s = np.linspace(0.0, 25 * law.mean_s, 20_001)
    survival = law.survival(t_s)
    assert np.trapezoid(survival, t_s) == pytest.approx(law.mean_s, rel=1e-5)
    square = 2 * np.trapezoid(t_s * survival, t_s)
    assert square - law.mean_s**2 == pytest.approx(law.variance_s2, rel=1e-4)


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_the_density_and_the_atoms_make_up_the_probability(start):
    walk = replace(PAPER, reversal=0.1)
    law = SolvedWalk(walk).first_passage(start)
    times_s, probabilities = law.atoms(80.0)
    # Between times at which the density jumps: atoms, and the ends of landings.
    over_s, leaves_s = walk.exit_arc_mm / 2.02, (walk.exit_arc_mm / 2 - radians(20.0)) / 2.02
    jumps_s = np.concatenate([times_s, times_s + over_s, [leaves_s, walk.wall_mm / 2.02]])
    edges_s = np.concatenate([[0.0], np.sort(jumps_s[jumps_s < 80.0]) * (1 + 1e-9), [80.0]])
    found = np.diff(law.within(edges_s))
    for low, high, share in zip(edges_s[:-1], edges_s[1:], found, strict=True):
        t_s = low + (np.arange(4000) + 0.5) / 4000 * (high - low)
        smooth = law.density(t_s).mean() * (high - low)
        atoms = probabilities[(times_s > low) & (times_s <= high)].sum()
        assert smooth + atoms == pytest.approx(share, abs=2e-5)


@given(walk=walks(), state=st.one_of(st.none(), states()))
@settings(max_examples=20, deadline=None)
def test_survival_falls_from_one_and_its_quantiles_invert_it(walk, state):
    law = law_of(walk, state)
    survival = law.survival(law.mean_s * np.geomspace(1e-3, 30.0, 60))
    assert np.all(np.diff(survival) <= 2e-6)
    assert law.survival(0.0) == pytest.approx(1.0, abs=1e-6)
    for probability in (0.05, 0.5, 0.95):
        t_s = law.quantile(probability)
        before, after = law.within(np.array([t_s * (1 - 1e-4), t_s * (1 + 1e-4)]))
        assert before <= probability + 1e-5
        assert after >= probability - 1e-5


@given(walk=walks(), state=states())
@settings(max_examples=15, deadline=None)
def test_a_forecast_is_the_exact_law_but_for_its_stated_error(walk, state):
    exact = law_of(walk, state)
    t_s = exact.mean_s * np.array([0.1, 0.5, 1.0, 3.0])
    forecast = SolvedWalk(walk).forecast(state)
    np.testing.assert_allclose(forecast.within(t_s), exact.within(t_s), atol=4e-5)


@pytest.mark.parametrize("reversal", [0.0, 1e-6, 0.5, 1.0])
@pytest.mark.parametrize("hop_mm", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("slide_mm", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("rule", list(ReversalRule))
def test_short_and_long_steps_overflow_nothing(rule, slide_mm, hop_mm, reversal):
    walk = replace(PAPER, rule=rule, mean_slide_mm=slide_mm, mean_hop_mm=hop_mm, reversal=reversal)
    law = SolvedWalk(walk).first_passage(WalkState(pi, CCW))
    with np.errstate(all="raise", under="ignore"):
        half_s = walk.wall_mm / 2 / walk.speed_mm_s
        assert half_s * 0.99 < law.mean_s < 1e6
        assert 0.0 <= law.sd_s < 1e6
        assert law.skips >= 0.0
    # Turning the slide's and the hop's rates round by one in 10⁸ must not matter.
    near = SolvedWalk(replace(walk, mean_slide_mm=slide_mm * (1 + 1e-8))).first_passage(
        WalkState(pi, CCW)
    )
    assert near.mean_s == pytest.approx(law.mean_s, rel=1e-6)


def test_a_large_ring_is_solved_too():
    """A diffusing head: L²/12D, D = v·⟨d⟩ for turns after each slide of exponential length."""
    walk = replace(PAPER, radius_mm=1e4, mean_slide_mm=0.01, mean_hop_mm=1e-9, reversal=1.0)
    length, v = walk.wall_mm, walk.speed_mm_s
    mean = length / (2 * v) + length**2 / (6 * v * walk.mean_slide_mm)
    assert SolvedWalk(walk).first_passage().mean_s == pytest.approx(mean, rel=1e-6)


def test_a_wide_exit_leaves_little_wall():
    walk = replace(PAPER, exit_width_mm=62.8, effective_width=False)
    law = SolvedWalk(walk).first_passage()
    assert 0.0 < law.mean_s <= walk.wall_mm / walk.speed_mm_s
    with pytest.raises(ValueError, match=r"exit's arc of .* shorter than the wall's"):
        replace(PAPER, exit_width_mm=62.83)  # √(W² + h²) is wider than the ring


def test_an_angle_counts_from_the_exits_middle_counter_clockwise():
    near = replace(PAPER, reversal=0.0)
    quarter = (pi / 2 * near.radius_mm - near.exit_arc_mm / 2) / near.speed_mm_s
    for theta_deg, direction in ((90.0, CW), (-90.0, CCW), (270.0, CCW), (-270.0, CW)):
        law = SolvedWalk(near).first_passage(WalkState(radians(theta_deg), direction))
        assert law.atoms(30.0)[0][0] == pytest.approx(quarter, rel=1e-9)


def test_a_slide_in_the_exit_has_found_it():
    with pytest.raises(ValueError, match="has found the exit"):
        SolvedWalk(PAPER).first_passage(WalkState(0.01, CCW))
    edge = hypot(1.0, 1.5) / 2 / 10.0 + 1e-9
    law = SolvedWalk(PAPER).first_passage(WalkState(edge, CW))
    assert law.mean_s < 1e-6
    assert law.quantile(0.9) < 1e-6


@pytest.mark.parametrize("wrong", [0.0, -0.1, 1.0, HIGHEST_PROBABILITY * 1.001, nan])
def test_quantiles_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match="probability is"):
        SolvedWalk(PAPER).first_passage().quantile(wrong)


def test_times_and_angles_that_make_no_sense_are_refused():
    law = SolvedWalk(PAPER).first_passage()
    for wrong in (-1.0, nan, np.inf):
        with pytest.raises(ValueError, match="times must be"):
            law.survival(wrong)
    with pytest.raises(ValueError, match="theta_rad is nan"):
        WalkState(nan, CCW)
