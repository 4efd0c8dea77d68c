"""The largest connected piece of a mask."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from worm_tracker.midline.largest_piece import largest_piece


def test_an_empty_mask_has_no_piece() -> None:
    assert not len(largest_piece(np.zeros((4, 6), np.uint8)))


def test_pieces_are_joined_at_corners() -> None:
    mask = np.zeros((9, 12), np.uint8)
    mask[5, 4] = mask[6, 5] = mask[1, 9] = 1
    assert largest_piece(mask).tolist() == [4 + 5j, 5 + 6j]


@pytest.mark.parametrize("seed", range(20))
def test_it_is_that_of_the_whole_mask_even_among_equal_ones(seed: int) -> None:
    random = np.random.default_rng(seed)
    mask = (random.random(random.integers(1, 40, 2)) < 0.2).astype(np.uint8)
    mask[: random.integers(0, 5), :] = mask[:, : random.integers(0, 5)] = 0
    assert np.array_equal(largest_piece(mask), _of_the_whole(mask))


def _of_the_whole(mask: NDArray[np.uint8]) -> NDArray[np.complex128]:
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    if count < 2:
        return np.zeros(0, np.complex128)
    rows, columns = np.nonzero(labels == 1 + stats[1:, cv2.CC_STAT_AREA].argmax())
    return np.asarray(columns + 1j * rows, np.complex128)
