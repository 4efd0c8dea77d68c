"""The centroid by columns and rows is the one that OpenCV's moments give."""

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from worm_tracker.midline.mask_centroid import mask_centroid

MASKS = arrays(
    np.uint8,
    array_shapes(min_dims=2, max_dims=2, max_side=60),
    elements=st.sampled_from([0, 255]),
)


@given(mask=MASKS)
def test_sums_of_columns_and_rows_give_what_moments_give(mask):
    moments = cv2.moments(mask, binaryImage=True)
    area = max(moments["m00"], 1.0)
    assert mask_centroid(mask) == (moments["m10"] / area, moments["m01"] / area)
