"""`worm model compare`: trials beside the exact walk, by themselves and together."""

import json
import shutil
import sys

import numpy as np
import pytest
from escaped_trials import escaped_trial
from escaping_worm import Worm

from worm_bringup.cli.app import main
from worm_bringup.model_comparisons import compare_trials
from worm_model.inference.comparison import ModelParameters
from worm_msgs_py.contract.agreement import agreements


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    """Two trials at W = 1 mm, one at 3 mm."""
    base = tmp_path_factory.mktemp("trials")
    worms = [Worm(seed=1), Worm(seed=2), Worm(seed=3, exit_width_mm=3.0)]
    return [escaped_trial(base / f"trial{n}", worm) for n, worm in enumerate(worms)]


@pytest.fixture(scope="module")
def cases(trials):
    """Each trial, then the pool of the two at W = 1 mm."""
    return compare_trials(trials, ModelParameters())


@pytest.fixture
def worm(monkeypatch, capsys):
    """Return a function that runs `worm model compare`: exit status, stdout and stderr."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["worm", "model", "compare", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code or 0, *capsys.readouterr()

    return run


def test_each_trial_is_compared_and_then_those_of_one_width_together(trials, cases):
    assert [case.name for case in cases] == [*map(str, trials), "W = 1 mm, 2 trials"]
    assert [case.trials for case in cases] == [1, 1, 1, 2]
    for case in cases:
        found = {q.name: q for q in case.comparison.quantities}
        assert found["tau_h"].modelled > 0
        assert case.comparison.needs


def test_a_trial_is_compared_as_it_was_when_it_was_analysed(trials, cases):
    """All options at their defaults, the tables give what the summary already says."""
    case = cases[0]
    told = json.loads((trials[0] / "summary.json").read_text(encoding="utf-8"))["model"]
    for quantity in case.comparison.quantities:
        entry = told["quantities"][quantity.name]
        for field in ("measured", "modelled", "modelled_low", "modelled_high"):
            number = getattr(quantity, field)
            expected = np.nan if entry[field] is None else entry[field]
            assert number == pytest.approx(expected, rel=1e-6, nan_ok=True), (quantity.name, field)
    assert len(case.comparison.needs) == len(told["needed_reversals"])
    for need, entry in zip(case.comparison.needs, told["needed_reversals"], strict=True):
        assert (need.rule, need.speed, need.observation) == (
            entry["rule"], entry["speed"], entry["observation"],
        )  # fmt: skip
        expected = np.nan if entry["value"] is None else entry["value"]
        assert need.value == pytest.approx(expected, rel=1e-6, nan_ok=True)


def test_a_worm_that_walks_the_walk_is_held_together_at_its_own_speed(cases):
    """The simulated worms reverse in 5 % of their cycles."""
    (found,) = [
        a
        for a in agreements(cases[-1].comparison.needs)
        if (a.rule, a.speed) == ("per_cycle", "v_b")
    ]
    assert found.holds_all
    assert found.low < 0.1


def test_rule_and_speed_may_be_chosen(trials):
    given = ModelParameters(rule="per_phase", speed="v_w", hop_may_land=False)
    (case,) = compare_trials(trials[:1], given)
    used = dict(case.comparison.parameters)
    assert (used["rule_per_phase"], used["hop_may_land"]) == (1.0, 0.0)
    assert "v_w_is_measured" in used


def test_json_says_what_the_tables_say(worm, trials):
    status, out, _ = worm(*trials[:2], "--json")
    assert status == 0
    document = json.loads(out)
    assert [entry["name"] for entry in document] == [*map(str, trials[:2]), "W = 1 mm, 2 trials"]
    for entry in document:
        assert entry["quantities"]["tau_h"]["modelled"] > 0
        assert len(entry["agreements"]) == 6
        assert all(a["held"] for a in entry["agreements"])
    status, out, _ = worm(*trials[:2])
    assert status == 0
    for entry in document:
        for agreement in entry["agreements"]:
            assert agreement["answer"] in " ".join(out.split())
    assert "…" not in out.replace(" … ", ""), "no number is cut short"


def test_without_a_trial_the_papers_own_numbers_are_asked(worm):
    status, out, _ = worm("--json")
    assert status == 0
    (entry,) = json.loads(out)
    (t_per,) = [
        need for need in entry["needed_reversals"]
        if (need["rule"], need["speed"], need["observation"]) == ("per_cycle", "v_w", "t_per")
    ]  # fmt: skip
    assert t_per["value"] == pytest.approx(0.0308, abs=1e-4)
    assert " ".join(worm()[1].split()).count("n_s, but not t_per, escape_ratio.") == 3


def test_a_pool_predicts_from_the_pooled_numbers(cases):
    single = [case.comparison for case in cases[:2]]
    pooled = {q.name: q for q in cases[-1].comparison.quantities}
    for name in ("d_c", "d_nc", "v_b"):
        values = sorted(q.modelled for c in single for q in c.quantities if q.name == name)
        assert values[0] <= pooled[name].modelled <= values[-1]
    widths = [
        q.measured_high - q.measured_low for c in single for q in c.quantities if q.name == "d_c"
    ]
    assert pooled["d_c"].measured_high - pooled["d_c"].measured_low < min(widths)


def test_the_figure_is_whole_or_not_there(worm, tmp_path):
    out = tmp_path / "joint.svg"
    assert worm("--figure", out)[0] == 0
    assert out.read_text(encoding="utf-8").rstrip().endswith("</svg>")
    for wrong in (tmp_path / "joint.txt", tmp_path / "nowhere" / "joint.svg"):
        status, _, told = worm("--figure", wrong)
        assert status == 2
        assert str(wrong) in told
        assert not wrong.exists()
    assert [item.name for item in tmp_path.iterdir()] == ["joint.svg"]


@pytest.mark.parametrize("fault", ["no directory", "no summary", "twice"])
def test_a_trial_that_cannot_be_used_is_named_in_one_line(worm, trials, tmp_path, fault):
    bad = tmp_path / "bad"
    if fault == "no summary":
        shutil.copytree(trials[0], bad)
        (bad / "summary.json").unlink()
    elif fault == "twice":
        shutil.copytree(trials[0], bad)
    status, out, told = worm(trials[0], bad)
    assert (status, out) == (2, "")
    assert str(bad) in told.splitlines()[-1]
