"""The table of quantities is whole: each has a name of its own, words, and sums to rest on."""

from dataclasses import replace

import numpy as np
import pytest
from walked_tracks import GEOMETRY, slides_and_hops

from worm_analysis.analysis import Analysis
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
