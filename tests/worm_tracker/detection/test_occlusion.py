"""Fragments of a worm are reconnected where something may occlude it, and nowhere else."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_tracker.detection.blobs import BlobSettings, find_blobs, whole_picture
from worm_tracker.detection.occlusion import OccludedView, OcclusionSettings, reconnect

WIDTH, LEVEL, SHAPE = 12.0, 140.0, (300, 400)


def wave(phase, s):
    """Return a winding body's points at these places along it, shape (n, 2)."""
    return np.stack([40.0 + s, 150.0 + 25.0 * np.sin(s / 55.0 + phase)], axis=1)


def drawn(*lines):
    """Return the signal of bodies."""
    signal = np.zeros(SHAPE, np.uint8)
    for line in lines:
        fine = np.rint(16 * line).astype(np.int32)
        cv2.polylines(signal, [fine], False, LEVEL, round(WIDTH), cv2.LINE_AA, 4)
    return signal


def reconnected(signal, occluder, length=0.0, body=None):
    blobs = find_blobs(signal, 0.4 * LEVEL, whole_picture(SHAPE), BlobSettings())
    return reconnect(
        blobs, OccludedView(signal, occluder, WIDTH, length, LEVEL, body, OcclusionSettings())
    )


def box(u0, u1):
    occluder = np.zeros(SHAPE, np.uint8)
    occluder[:, round(u0) : round(u1)] = 255
    return occluder


LONG = float(np.hypot(*np.diff(wave(0.0, np.linspace(0, 300, 400)), axis=0).T).sum())


@settings(max_examples=30, deadline=None)
@given(st.floats(0.0, 6.3), st.floats(90.0, 190.0), st.floats(20.0, 55.0))
def test_a_body_cut_by_glare_is_joined_along_its_own_curve(phase, start, gap):
    one, other = (
        wave(phase, np.linspace(0, start, 60)),
        wave(phase, np.linspace(start + gap, 300, 60)),
    )
    found = reconnected(drawn(one, other), box(36 + start, 44 + start + gap))
    assert found is not None
    assert found.occluded_ends == (False, False)
    (bridge,) = found.bridges
    real = wave(phase, np.linspace(0, 300, 2000))
    away = np.hypot(*(bridge[:, None] - real[None]).T).min(axis=0)
    assert away.max() < 0.35 * WIDTH


def test_two_objects_are_not_joined_where_the_picture_can_tell():
    signal = drawn(wave(0.0, np.linspace(0, 120, 60)), wave(0.0, np.linspace(160, 300, 60)))
    assert reconnected(signal, np.zeros(SHAPE, np.uint8)) is None


def test_a_piece_beside_it_that_would_be_a_hairpin_is_not_reconnected():
    beside = np.stack([np.linspace(60, 170, 60), np.full(60, 110.0)], axis=1)
    found = reconnected(drawn(wave(0.0, np.linspace(0, 120, 60)), beside), box(150, 260))
    assert found is None or not found.bridges


@pytest.mark.parametrize("length", [0.0, LONG])
def test_an_end_that_fades_into_glare_is_hidden(length):
    body = wave(0.0, np.linspace(0, 300, 400))
    occluder = box(240, 340)
    signal = drawn(body)
    fade = np.clip((240.0 - np.arange(SHAPE[1])) / 60.0 + 1.0, 0.0, 1.0)
    found = reconnected((signal * fade).astype(np.uint8), occluder, length, body)
    assert found.occluded_ends.count(True) == 1
    end = found.ends[found.occluded_ends.index(True)]
    assert 200 < end[0] < 300
    if length:  # supposed to go on as it did, by what is missing
        (onward,) = found.bridges
        away = np.hypot(*(onward[:, None] - body[None]).T).min(axis=0)
        assert away.max() < 0.35 * WIDTH


def test_a_tip_that_is_dark_up_to_its_edge_is_seen_also_beside_glare():
    body = wave(0.0, np.linspace(0, 190, 200))
    long = float(np.hypot(*np.diff(body, axis=0).T).sum()) + WIDTH
    assert reconnected(drawn(body), box(228, 330), long, body) is None
