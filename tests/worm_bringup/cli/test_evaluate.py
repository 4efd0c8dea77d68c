"""`worm evaluate` prints what the evaluation finds, and refuses bad tables in one line."""

import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from worm_bringup.cli.app import app
from worm_model.simulator.film import write_film
from worm_model.simulator.rig import write_truth
from worm_model.simulator.scenes import Take, at_the_wall


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "truth.parquet"
    write_truth((frame.truth for frame in at_the_wall(Take(px_per_mm=8.0, frames=100))), path)
    return path


def run(*arguments):
    return CliRunner().invoke(app, ["evaluate", *map(str, arguments)], catch_exceptions=False)


def test_the_truth_against_itself_is_without_error(truth):
    done = run(truth, truth, "--json")
    assert done.exit_code == 0
    document = json.loads(done.stdout)
    assert document["frames"] == {"tracks": 100, "truth": 100, "common": 100}
    figures = document["figures"]
    assert figures["head_error_95"] == {"value": 0.0, "unit": "px", "n": 100}
    assert figures["chamber_a_radius_error"]["value"] == 0.0
    assert figures["where_agreement"]["value"] == 1.0
    assert figures["right_end_where_certain"]["why"] == "no column head_certainty"


def test_the_table_names_every_figure(truth):
    shown = run(truth, truth).stdout
    assert "100 frames in common" in shown
    for name in run_names(truth):
        assert name.replace("_", " ") in shown


def run_names(truth):
    return json.loads(run(truth, truth, "--json").stdout)["figures"]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        pytest.param(lambda path, truth: None, "no such file; give a table", id="no file"),
        pytest.param(lambda path, truth: path.write_text("{}"), "Parquet", id="another format"),
        pytest.param(
            lambda path, truth: pq.write_table(truth.drop_columns(["head_u_px"]), path),
            "no column head_u_px",
            id="a column is missing",
        ),
        pytest.param(
            lambda path, truth: pq.write_table(truth.slice(0, 0), path),
            "no frame in common",
            id="no rows",
        ),
    ],
)
def test_bad_tables_are_one_line_and_status_2(tmp_path, truth, make, words):
    wrong = tmp_path / "wrong.parquet"
    make(wrong, pq.read_table(truth))
    done = subprocess.run(
        [Path(sys.executable).with_name("worm"), "evaluate", wrong, truth],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert words in done.stderr
    assert "wrong.parquet" in done.stderr


def test_the_truth_beside_a_scenes_bag_has_the_geometry(tmp_path):
    film = list(at_the_wall(Take(px_per_mm=8.0, frames=3)))
    rows = pq.read_table(write_film(tmp_path / "bag", film)).to_pylist()
    assert [row["circle_radius_px"] for row in rows] == [80.0] * 3
    assert rows[1]["exit_deg"] == asdict(film[1].truth)["exit_deg"] == pytest.approx(27.0)
