"""The report says what does not fit: the paper's laws, and the walk."""

import re

import pytest
from report_page import changed_summary, figure, report_of, rows, words


def with_quantity(whole, directory, **values):
    """Return a copy of a trial in which the numbers are others."""

    def change(summary):
        for name, (value, low, high) in values.items():
            summary["quantities"][name] |= {"value": value, "low": low, "high": high, "n": 99}

    return report_of(changed_summary(whole, directory, change))


def test_a_rejected_exponential_says_so(whole, tmp_path):
    said = "an exponential law is rejected (Anderson and Darling’s test, p = 0.002, n = 99)"
    bad = with_quantity(whole, tmp_path / "bad", d_c_exponential_p=(0.002, None, None))
    assert said in words(figure(bad, "fig-3"))
    assert said in words(re.search(r"numbers headline.*?</table>", bad, re.DOTALL)[0])
    good = with_quantity(whole, tmp_path / "good", d_c_exponential_p=(0.2, None, None))
    assert "⟨dc⟩: an exponential law" not in words(good)


@pytest.mark.parametrize(
    ("key", "name", "r", "said"),
    [
        ("fig-4b", "theta_dot_incidence_correlation", (0.85, 0.8, 0.9),
         "finds no correlation; here there is one, r = 0.850 [0.800 … 0.900]"),
        ("fig-4b", "theta_dot_incidence_correlation", (0.05, -0.1, 0.2), ""),
        ("fig-4a", "theta_dot_psi_b_correlation", (-0.5, -0.6, -0.4),
         "The paper finds that it grows; here it does not, r = −0.50 [−0.60 … −0.40]"),
        ("fig-4a", "theta_dot_psi_b_correlation", (0.05, -0.1, 0.2), ""),
    ],
)  # fmt: skip
def test_a_correlation_that_is_not_the_papers_says_so(whole, tmp_path, key, name, r, said):
    panel = figure(with_quantity(whole, tmp_path / "other", **{name: r}), key)
    if "<svg" not in panel:
        pytest.fail(f"{key} is not drawn")
    assert said in words(panel)
    assert ("Does not fit:" in words(panel)) == bool(said)


def test_a_decay_that_is_no_exponential_is_told_with_the_time_to_one_e(whole, tmp_path):
    page = with_quantity(
        whole, tmp_path / "beetle", t_per=(9.5, 8.0, 11.0), t_1e=(19.9, 15.0, 26.0),
        t_1e_over_t_per=(2.09, 1.6, 2.7), c_theta_tail=(0.2, 0.15, 0.25),
        c_theta_start=(-0.3, -0.4, -0.2),
    )  # fmt: skip
    for place in (figure(page, "fig-7a"), re.search(r"headline.*?</table>", page, re.DOTALL)[0]):
        said = words(place)
        assert (
            "fit decays in 9.5 [8.0 … 11.0] s but the curve falls to 1/e at 19.9 [15.0 … 26.0] s"
            in said
        )
        assert "up to 0.5 tper the curve less the fit is −0.30 [−0.40 … −0.20]" in said
        assert "from 1.5 tper on the curve less the fit is 0.200 [0.150 … 0.250]" in said
    page = with_quantity(
        whole, tmp_path / "one", t_1e_over_t_per=(1.1, 0.9, 1.3), c_theta_tail=(0.0, -0.1, 0.1),
        c_theta_start=(-0.05, -0.1, 0.0),
    )  # fmt: skip
    assert "is not one exponential" not in words(page)


def test_model_stands_beside_the_measurement_with_a_verdict(page):
    found = rows(figure(page, "fig-model"))
    assert found[0][:6] == ["⟨τh⟩", "–", "–", "50.0", "49.0 … 51.0", "s"]
    assert found[0][7].startswith("not measured: not enough data")
    assert found[1] == [
        "ns",
        "10.0",
        "5.0 … 20.0",
        "12.0",
        "11.0 … 13.0",
        "per 30 min",
        "",
        "agrees",
    ]
    assert found[2] == [
        "⟨dc⟩", "2.00", "1.60 … 2.50", "2.00", "–", "mm", "1.95", "given to the walk",
    ]  # fmt: skip
    assert found[3] == ["tper", "8.0", "5.0 … 12.0", "5.00", "–", "s", "27", "agrees"]


def test_report_says_with_which_parameters_the_model_was_run(page):
    panel = words(figure(page, "fig-model"))
    assert (
        "The walk was run with R = 10 mm, v = 2.02 mm/s, mean slide = 2 mm, reversal = 0.3, "
        "reversal counted = per cycle, hop may land = no, walks = 2000." in panel
    )
    assert "From this trial: ⟨dc⟩. From the paper, as this trial has none: reversal." in panel


def test_a_model_outside_the_measured_interval_does_not_agree(whole, tmp_path):
    def slow(summary):
        summary["model"]["quantities"]["t_per"]["modelled"] = 0.9

    panel = figure(report_of(changed_summary(whole, tmp_path / "slow", slow)), "fig-model")
    assert "It agrees with the measurement in ns." in words(panel)
    assert "It does not agree with the measurement in tper." in words(panel)
