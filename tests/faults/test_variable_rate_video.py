"""A video of variable rate is played, and stamped, by the times of its own frames."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mjpeg_server import jpeg_picture, number_in
from variable_rate_video import write_video

from worm_tracker.sources.cameras.camera import Camera
from worm_tracker.sources.cameras.film_pace import FilmPace

DURATIONS_S = [0.02, 0.3, 0.05, 0.4, 0.03, 0.1]


def test_frames_bear_the_times_of_their_container(tmp_path):
    pictures = [jpeg_picture(number) for number in range(len(DURATIONS_S))]
    camera = Camera(write_video(tmp_path / "film.mp4", pictures, DURATIONS_S))
    frames = []
    camera._put = frames.append  # each of them, whoever takes them
    camera.begin()
    camera._thread.join()
    assert [number_in(frame.picture) for frame in frames] == list(range(len(pictures)))
    seconds = np.diff([frame.stamp_ns for frame in frames]) / 1e9
    np.testing.assert_allclose(seconds, DURATIONS_S[:-1], atol=2e-3)
    assert camera.pace.guessed == 0


@given(st.lists(st.floats() | st.floats(0, 100), max_size=40))
def test_whatever_a_container_says_times_grow(container_s):
    pace = FilmPace(25.0)
    due_s = [pace.due_s(second) for second in container_s]
    assert all(math.isfinite(second) for second in due_s)
    assert all(a < b for a, b in itertools.pairwise(due_s))


def test_a_video_without_times_is_played_at_its_rate():
    pace = FilmPace(25.0)
    assert [pace.due_s(0.0) for _ in range(3)] == pytest.approx([0.0, 0.04, 0.08])
    assert pace.guessed == 2
