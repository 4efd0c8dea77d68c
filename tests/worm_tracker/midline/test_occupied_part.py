"""The part of a mask that holds all of it tells as much of it as the mask does."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.detection.blobs import thickness
from worm_tracker.midline.occupied_part import occupied_part


def mask_of_discs(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    mask = np.zeros((60, 90), np.uint8)
    for _ in range(rng.integers(0, 4)):
        at = rng.integers(-5, 95), rng.integers(-5, 65)
        cv2.circle(mask, at, int(rng.integers(1, 12)), 255, -1)
    return mask


@given(seed=st.integers(0, 2**32 - 1))
def test_nothing_of_a_mask_is_left_out_and_a_pixel_is_kept_around_it(seed):
    mask = mask_of_discs(seed)
    part = occupied_part(mask)
    assert part.size
    assert np.count_nonzero(part) == np.count_nonzero(mask)
    padded = np.pad(mask, 1)
    if mask.any():
        rows, columns = (np.flatnonzero(padded.any(axis=axis)) for axis in (1, 0))
        expected = padded[rows[0] - 1 : rows[-1] + 2, columns[0] - 1 : columns[-1] + 2]
        inside = np.count_nonzero(expected)
        assert part.shape[0] <= expected.shape[0] <= part.shape[0] + 2
        assert inside == np.count_nonzero(part)


@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_thickest_in_a_mask_is_as_thick_however_much_water_is_around_it(seed):
    mask = mask_of_discs(seed)
    whole = max(2 * float(cv2.distanceTransform(mask, cv2.DIST_L2, 5).max()) - 1, 3.0)
    assert thickness(mask) == pytest.approx(whole)
