"""`worm analyse`: tracks of any tracker give what `worm replay` gives, or one line says why not."""

import hashlib
import json
import sys
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from escaping_worm import LEAN, L, R, Worm, escaping_worm, write_table
from possible_values import impossible
from walked_tracks import GEOMETRY, rough_track

from worm_analysis.analysis import Analysis
from worm_bringup.cli.app import main
from worm_bringup.recorder.recording import Recording
from worm_msgs_py import Midline

command = sys.modules["worm_bringup.cli.analyse"]  # the package has a function of this name
WORM = Worm(exit_width_mm=2.0, seed=4)


@pytest.fixture
def worm_and_report(monkeypatch, capsys):
    """Return a function that runs `worm analyse` and gives exit status and what it printed."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["worm", "analyse", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code or 0, capsys.readouterr().err

    return run


@pytest.fixture
def worm(worm_and_report, monkeypatch):
    """The same without drawing the report, which has tests of its own."""
    monkeypatch.setattr(command, "write_report", lambda directory: directory / "report.html")
    return worm_and_report


@pytest.fixture(scope="module")
def columns():
    return escaping_worm(WORM, duration_s=600.0, fps=10.0)


def results(directory):
    summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    assert impossible(summary) == []
    tables = {
        name: pq.read_table(directory / f"{name}.parquet").to_pydict()
        for name in ("tracks", "contacts", "passages")
    }
    return summary, tables


def same(first, second, *, angle_deg=False):
    """Return whether two columns agree; numbers to rounding, as millimetres are not metres."""
    if all(value is None or isinstance(value, float) for value in (*first, *second)):
        numbers = [np.array(column, dtype=float) for column in (first, second)]
        if angle_deg:
            numbers = [np.exp(1j * np.radians(column)) for column in numbers]
        return np.allclose(*numbers, rtol=1e-9, atol=1e-9, equal_nan=True)
    return first == second


def replayed(directory, seed):
    """What the graph writes of a worm that goes everywhere: with pixels, gaps and both chambers.

    Of a fifth of the frames contact cannot be told.
    """
    directory.mkdir()
    analysis, recording = Analysis(), Recording(directory)
    analysis.set_geometry(GEOMETRY)
    states = [
        replace(state, head_sd_m=2e-4 if state.frame % 100 > 80 else 0.0)
        for state in rough_track(seed, n=1500).each_state()
    ]
    for state in states:
        observables, events = analysis.push(state)
        recording.add_state(state)
        recording.add_midline(Midline.empty())
        recording.add_observables(observables)
        recording.add_events(events)
    recording.add_events(analysis.finish())
    recording.trial.frames_read = len(states)
    recording.trial.geometry = GEOMETRY
    recording.trial.quantities = tuple(analysis.summary())
    recording.finish({})
    return directory


@pytest.mark.parametrize("seed", [3, 8])
def test_tracks_of_a_replay_give_the_same_contacts_and_passages(worm, tmp_path, seed):
    first = replayed(tmp_path / "first", seed)
    assert worm(first / "tracks.parquet", "--out", tmp_path / "again")[0] == 0
    (before, tables), (after, again) = results(first), results(tmp_path / "again")
    assert len(tables["contacts"]["kind"]) > 20
    assert len(tables["passages"]["record"]) > 2
    assert after["quantities"]["search_contact_untold"]["value"] > 0.1
    for name, table in tables.items():
        for column, values in table.items():
            assert same(values, again[name][column]), f"{name}: {column}"
    assert after["geometry"] == before["geometry"]
    for name, quantity in before["quantities"].items():
        assert same([quantity["value"]], [after["quantities"][name]["value"]]), name


def test_the_files_are_those_of_a_replay_without_the_bag(worm_and_report, tmp_path, columns):
    table = write_table(tmp_path / "worm.parquet", columns)
    assert worm_and_report(table, "--out", tmp_path / "out", "--exit-width-mm", 2)[0] == 0
    assert {item.name for item in (tmp_path / "out").iterdir()} == {
        "tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet",
        "summary.json", "report.html", "figures",
    }  # fmt: skip
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Table of tracks" in page
    assert "worm.parquet" in page


def test_rows_that_are_missing_are_counted_and_said(worm_and_report, tmp_path, columns):
    some = {name: np.delete(values, [500, 501, 3000]) for name, values in columns.items()}
    table = write_table(tmp_path / "worm.parquet", some)
    status, _ = worm_and_report(table, "--out", tmp_path / "out", "--exit-width-mm", 2)
    assert status == 0
    summary, _ = results(tmp_path / "out")
    (event,) = summary["source_events"]
    assert (event["kind"], event["count"], event["frame"]) == ("missing_rows", 3, 500)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "about 3 rows are missing from the table, at 2 places, up to 0.3 s" in page


def test_csv_and_parquet_give_the_same_bytes(worm, tmp_path, columns):
    for suffix in ("csv", "parquet"):
        table = write_table(tmp_path / f"worm.{suffix}", columns)
        assert worm(table, "--out", tmp_path / suffix, "--exit-width-mm", 2)[0] == 0
    for name in ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet"):
        first, second = ((tmp_path / suffix / name).read_bytes() for suffix in ("csv", "parquet"))
        assert first == second, name


def test_the_worms_own_laws_are_found(worm, tmp_path, columns):
    """Both chambers are told apart by x alone; every search ends at the exit."""
    table = write_table(tmp_path / "worm.parquet", columns)
    assert worm(table, "--out", tmp_path / "out", "--exit-width-mm", 2)[0] == 0
    summary, tables = results(tmp_path / "out")
    found = summary["quantities"]
    assert set(tables["passages"]["chamber"]) == {"chamber_a", "chamber_b"}
    assert found["psi_b_positive_peak"]["value"] == pytest.approx(np.degrees(LEAN), abs=4)
    assert found["psi_b_negative_peak"]["value"] == pytest.approx(-np.degrees(LEAN), abs=4)
    assert found["d_c"]["low"] < WORM.slide_mm < found["d_c"]["high"]
    assert found["success"]["low"] < WORM.success < found["success"]["high"]
    assert found["w_s"]["value"] == pytest.approx(2.5)
    assert summary["geometry"]["chamber_a"]["depth_mm"] == 1.5
    assert summary["geometry"]["chamber_b"]["passage_length_mm"] == L
    assert summary["geometry"]["chamber_a"]["centre_u_px"] is None
    assert max(tables["tracks"]["r_h_mm"]) < 1.1 * (R + L)


def test_mirrored_and_turned_tables_are_the_same_worm(worm, tmp_path, columns):
    """A table in other coordinates, with the options that say so, gives the same numbers."""
    turn, centre = np.radians(-70.0), np.array([31.0, -4.0])
    other = dict(columns)
    for point in ("head", "centroid", "tail"):
        x, y = columns[f"{point}_x_mm"], columns[f"{point}_y_mm"]
        right, up = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
        other[f"{point}_x_mm"], other[f"{point}_y_mm"] = right + centre[0], -up + centre[1]
    other["head_yaw_deg"] = -(columns["head_yaw_deg"] - 70.0)
    tables = []
    for name, changed, options in (
        ("plain", columns, []),
        ("turned", other, ["--centre-mm", 31, -4, "--exit-deg", -70, "--y-down"]),
    ):
        table = write_table(tmp_path / f"{name}.parquet", changed)
        out = tmp_path / name
        assert worm(table, "--out", out, "--exit-width-mm", 2, *options)[0] == 0
        tables.append(results(out)[1])
    for column in ("psi_b_deg", "psi_h_deg", "theta_h_rad", "r_h_mm", "contact", "where"):
        first, second = (table["tracks"][column] for table in tables)
        assert same(first, second, angle_deg=column.endswith("deg")), column
    assert same(tables[0]["passages"]["tau_h_s"], tables[1]["passages"]["tau_h_s"])


def test_pixels_of_a_picture_are_the_same_worm(worm, tmp_path, columns):
    in_pixels = {name: values for name, values in columns.items() if not name.endswith("_mm")}
    chamber = replace(GEOMETRY.chambers[0], exit_width_m=2e-3)
    for point in ("head", "centroid", "tail"):
        metres = (columns[f"{point}_{axis}_mm"] / 1e3 for axis in "xy")
        in_pixels[f"{point}_u_px"], in_pixels[f"{point}_v_px"] = chamber.to_pixels(*metres)
    table = write_table(tmp_path / "pixels.parquet", in_pixels)
    plain = write_table(tmp_path / "plain.parquet", columns)
    common = ["--exit-width-mm", 2, "--body-width-mm", 0.4]
    circle = [chamber.centre_u_px, chamber.centre_v_px, chamber.radius_px]
    given = ["--circle-px", *circle, "--exit-deg", np.degrees(chamber.exit_rad)]
    assert worm(table, "--out", tmp_path / "a", *common, *given)[0] == 0
    assert worm(plain, "--out", tmp_path / "b", *common)[0] == 0
    (summary, first), (_, second) = results(tmp_path / "a"), results(tmp_path / "b")
    for column in ("psi_b_deg", "theta_h_rad", "r_h_mm", "contact", "where"):
        pair = first["tracks"][column], second["tracks"][column]
        assert same(*pair, angle_deg=column.endswith("deg")), column
    assert summary["geometry"]["chamber_a"]["px_per_mm"] == pytest.approx(chamber.px_per_m / 1e3)
    assert first["tracks"]["head_u_px"] == pytest.approx(in_pixels["head_u_px"].tolist())


def test_what_the_table_lacks_is_null_and_says_why(worm, tmp_path, columns):
    kept = ("time_s", "head_x_mm", "head_y_mm")
    table = write_table(tmp_path / "head.csv", {name: columns[name] for name in kept})
    assert worm(table, "--out", tmp_path / "out")[0] == 0
    summary, tables = results(tmp_path / "out")
    for name, reason in {
        "d_c": "--body-width-mm", "tau_h": "--body-width-mm", "w_s": "--exit-width-mm",
        "success": "centroid_x_mm", "v_w": "centroid_x_mm", "r_t_over_R": "tail_x_mm",
        "l_w": "length_mm",
    }.items():  # fmt: skip
        quantity = summary["quantities"][name]
        assert quantity["value"] is None, name
        assert reason in quantity["why"], name
    assert summary["quantities"]["r_h_over_R"]["value"] == pytest.approx(1.0, abs=0.02)
    assert (
        set(tables["tracks"]["psi_b_deg"]) == {None}
        or np.isnan(np.array(tables["tracks"]["psi_b_deg"], dtype=float)).all()
    )
    assert summary["frames"] == {"read": 6000, "tracked": 6000}


@pytest.mark.parametrize("points", [("head",), ("head", "centroid")], ids="+".join)
def test_a_table_without_all_points_has_a_report(worm_and_report, tmp_path, columns, points):
    kept = ["time_s", "width_mm", *(f"{point}_{axis}_mm" for point in points for axis in "xy")]
    table = write_table(tmp_path / "some.csv", {name: columns[name] for name in kept})
    status, said = worm_and_report(table, "--out", tmp_path / "out", "--exit-width-mm", 2)
    assert status == 0, said
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "give tail_x_mm" in page
    assert "Densities of the distance from the centre" in page


def test_every_parameter_and_the_tables_hash_are_in_the_provenance(worm, tmp_path, columns):
    table = write_table(tmp_path / "worm.csv", columns)
    worm(table, "--out", tmp_path / "out", "--exit-width-mm", 2, "--contact-factor", 0.4)
    told = results(tmp_path / "out")[0]["provenance"]
    assert told["source"] == {
        "table": "worm.csv", "sha256": hashlib.sha256(table.read_bytes()).hexdigest(),
    }  # fmt: skip
    assert told["parameters"]["analysis"]["contact_factor"] == 0.4
    assert told["parameters"]["rig"]["exit_width_mm"] == 2.0
    assert told["parameters"]["model"]["rule"] == "per_cycle"


def csv_with(**changed):
    """Return a maker of a CSV file of ten rows in which columns are changed or left out."""

    def make(folder):
        whole = {
            "time_s": [f"{0.1 * k:.1f}" for k in range(10)],
            "head_x_mm": ["9.9"] * 10,
            "head_y_mm": ["0.1"] * 10,
        } | changed
        names = [name for name, values in whole.items() if values is not None]
        rows = zip(*(whole[name] for name in names), strict=True)
        text = "\n".join(",".join(row) for row in [names, *rows])
        (folder / "bad.csv").write_text(text + "\n", encoding="utf-8")
        return folder / "bad.csv"

    return make


def text_file(name, text):
    def make(folder):
        (folder / name).write_text(text, encoding="utf-8")
        return folder / name

    return make


def half_a_parquet(folder):
    path = folder / "half.parquet"
    pq.write_table(pa.table({"time_s": np.arange(1e4)}), path)
    path.write_bytes(path.read_bytes()[:900])
    return path


def text_in_parquet(folder):
    path = folder / "text.parquet"
    pq.write_table(pa.table({"time_s": [0.0], "head_x_mm": ["far"], "head_y_mm": [1.0]}), path)
    return path


TEN = [f"{0.1 * k:.1f}" for k in range(10)]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        pytest.param(lambda folder: folder / "none.csv", "no such table", id="no file"),
        pytest.param(text_file("tracks.xlsx", "x"), "neither CSV nor Parquet", id="unknown type"),
        pytest.param(text_file("empty.csv", ""), "is empty", id="empty file"),
        pytest.param(text_file("h.csv", "time_s,head_x_mm,head_y_mm\n"), "no rows", id="no rows"),
        pytest.param(csv_with(head_y_mm=None), "no column head_y_mm", id="no head"),
        pytest.param(csv_with(time_s=None), "no column stamp_ns or time_s", id="no time"),
        pytest.param(
            csv_with(time_s=TEN[:5] + TEN[4:9]), "repeats the stamp of the row before in row 6",
            id="duplicate stamps",
        ),
        pytest.param(
            csv_with(time_s=TEN[:5] + TEN[3:8]), "goes back in time in row 6", id="unsorted"
        ),
        pytest.param(csv_with(time_s=[*TEN[:9], ""]), "'time_s' is empty in row 10", id="no stamp"),
        pytest.param(
            csv_with(head_x_mm=["9.9"] * 4 + ["wall"] + ["9.9"] * 5), "'head_x_mm' holds 'wall'",
            id="text in numbers",
        ),
        pytest.param(csv_with(head_x_mm=["inf"] * 10), "infinite number in row 1", id="infinite"),
        pytest.param(csv_with(status=["seen"] * 10), "'status' holds 'seen' in row 1", id="status"),
        pytest.param(csv_with(where=["left"] * 10), "'where' holds 'left' in row 1", id="where"),
        pytest.param(csv_with(head_x_mm=[""] * 10), "no row has a head", id="no worm at all"),
        pytest.param(csv_with(head_x_mm=["512"] * 10), "outside of the chamber", id="wrong units"),
        pytest.param(half_a_parquet, "cannot be read", id="half a Parquet file"),
        pytest.param(text_in_parquet, "'head_x_mm' holds text", id="text in Parquet"),
        pytest.param(
            text_file("r.csv", "time_s,head_x_mm,head_y_mm\n0,1,1\n1,2\n"), "Expected 3 columns",
            id="ragged rows",
        ),
    ],
)  # fmt: skip
def test_a_bad_table_is_refused_in_one_line(worm, tmp_path, make, said):
    path = make(tmp_path)
    before = sorted(tmp_path.iterdir())
    status, err = worm(path, "--out", tmp_path / "out")
    lines = [line for line in err.splitlines() if line.startswith("worm: ")]
    assert status == 2
    assert len(lines) == 1
    assert path.name in lines[0]
    assert said in lines[0]
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--circle-px", 9, 9, 9], "head_u_px"),
        (["--exit-width-mm", 30], "--exit-width-mm is 30 mm"),
    ],
)
def test_options_that_make_no_sense_are_refused(worm, tmp_path, columns, options, said):
    table = write_table(tmp_path / "worm.csv", columns)
    status, err = worm(table, "--out", tmp_path / "out", *options)
    assert (status, said in err) == (2, True)
    assert not (tmp_path / "out").exists()


def test_the_tracks_of_a_result_are_not_overwritten(worm, tmp_path):
    first = replayed(tmp_path / "first", 3)
    status, err = worm(first, "--out", first)
    assert status == 2
    assert "choose another --out" in err
    status, err = worm(first, "--out", tmp_path / "out", "--radius-mm", 5)
    assert (status, "leave out --radius-mm" in err) == (2, True)
