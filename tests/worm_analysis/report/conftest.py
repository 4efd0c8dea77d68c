"""A simulated trial with all in it, and its page."""

import pytest
from report_page import report_of
from report_trial import record, states, telegraph_walk, without_chamber

from worm_analysis.report import write_report


@pytest.fixture(scope="session")
def whole(tmp_path_factory):
    """A results directory of a simulated trial, with everything in it."""
    comparison, correlation = telegraph_walk(0.1)
    return record(
        tmp_path_factory.mktemp("whole") / "trial",
        states(),
        comparison=comparison,
        model_correlation=correlation,
    )


@pytest.fixture(scope="session")
def page(whole):
    return write_report(whole).read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def page_without_chamber(tmp_path_factory):
    directory = tmp_path_factory.mktemp("bare") / "trial"
    return report_of(record(directory, without_chamber(states()), chamber=False))
