"""The example bags are what `bags/build.py` makes, byte for byte, and what their README says."""

import importlib.util
import sys
import zipfile
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from rosbags.rosbag2 import Reader

from worm_model.simulator.film import encode

BAGS = Path(__file__).parents[2] / "bags"


@pytest.fixture(scope="module")
def build():
    spec = importlib.util.spec_from_file_location("bags_build", BAGS / "build.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def larva_truth():
    return pq.read_table(BAGS / "larva_truth.parquet")


def stamps(bag):
    with Reader(bag) as reader:
        return [stamp for _, stamp, _ in reader.messages()]


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE).astype(int)


def test_larva_film_is_drawn_again_with_the_same_pictures(build, larva_truth):
    """Bytes are the same on one machine; another processor may round a few pixels otherwise."""
    film = list(islice(build.larva_film(6), 6))
    kept = build.jpegs_of_bag(BAGS / "larva")
    for frame in film:
        again = decoded(encode(frame.picture, build.LARVA_JPEG_QUALITY))
        difference = np.abs(again - decoded(kept[frame.truth.frame]))
        assert (difference > 0).mean() < 0.01
        assert difference.max() < 12
    row = larva_truth.slice(5, 1).to_pylist()[0]
    assert row["head_u_px"] == pytest.approx(film[5].truth.head_u_px, abs=1e-6)
    assert row["midline_v_px"] == pytest.approx(film[5].truth.midline_v_px, abs=1e-6)


def test_larva_bag_and_truth_have_the_same_frames(larva_truth):
    assert stamps(BAGS / "larva") == larva_truth["stamp_ns"].to_pylist()
    assert larva_truth["frame"].to_pylist() == list(range(800))
    assert np.diff(larva_truth["stamp_ns"]).tolist() == [62_500_000] * 799


def test_larva_stays_in_the_chamber_touches_the_wall_and_crawls_forwards(larva_truth):
    columns = {name: larva_truth[name].to_numpy() for name in ("r_h_mm", "r_c_mm", "r_t_mm")}
    assert max(columns["r_h_mm"].max(), columns["r_t_mm"].max()) < 10.0
    assert columns["r_h_mm"].max() > 9.9
    assert set(larva_truth["where"].to_pylist()) == {"chamber_a"}
    x, y, head_x, head_y = (
        larva_truth[name].to_numpy()
        for name in ("centroid_x_mm", "centroid_y_mm", "head_x_mm", "head_y_mm")
    )
    step = 16  # one second
    advance = (x[step:] - x[:-step]) * (head_x - x)[:-step]
    advance += (y[step:] - y[:-step]) * (head_y - y)[:-step]
    assert (advance > 0).mean() > 0.85


def test_larvas_head_and_tail_never_change_places(larva_truth):
    head, tail = (
        np.stack([larva_truth[f"{end}_{axis}_px"].to_numpy() for axis in "uv"], axis=1)
        for end in ("head", "tail")
    )
    assert np.hypot(*np.diff(head, axis=0).T).max() < 30.0
    assert np.hypot(*np.diff(tail, axis=0).T).max() < 30.0


def test_wormtracer_bag_is_rebuilt_from_itself(build, tmp_path):
    build.build_wormtracer(tmp_path / "wormtracer", frames=20)
    made, kept = (
        build.jpegs_of_bag(tmp_path / "wormtracer"),
        build.jpegs_of_bag(BAGS / "wormtracer"),
    )
    assert made == kept[:20]
    assert stamps(tmp_path / "wormtracer") == stamps(BAGS / "wormtracer")[:20]


def test_wormtracer_has_1500_frames_at_66_hz_and_a_mask_for_each(build):
    assert stamps(BAGS / "wormtracer") == [round(k * 1e9 / 66) for k in range(1500)]
    picture = cv2.imdecode(
        np.frombuffer(build.jpegs_of_bag(BAGS / "wormtracer")[700], np.uint8), cv2.IMREAD_GRAYSCALE
    )
    with zipfile.ZipFile(BAGS / "wormtracer_masks.zip") as masks:
        names = sorted(masks.namelist())
        mask = cv2.imdecode(np.frombuffer(masks.read(names[700]), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert len(names) == 1500
    assert mask.shape == picture.shape == (221, 255)
    inside = mask == mask[mask.shape[0] // 2 :].max()
    rarer = inside if inside.mean() < 0.5 else ~inside
    assert picture[rarer].mean() > 1.5 * picture[~rarer].mean()
