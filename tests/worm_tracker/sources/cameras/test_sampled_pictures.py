"""A few pictures of a live trial are kept, evenly spread, however long it is."""

import tempfile
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_msgs_py.files.frame_pictures import frame_pictures
from worm_tracker.sources.cameras.sampled_pictures import FIRST_STEP, MOST_SAMPLED, SampledPictures


def picture(frame):
    return np.full((4, 5), frame % 256, np.uint8)


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 3000))
def test_they_are_few_and_evenly_spread_over_the_trial(frames):
    with tempfile.TemporaryDirectory() as folder:
        sampled = SampledPictures(Path(folder))
        for frame in range(frames):
            sampled.take(frame, picture(frame))
        sampled.close()
        kept = frame_pictures(Path(folder))
        numbers = list(kept)
        assert len(numbers) <= MOST_SAMPLED
        assert len(numbers) >= min(MOST_SAMPLED // 2, -(-frames // FIRST_STEP))
        assert numbers[0] == 0
        assert len(set(np.diff(numbers))) <= 1
        for frame, path in kept.items():
            grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
            np.testing.assert_array_equal(grey, picture(frame))


def test_a_directory_that_cannot_be_written_costs_the_pictures_alone(tmp_path):
    sampled = SampledPictures(tmp_path / "gone")
    for frame in range(100):
        sampled.take(frame, picture(frame))
    sampled.close()
    assert not (tmp_path / "gone").exists()


@pytest.mark.parametrize(
    "name",
    ["report_frame_x.png", "report_frame_.png", "report_frame_000001.jpg", "frame_000001.png"],
)
def test_files_of_others_are_passed_over(tmp_path, name):
    (tmp_path / name).touch()
    assert frame_pictures(tmp_path) == {}
