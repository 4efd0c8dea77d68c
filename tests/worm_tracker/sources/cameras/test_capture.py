"""Grey pictures come as they are; colours become the grey levels that OpenCV makes of them."""

import cv2
import numpy as np
import pytest

from worm_tracker.sources.cameras.camera_address import Kind
from worm_tracker.sources.cameras.capture import grey, open_capture


@pytest.mark.parametrize(
    "shape", [pytest.param((48, 64), id="grey"), pytest.param((48, 64, 3), id="colour")]
)
def test_levels_are_those_of_the_picture_in_three_channels(tmp_path, shape):
    rng = np.random.default_rng(0)
    pictures = [cv2.blur(rng.integers(0, 256, shape, np.uint8), (5, 5)) for _ in range(3)]
    film = tmp_path / "film.mjpeg"
    film.write_bytes(b"".join(cv2.imencode(".jpg", one)[1].tobytes() for one in pictures))
    capture = open_capture(str(film), Kind.FILE, 5.0)
    as_ever = cv2.VideoCapture(str(film), cv2.CAP_FFMPEG)
    for _ in pictures:
        done, picture = capture.read()
        assert done
        assert picture.ndim == len(shape)
        assert np.array_equal(grey(picture), cv2.cvtColor(as_ever.read()[1], cv2.COLOR_BGR2GRAY))
    assert not capture.read()[0]
