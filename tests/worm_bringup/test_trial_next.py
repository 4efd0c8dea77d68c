"""Live trials follow one another without writing over anything."""

from pathlib import Path

import pytest

from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.trial import Trial, next_trial


def live(record=None):
    given = {"camera": "0"} | ({"record": str(record)} if record else {})
    return Trial(NodeSpec("module", "image_source", given), {"camera": "0"})


def test_results_and_record_have_the_next_number_that_neither_has(tmp_path):
    out, record = tmp_path / "out", tmp_path / "films" / "today"
    first = live(record)
    second, into = next_trial(first, out)
    assert (into, second.source.parameters["record"]) == (tmp_path / "out-2", f"{record}-2")
    into.mkdir()
    Path(f"{record}-3").mkdir(parents=True)
    third, into = next_trial(first, out)
    assert (into, third.source.parameters["record"]) == (tmp_path / "out-4", f"{record}-4")
    assert first.source.parameters["record"] == str(record)


@pytest.mark.parametrize("with_out", [True, False])
def test_what_is_not_kept_needs_no_name(tmp_path, with_out):
    out = tmp_path / "out" if with_out else None
    after, into = next_trial(live(), out)
    assert into == (tmp_path / "out-2" if with_out else None)
    assert after == live()
