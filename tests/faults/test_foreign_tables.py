"""Tables of other trackers in other units, and the truth of another trial, are refused."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from worm_bringup.tracks.track_table import TrackTable
from worm_model.evaluation import evaluate_tracks, frame_table_of
from worm_msgs_py.errors import BadInput, EvaluationError

N = 200


def columns(**changed):
    angle = np.linspace(0.0, 2.0, N)
    table = {
        "time_s": np.arange(N) / 30.0,
        "head_x_mm": 9.9 * np.cos(angle),
        "head_y_mm": 9.9 * np.sin(angle),
        "centroid_x_mm": 5.0 * np.cos(angle),
        "centroid_y_mm": 5.0 * np.sin(angle),
        "head_yaw_deg": np.degrees(angle),
    }
    return {name: changed.get(name, values) for name, values in table.items()} | changed


def read(folder, table):
    path = folder / "tracks.parquet"
    pq.write_table(pa.table(table), path)
    return sum(len(rows) for rows in TrackTable(path).rows())


def test_a_table_in_its_units_is_read(tmp_path):
    assert read(tmp_path, columns()) == N


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"time_s": np.arange(N) * 33.3}, "'time_s'.*33.3 s.*milliseconds, multiply.* by 0.001"),
        ({"time_s": np.arange(N) * 33.3e6}, "'time_s'.*nanoseconds"),
        ({"time_s": np.arange(N) * 3e-5}, "'time_s'.*3e-05 s"),
        ({"stamp_ns": np.arange(N) * 33}, "'stamp_ns'.*33 ns.*milliseconds.*1e.06"),
        ({"head_x_mm": np.tile([0.0, 500.0], N // 2)}, "'head_x_mm'.*15000 mm/s.*pixels"),
        ({"head_yaw_deg": np.linspace(0.0, 2.0, N)}, "'head_yaw_deg'.*radians"),
    ],
)
def test_numbers_in_another_unit_are_named_with_the_remedy(tmp_path, changed, said):
    with pytest.raises(BadInput, match=said) as refused:
        read(tmp_path, columns(**changed))
    assert "\n" not in str(refused.value)


def record(name, first_ns=0, phase=0.0, step_ns=33_333_333):
    angle = np.linspace(0.0, 2.0, N) + phase
    points = {}
    for point, reach in (("head", 400.0), ("centroid", 300.0), ("tail", 200.0)):
        points[f"{point}_u_px"] = list(512 + reach * np.cos(angle))
        points[f"{point}_v_px"] = list(512 + reach * np.sin(angle))
    stamps = first_ns + np.arange(N) * step_ns
    return frame_table_of(name, {"stamp_ns": list(stamps), "frame": list(range(N)), **points})


def test_the_truth_of_a_trial_is_compared():
    assert evaluate_tracks(record("tracks"), record("truth")).frames_in_common == N


@pytest.mark.parametrize(
    ("truth", "said"),
    [
        pytest.param(record("other", first_ns=1, step_ns=40_000_000), "at other times", id="times"),
        pytest.param(
            record("other", first_ns=150 * 33_333_333), "50 of 200 frames", id="a part of them"
        ),
        pytest.param(record("other", phase=2.5), "centroid is 5.. px", id="another worm"),
    ],
)
def test_the_truth_of_another_trial_is_refused_instead_of_compared(truth, said):
    with pytest.raises(EvaluationError, match=said):
        evaluate_tracks(record("tracks"), truth)
