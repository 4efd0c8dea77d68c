"""What a page says of a number beside the paper, and of a law that does not fit."""

from dataclasses import replace

import pytest
from escaped_trials import escaped_trial
from escaping_worm import Worm

from worm_analysis.pooling import Pool, pooled_trial
from worm_analysis.report.verdicts import beside_paper, chance, trials_differ
from worm_analysis.results import read_results
from worm_msgs_py import Quantity


@pytest.mark.parametrize(
    ("quantity", "verdict"),
    [
        (Quantity("d_c", 1.9, 1.7, 2.1, paper=1.95), "agrees with the paper"),
        (Quantity("v_w", 4.04, 3.9, 4.2, paper=2.02), "above the paper’s, 2 times as large"),
        (Quantity("t_per", 13.5, 10.0, 17.0, paper=27.0), "below the paper’s, 0.5 times as large"),
        (Quantity("beta", 0.3, None, 0.9, paper=0.5), "agrees with the paper"),
        (Quantity("beta", 0.3, None, 0.4, paper=0.5), "below the paper’s, 0.6 times as large"),
        (Quantity("w_s", 1.8, paper=2.0), "no verdict: it has no interval"),
        (Quantity("tau_h", 30.0, 20.0, 40.0), "the paper gives no number"),
        (Quantity("psi_b_mean", 5.0, 2.0, 8.0, paper=-30.0), "above the paper’s"),
        (Quantity("success", None, paper=0.6, why="not enough data"), "no verdict"),
    ],
)
def test_a_verdict_is_whether_the_papers_value_lies_in_the_interval(quantity, verdict):
    assert beside_paper(quantity) == verdict


@pytest.mark.parametrize(
    ("p", "words"),
    [(0.034, "<i>p</i> = 0.034"), (1e-4, "<i>p</i> = 0.0001"), (0.0, "<i>p</i> &lt; 0.0001")],
)
def test_no_chance_is_told_to_be_0(p, words):
    assert chance(p) == words


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    folder = tmp_path_factory.mktemp("verdicts")
    return [
        pooled_trial(
            read_results(escaped_trial(folder / f"{k}", Worm(seed=70 + k), 400.0)), f"{k}", f"{k}"
        )
        for k in range(3)
    ]


def slower(trial):
    """Return a trial whose slides are three times as long, block by block."""
    sums = dict(trial.sums)
    sums["d_c"] = sums["d_c"] * ([1.0, 3.0] + [1.0] * (sums["d_c"].shape[1] - 2))
    return replace(trial, sums=sums, provenance={})


def test_trials_that_differ_say_so_where_they_are_too_few_to_widen_the_interval(trials):
    assert trials_differ(Pool.of(trials), "d_c") == ""
    mixed = Pool.of([trials[0], trials[1], slower(trials[2])])
    assert "differ by more than their own intervals allow" in trials_differ(mixed, "d_c")
    many = [replace(trial, provenance={}) for trial in (*trials, *trials)]
    assert trials_differ(Pool.of([*many[:5], slower(many[5])]), "d_c") == "", "it is widened there"
