"""The table of quantities is whole: each has a name of its own, words, and sums to rest on."""

from dataclasses import replace

import numpy as np
import pytest
from walked_tracks import GEOMETRY, slides_and_hops

from worm_analysis.analysis import Analysis
from worm_analysis.statistics.block_jackknife import JackknifeSettings
from worm_analysis.summary.quantities import DEFINITIONS, definitions, quantities
from worm_analysis.summary.settings import EstimateSettings
from worm_analysis.summary.sums import Sums


@pytest.fixture(scope="module")
def walked():
    analysis = Analysis()
    analysis.set_geometry(GEOMETRY)
    for state in slides_and_hops(1, 200.0, 25.0).states():
        analysis.push(state)
    analysis.finish()
    return analysis


def test_each_quantity_has_a_name_of_its_own_a_symbol_and_a_meaning():
    names = [definition.name for definition in definitions(["contact_factor_0.15"])]
    assert len(names) == len(set(names))
    for definition in DEFINITIONS.values():
        assert definition.html
        assert definition.plain
        assert definition.meaning


def test_every_quantity_rests_on_sums_that_a_trial_has(walked):
    sums = walked.sums()
    assert {definition.sums for definition in DEFINITIONS.values()} <= sums.keys()
    assert [q.name for q in walked.summary()][: len(DEFINITIONS) - 4] == list(DEFINITIONS)[:-4]


def test_all_sums_are_blocks_of_finite_numbers(walked):
    for name, rows in walked.sums().items():
        assert rows.ndim == 2, name
        assert np.isfinite(rows).all(), name


def test_a_setting_holds_wherever_it_counts(walked):
    sums = Sums([walked.sums()])
    strict = replace(sums, settings=EstimateSettings(minimum_n=10**9))
    for quantity in quantities(strict):
        if not quantity.name.startswith(("frames_", "search_")) and quantity.name != "w_s":
            assert quantity.why.startswith("not enough data"), quantity.name


def test_where_noise_is_known_from_few_contacts_it_may_be_too_large(walked):
    """Just below the limit, ten contacts leave in doubt what ten thousand do not."""
    lag_s = walked.correlation().lag_s
    for contacts, told in ((10.0, False), (10_000.0, True)):
        noise = contacts * np.array([[1.0, 0.38 * 1.2e-4, 1.2e-4]])
        sums = Sums([{**walked.sums(), "radius_noise": noise}], lag_s=lag_s)
        found = {q.name: q for q in quantities(sums)}
        assert (found["d_c"].value is not None) is told, found["d_c"].why
        noise_mm = found["radius_noise"]
        assert noise_mm.value == pytest.approx(0.0456)
        assert noise_mm.low < noise_mm.value < noise_mm.high


def test_no_noise_is_told_to_be_0(walked):
    noise = np.array([[10.0, 0.0, 10 * 1.2e-4]])
    sums = Sums([{**walked.sums(), "radius_noise": noise}], lag_s=walked.correlation().lag_s)
    found = {q.name: q for q in quantities(sums)}
    assert found["radius_noise"].value is None
    assert "less than a sixtieth" in found["radius_noise"].why
    assert found["d_c"].value is not None


@pytest.mark.parametrize(
    "changed",
    [
        {"most_noise_for_states": -1.0},
        {"fewest_stretches": 5},
        {"tail_in_t_per": (1.0, 3.0)},
        {"jackknife": JackknifeSettings(fewest_blocks=100)},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_a_test_can_change_a_setting(walked, changed):
    trial = (
        Sums([walked.sums()], lag_s=walked.correlation().lag_s, settings=s)
        for s in (EstimateSettings(), EstimateSettings(**changed))
    )
    before, after = (quantities(sums) for sums in trial)
    assert before != after
