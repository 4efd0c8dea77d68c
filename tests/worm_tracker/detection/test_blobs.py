"""What of an object may be a part of a worm, by its shape alone."""

import cv2
import numpy as np
import pytest

from worm_tracker.detection.blobs import BlobSettings, holds_wormlike_piece


@pytest.mark.parametrize(
    ("size", "worm"), [((60, 10), True), ((60, 5), False), ((10, 10), False), ((20, 10), False)]
)
def test_a_piece_is_wormlike_where_it_is_long_and_as_thick_as_the_worm(size, worm):
    mask = np.zeros((100, 100), np.uint8)
    cv2.rectangle(mask, (20, 40), (20 + size[0] - 1, 40 + size[1] - 1), 255, -1)
    assert holds_wormlike_piece(mask, 10.0, BlobSettings()) is worm
