"""The joint question and the forecasts' scores as the report shows them."""

from dataclasses import replace
from math import inf, nan

import matplotlib.colors as colours
import pytest
from report_trial import record, states, telegraph_walk, without_chamber

from worm_analysis.report import theme
from worm_analysis.report.figures.forecasts import forecasts
from worm_analysis.report.figures.joint_question import OF_PAPER, joint_figure, joint_question
from worm_analysis.results import read_results
from worm_model.inference.required_reversal import paper_needs
from worm_msgs_py import NeededReversal

SCORES = {
    "passages": 21.0,
    "passages_unscored": 2.0,
    "crps_s": 12.0,
    "crps_memoryless_s": 15.5,
    "crps_gain_s": 3.5,
    "crps_gain_low_s": 1.5,
    "crps_gain_high_s": 5.5,
    "pit_mean": 0.52,
    "pit_p": 0.61,
    "brier_10_s": 0.1,
    "brier_memoryless_10_s": 0.17,
    "brier_30_s": 0.2,
    "brier_memoryless_30_s": 0.25,
    "brier_60_s": 0.19,
    "brier_memoryless_60_s": 0.21,
}


@pytest.fixture(scope="module", autouse=True)
def style():
    with theme.style():
        yield


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    comparison, correlation = telegraph_walk(0.05)
    directory = tmp_path_factory.mktemp("model") / "trial"
    record(directory, states(20.0), comparison=comparison, model_correlation=correlation)
    return read_results(directory)


def with_comparison(results, **values):
    return replace(results, comparison=replace(results.comparison, **values))


def need(observation, value, low, high, rule="per_cycle", speed="v_b"):
    return NeededReversal(rule, speed, observation, value, low, high)


NEEDS = (
    need("reversal", 0.30, 0.25, 0.35),
    need("t_per", 0.03, 0.02, 0.04),
    need("tau_h", 0.3, 0.2, 0.4),
    need("n_s", nan, nan, nan),
)


def bars(axes):
    """Return the drawn intervals and their colours, from above."""
    lines = [line for line in axes.lines if len(line.get_xdata()) == 2]
    return [(tuple(line.get_xdata()), colours.to_hex(line.get_color())) for line in lines]


def test_what_is_held_together_is_blue_and_the_rest_orange(results):
    panel = joint_question(with_comparison(results, needs=NEEDS))
    axes = panel.figure.axes[0]
    head, centroid = theme.HEAD_COLOUR.lower(), theme.CENTROID_COLOUR.lower()
    assert [colour for _, colour in bars(axes)] == [head, centroid, head]
    assert [ends for ends, _ in bars(axes)] == [(0.25, 0.35), (0.02, 0.04), (0.2, 0.4)]
    assert [text.get_text() for text in axes.texts] == ["none"]
    (band,) = axes.patches
    assert band.get_x() == pytest.approx(0.25, rel=0.03)
    assert band.get_x() + band.get_width() == pytest.approx(0.35, rel=0.03)
    assert "0.25 to 0.35 gives reversal, ⟨τh⟩, but not tper, ns" in panel.alt
    assert panel.n.endswith("4 observations")
    assert panel.tables[""]["observation"] == ["reversal", "t_per", "tau_h", "n_s"]
    assert panel.tables[""]["low"][:3] == [0.25, 0.02, 0.2]


def test_each_rule_has_its_column_and_each_speed_its_row(results):
    needs = [
        replace(item, rule=rule, speed=speed)
        for rule in ("per_cycle", "per_phase", "rate")
        for speed in ("v_w", "v_b")
        for item in NEEDS
    ]
    axes = joint_question(with_comparison(results, needs=tuple(needs))).figure.axes
    titles = [ax.get_title() for ax in axes]
    assert len(titles) == 6
    assert titles[0] == "per slide + hop, at $v_w$"
    assert titles[5].startswith("per second")
    assert axes[5].get_xlabel() == "reversals (1/s)"
    assert axes[3].get_xlabel() == "chance of reversal"


def test_an_interval_that_is_open_goes_to_the_edge():
    open_end = need("tau_h", nan, 0.0, inf, rule="rate")
    axes = joint_figure([open_end, need("t_per", 0.1, 0.05, 0.2, rule="rate")]).axes[2]
    assert bars(axes)[0][0] == pytest.approx(axes.get_xlim())


def test_the_papers_observations_have_names_and_the_persistence_stands_apart():
    needs = paper_needs()
    assert {item.observation for item in needs} == set(OF_PAPER)
    axes = joint_figure(needs).axes[0]
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == list(OF_PAPER.values())
    drawn = [line for line in axes.lines if len(line.get_xdata()) == 2]
    at = {labels[int(line.get_ydata()[0])]: colours.to_hex(line.get_color()) for line in drawn}
    assert at[OF_PAPER["t_per"]] == theme.CENTROID_COLOUR.lower()
    assert at[OF_PAPER["reversal"]] == at[OF_PAPER["tau_h"]] == theme.HEAD_COLOUR.lower()


def test_the_bars_are_the_scores(results):
    panel = forecasts(with_comparison(results, scores=tuple(SCORES.items())))
    left, right = panel.figure.axes
    assert [bar.get_height() for bar in left.patches] == [12.0, 15.5]
    heights = [bar.get_height() for bar in right.patches]
    assert heights == [0.1, 0.2, 0.19, 0.17, 0.25, 0.21]
    assert left.get_ylabel() == "score (s)"
    assert "21 passages" in panel.n
    assert "gains 3.5 s [1.5 … 5.5] of CRPS a passage" in panel.reading
    assert "p = 0.61" in panel.reading
    assert panel.reading.endswith("begun before a forecast could be made: 2.")


def test_one_passage_has_no_interval_and_says_so_by_leaving_it_out(results):
    one = SCORES | {"passages": 1.0, "crps_gain_low_s": nan, "crps_gain_high_s": nan}
    panel = forecasts(with_comparison(results, scores=tuple(one.items())))
    assert "gains 3.5 s of CRPS" in panel.reading
    assert panel.n.endswith("1 passage with a forecast")


@pytest.mark.parametrize("make", [joint_question, forecasts])
def test_without_data_each_says_why(results, make, tmp_path):
    blind = record(tmp_path / "blind", without_chamber(states(10.0)), chamber=False)
    assert make(read_results(blind)).why == "no chamber in the picture"
    assert make(with_comparison(results, needs=NEEDS[:1], scores=())).why
    assert make(replace(results, comparison=None)).why
