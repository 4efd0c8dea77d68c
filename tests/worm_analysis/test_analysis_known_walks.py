"""Numbers of worms that walk along the wall by the paper's laws, with known means."""

import numpy as np
import pytest
from analysed_states import CLOSED, analyse, by_name
from walked_tracks import THRESHOLD, slides_and_hops, walk

pytestmark = pytest.mark.xdist_group("known walks")  # what they share is made once


@pytest.fixture(scope="module")
def walked():
    """The numbers of twelve trials of five minutes of the same worm."""
    return [by_name(analyse(slides_and_hops(seed, 300.0, 25.0).states())[0]) for seed in range(12)]


@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("d_c", 1.95),
        ("d_nc", 1.46),
        ("delta_r_h", 1.14),
        ("contact_fraction", 1.95 / (1.95 + 1.46)),
        ("reversal_per_cycle", 0.05),
        ("t_per", 3.41 / 2 / (2 * 0.05)),
        ("l_w", 20.0),
        ("d_w", 0.4),
        ("psi_b_positive_peak", 32.0),
        ("psi_b_negative_peak", -32.0),
    ],
)
def test_known_slides_and_hops_are_found_within_the_interval(walked, name, truth):
    slack = {"l_w": 0.05, "d_w": 0.0025}.get(name, 0.0)  # half a bin: the truth has no spread
    answers = [q[name] for q in walked if q[name].value is not None]
    needs_t_per = name == "t_per" or "peak" in name
    assert len(answers) >= (8 if needs_t_per else 12), "a trial of 18 t_per may be too short"
    inside = [answer.low - slack <= truth <= answer.high + slack for answer in answers]
    # At 95 % each, fewer than nine of twelve happens once in five hundred times.
    assert sum(inside) >= 0.75 * len(answers), [(a.low, a.value, a.high) for a in answers]
    assert all(answer.n >= 10 for answer in answers)


@pytest.fixture(scope="module")
def coarsely_filmed():
    """Four trials of the same worm, filmed at 5 frames/s: what was found and what was walked."""
    trials = []
    for seed in range(4):
        found = by_name(analyse(slides_and_hops(seed, 1500.0, 5.0).states(), CLOSED)[0])
        times, _, depths = walk(seed, 1500.0)
        distance, sliding = 2.0 * np.diff(times), depths < THRESHOLD
        walked = {
            "d_c": distance[sliding].mean(),
            "d_nc": distance[~sliding].mean(),
            "delta_r_h": (depths[~sliding] - THRESHOLD).mean() * 1e3,
        }
        trials.append((found, walked))
    return trials


@pytest.mark.parametrize("name", ["d_c", "d_nc", "delta_r_h"])
def test_a_slow_camera_gives_the_means_that_were_walked(coarsely_filmed, name):
    """Every tenth contact falls between two frames; uncorrected, means are 5 to 15 % off."""
    ratios = [found[name].value / walked[name] for found, walked in coarsely_filmed]
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03), ratios


RULES = (
    "contact_factor_0.3",
    "contact_factor_0.15",
    "contact_factor_0.45",
    "contact_factor_0.6",
    "contact_factor_0.9",
    "release_factor_0.45",
    "release_factor_0.6",
    "min_episode_s_0.1",
    "min_episode_s_0.2",
)


def test_every_number_of_the_table_is_there_with_its_unit(walked):
    units = {name: quantity.unit for name, quantity in walked[0].items()}
    assert units == {
        "r_h_over_R": "1",
        "r_c_over_R": "1",
        "r_t_over_R": "1",
        "psi_b_negative_peak": "deg",
        "psi_b_positive_peak": "deg",
        **{f"r_{point}_over_R_q{part}": "1" for point in "hc" for part in (10, 50, 90)},
        **{f"psi_b_q{part}": "deg" for part in (10, 50, 90)},
        "contact_fraction": "1",
        "d_c": "mm",
        "d_nc": "mm",
        "delta_r_h": "mm",
        **{f"{name}_mean": "mm" for name in ("d_c", "d_nc", "delta_r_h")},
        "radius_noise": "mm",
        "t_per": "s",
        "t_1e": "s",
        "t_1e_over_t_per": "1",
        "c_theta_tail": "1",
        "c_theta_start": "1",
        "d_c_exponential_p": "1",
        "d_nc_exponential_p": "1",
        "delta_r_h_exponential_p": "1",
        "v_w": "mm/s",
        "v_b": "mm/s",
        "v_b_mean": "mm/s",
        "psi_b_mean": "deg",
        "theta_dot_psi_b_correlation": "1",
        "theta_dot_incidence_correlation": "1",
        "reversal_per_cycle": "1",
        "search_bridged": "1",
        "search_missing": "1",
        "search_contact_untold": "1",
        "reversal_rate": "1/s",
        "tau_h": "s",
        "tau_h_exponential_p": "1",
        "n_s": "per 30 min",
        "n_s_over_w_s": "per 30 min",
        "success": "1",
        "failures_without_contact": "1",
        "failures_in_elongation": "1",
        "failures_touching_in_elongation": "1",
        "failures_touching_in_contraction": "1",
        "failures_of_unknown_phase": "1",
        "beta": "1/mm",
        "alpha": "1/mm",
        "const": "1/mm",
        "w_s": "mm",
        **{f"{name}_at_{rule}": "mm" for rule in RULES for name in ("d_c", "d_nc")},
        "l_w": "mm",
        "d_w": "mm",
        "frames_untracked": "1",
        "frames_uncertain": "1",
    }
    for quantity in walked[0].values():
        assert (quantity.value is None) == bool(quantity.why)
        if quantity.value is not None and quantity.low is not None:
            assert quantity.low <= quantity.value <= quantity.high
