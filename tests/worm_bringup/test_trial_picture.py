"""The picture that a report opens with is the frame of the bag itself, or there is none."""

import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from report_trial import record, states
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from worm_analysis.results import read_results
from worm_analysis.results.picture import read_kept_picture
from worm_bringup.trial_picture import keep_picture
from worm_msgs_py.files.frame_pictures import frame_picture_path, frame_pictures

BAG = "bags/larva"


@pytest.fixture(scope="module")
def filmed():
    """Stamps and pictures of the bag's first 200 frames, by a reader that is not ours."""
    with AnyReader([Path(BAG)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        found = []
        for connection, _, raw in reader.messages(reader.connections[:1]):
            message = reader.deserialize(raw, connection.msgtype)
            stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            found.append((stamp_ns, message))
            if len(found) == 200:
                break
    return found


@pytest.fixture(scope="module")
def trial(filmed, tmp_path_factory):
    """Results whose frames have the stamps of the bag's pictures."""
    stamped = [
        (replace(state, stamp_ns=stamp_ns), midline)
        for (state, midline), (stamp_ns, _) in zip(states(30.0), filmed, strict=False)
    ]
    return record(tmp_path_factory.mktemp("kept") / "trial", stamped)


def pixels(message):
    data = np.asarray(message.data)
    if hasattr(message, "format"):
        return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    return data.reshape(message.height, message.step)[:, : message.width]


def test_the_picture_is_the_bags_own_frame(trial, filmed, tmp_path):
    directory = tmp_path / "trial"
    shutil.copytree(trial, directory)
    assert keep_picture(directory, {"bag": BAG}) == ""
    results = read_results(directory)
    kept = read_kept_picture(directory, results)
    truth = pixels(filmed[int(results.tracks["frame"][kept.row])][1])
    np.testing.assert_array_equal(np.rint(kept.grey * 255).astype(np.uint8), truth)
    assert len(kept.midline_u_px) > 10


def test_the_record_of_a_live_trial_gives_the_same_picture_as_the_bag(trial, tmp_path):
    pictures = []
    for name in ("bag", "record"):
        directory = tmp_path / name
        shutil.copytree(trial, directory)
        driver = {"topic": "/camera/image_raw"} if name == "record" else {}
        assert keep_picture(directory, {name: BAG, **driver}) == ""
        (path,) = directory.glob("report_frame_*.png")
        pictures.append((path.name, path.read_bytes()))
    assert pictures[0] == pictures[1]


def test_after_a_start_offset_the_frame_is_the_same(filmed, tmp_path):
    """The trial begins 100 pictures later; its stamps are still the bag's."""
    later = [stamp_ns for stamp_ns, _ in filmed[100:]]
    stamped = [
        (replace(state, stamp_ns=stamp_ns), midline)
        for (state, midline), stamp_ns in zip(states(30.0), later, strict=False)
    ]
    directory = record(tmp_path / "trial", stamped)
    offset_s = (filmed[100][0] - filmed[0][0]) / 1e9
    assert keep_picture(directory, {"bag": BAG, "start_offset": offset_s}) == ""
    kept = read_kept_picture(directory, read_results(directory))
    np.testing.assert_array_equal(
        np.rint(kept.grey * 255).astype(np.uint8), pixels(filmed[100 + kept.row][1])
    )


def test_of_the_pictures_that_a_live_trial_kept_the_best_one_is_left(trial, tmp_path):
    directory = tmp_path / "trial"
    shutil.copytree(trial, directory)
    tracks = read_results(directory).tracks
    frames = [0, 8, 64, int(np.flatnonzero(tracks["contact"] == 1.0)[0])]
    for frame in frames:
        cv2.imwrite(str(frame_picture_path(directory, frame)), np.zeros((4, 4), np.uint8))
    assert keep_picture(directory, {"camera": "0", "pictures": str(directory)}) == ""
    (left,) = frame_pictures(directory)
    assert tracks["contact"][left] == 1.0
    assert left in frames


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ({}, "the pictures were not recorded"),
        ({"camera": "0"}, "the pictures were not recorded"),
        ({"bag": "gone"}, "gone"),
    ],
)
def test_without_the_pictures_the_results_are_left_as_they_are(trial, source, why):
    before = sorted(item.name for item in trial.iterdir())
    assert why in keep_picture(trial, source)
    assert sorted(item.name for item in trial.iterdir()) == before


def test_a_picture_of_another_time_is_never_shown(tmp_path):
    later = [(replace(state, stamp_ns=state.stamp_ns + 1), line) for state, line in states(20.0)]
    other = record(tmp_path / "trial", later)
    assert "no picture of the bag was taken at" in keep_picture(other, {"bag": BAG})
    assert not list(other.glob("*.png"))
