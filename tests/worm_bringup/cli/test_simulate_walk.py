"""`worm simulate --model walk`: what is given comes out of the analysis, and a worm gets out."""

import json
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

from worm_bringup.cli.app import main


@pytest.fixture
def walk(monkeypatch, capsys, tmp_path):
    """Return a function that makes tables of a walk; it gives their directory and what is said."""

    def run(*words):
        out = tmp_path / "walk"
        given = ("--model", "walk", "--tracks-only", "--fps", 5, "--out", out, *words)
        monkeypatch.setattr(sys, "argv", ["worm", "simulate", *map(str, given)])
        with pytest.raises(SystemExit) as ended:
            main()
        assert not ended.value.code
        return out, capsys.readouterr()

    return run


@pytest.mark.parametrize(
    ("seed", "given"),
    [
        pytest.param(7, {}, id="the paper's"),
        pytest.param(
            2,
            {"speed-mm-s": 4, "slide-mm": 4, "hop-mm": 2.5, "excursion-mm": 0.6, "reversal": 0.2},
            id="others",
        ),
    ],
)
def test_what_is_given_lies_in_the_intervals_that_are_found(walk, seed, given):
    words = [word for name, value in given.items() for word in (f"--{name}", value)]
    out, _ = walk("--minutes", 4, "--exit-width-mm", 0, "--seed", seed, *words)
    found = json.loads((out / "summary.json").read_text())["quantities"]
    for option, default, name in (
        ("speed-mm-s", 2.02, "v_w"),
        ("slide-mm", 1.95, "d_c"),
        ("hop-mm", 1.46, "d_nc"),
        ("excursion-mm", 1.14, "delta_r_h"),
        ("reversal", 0.057, "reversal_per_cycle"),
    ):
        quantity = found[name]
        assert quantity["low"] < given.get(option, default) < quantity["high"], name
    tracks = pq.read_table(out / "tracks.parquet").to_pydict()
    assert set(tracks["where"]) == {"chamber_a"}
    assert len(tracks["where"]) == 4 * 60 * 5
    assert not pq.read_table(out / "passages.parquet")["success"].drop_null().to_pylist()


def test_a_worm_that_finds_the_exit_gets_out_and_the_trial_ends_there(walk):
    out, said = walk("--minutes", 3, "--exit-width-mm", 2, "--seed", 4)
    where = pq.read_table(out / "tracks.parquet")["where"].to_pylist()
    seconds = len(where) / 5
    assert f"The worm is out after {seconds:.1f} s" in said.out
    assert f"{len(where)}/{len(where)}" in said.err
    visit, attempt = pq.read_table(out / "passages.parquet").to_pylist()
    inside = np.flatnonzero(np.array(where) == "passage")
    assert visit["record"] == "visit"
    assert visit["tau_h_s"] == pytest.approx(inside[0] / 5, abs=1.0)
    assert (attempt["record"], attempt["success"]) == ("attempt", True)
    assert len(inside) == len(where) - inside[0]
    assert seconds < 60
