"""Which pixels of a picture are the object's."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.detection.blobs import BlobSettings, find_blobs, whole_picture
from worm_tracker.detection.detection import Detection, SignalView

MIDDLE, RADIUS, THICK, LEVEL = (60, 64), 40, 9, 100


def detected(signal):
    """Return the detection of the largest object in a window that is all of a picture."""
    window = whole_picture(signal.shape)
    blob = find_blobs(signal, LEVEL / 2, window, BlobSettings())[0]
    return Detection(SignalView(window, signal, signal, LEVEL / 2, 1.0, BlobSettings()), blob)


def loop():
    """Return a picture of a body that lies in a closed loop."""
    signal = np.zeros((130, 124), np.uint8)
    cv2.circle(signal, MIDDLE, RADIUS, LEVEL, THICK)
    return signal


@given(
    away=st.floats(0.0, RADIUS - THICK - 4.0),
    towards=st.floats(0.0, 6.28),
    radius=st.integers(1, 3),
)
def test_a_speck_by_itself_in_the_hole_of_a_loop_is_none_of_the_object(away, towards, radius):
    signal = loop()
    at = (round(MIDDLE[0] + away * np.cos(towards)), round(MIDDLE[1] + away * np.sin(towards)))
    cv2.circle(signal, at, radius, LEVEL, -1)
    np.testing.assert_array_equal(detected(signal).object_pixels() > 0, loop() > 0)


@pytest.mark.parametrize("inwards_px", [-3, 3])
def test_what_touches_the_loop_is_of_the_object_on_either_side_of_it(inwards_px):
    signal = loop()
    at = MIDDLE[0] + RADIUS - inwards_px, MIDDLE[1]
    cv2.circle(signal, at, 7, LEVEL, -1)
    np.testing.assert_array_equal(detected(signal).object_pixels() > 0, signal > 0)


def test_what_was_raised_to_find_a_pale_end_is_object_and_no_signal():
    signal = np.zeros((80, 160), np.uint8)
    signal[35:45, 20:90], signal[35:45, 90:130] = LEVEL, LEVEL // 3
    raised = np.where(signal == LEVEL // 3, LEVEL, signal).astype(np.uint8)
    view = replace(detected(signal).view, raised=raised)
    whole = Detection(view, view.blobs()[0])
    left = np.zeros_like(signal)
    left[:, :120] = 255
    for seen, length in ((whole, 110), (whole.restricted_to(left), 100), (whole.cropped(5), 110)):
        assert cv2.countNonZero(seen.object_pixels()) == 10 * length
        assert np.count_nonzero(seen.view.smooth == LEVEL // 3) == 10 * (length - 70)
