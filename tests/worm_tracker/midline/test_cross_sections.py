"""Cross-sections sample a picture as OpenCV does, and find the edges of a drawn body."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from worm_tracker.midline.cross_sections import (
    Covers,
    CrossSectionSettings,
    _edge,
    _sample_across,
    cross_sections,
)

WIDTH, LEVEL = 14.0, 100.0


@given(seed=st.integers(0, 99), u=st.floats(-30.0, 110.0), v=st.floats(-30.0, 90.0))
@settings(max_examples=30)
def test_a_picture_is_sampled_as_by_opencv(seed, u, v):
    signal = np.random.default_rng(seed).integers(0, 256, (60, 80), np.uint8)
    path = u + 1j * v + 1.7 * np.exp(1j * seed) * np.arange(20)
    normal, offsets = np.exp(1j * np.arange(20.0)), np.arange(-6.0, 6.5, 0.5)
    found = np.empty((20, len(offsets)), np.float32)
    _sample_across(signal, path, normal, offsets, found)
    at = (path[:, None] + normal[:, None] * offsets).astype(np.complex64).view(np.float32)
    at = at.reshape(20, -1, 2)
    border = cv2.BORDER_CONSTANT
    by_opencv = cv2.remap(signal, at, None, cv2.INTER_LINEAR, borderMode=border).astype(float)
    assert np.abs(found - by_opencv).max() <= 1  # one grey level where it rounds a half otherwise
    assert (found != by_opencv).mean() < 0.01


@pytest.mark.parametrize("nowhere", [complex("nan"), complex("inf"), 1e300 - 1e300j])
def test_where_there_is_no_place_there_is_no_signal(nowhere):
    signal, found = np.full((60, 80), 200, np.uint8), np.empty((3, 5), np.float32)
    path = np.array([30 + 30j, nowhere, 40 + 30j])
    _sample_across(signal, path, np.full(3, 1j), np.arange(-2.0, 3.0), found)
    assert (found == np.array([[200.0], [0.0], [200.0]])).all()


@given(seed=st.integers(0, 99), tip=st.booleans(), outwards=st.sampled_from([-1, 1]))
@settings(max_examples=30)
def test_an_edge_is_the_fall_nearest_to_its_place_and_at_a_tip_the_first(seed, tip, outwards):
    rng = np.random.default_rng(seed)
    for _ in range(40):
        profile = rng.integers(0, 200, 49).astype(np.float32)
        height, half = rng.uniform(20.0, 180.0), rng.uniform(1.0, 20.0)
        edge = _edge(profile, outwards, height, half, tip)
        side = profile[24::outwards]
        falls = np.flatnonzero((side[:-1] >= height) & (side[1:] < height))
        if not falls.size:
            assert edge == np.inf
            continue
        assert_allclose(np.interp(edge, np.arange(25), side), height, atol=1e-3)
        place = 0.0 if tip else half - 0.5
        assert np.abs(np.floor(edge) - place) <= np.abs(falls - place).min() + 1e-9


def test_where_both_sides_of_an_edge_look_alike_it_is_not_told():
    line = 20 + 40j + 1.5 * np.arange(60)
    drawn = np.zeros((80, 140), np.uint8)
    drawn[33:48] = LEVEL
    n, none = len(line), Covers.none(60)
    body = np.full(n, WIDTH / 2), np.full(n, LEVEL), WIDTH, 5
    beyond = np.tile([False, True], (n, 1))
    covered = Covers(none.middle, none.either, none.inside, beyond, LEVEL, 0.0, 0.0)
    free, beside = (
        cross_sections(drawn, line, *body, covers, CrossSectionSettings())
        for covers in (none, covered)
    )
    inner = slice(8, -8)
    assert (beside.weight[inner] < free.weight[inner]).all()
    assert (beside.weight[inner] > 0).all()


@given(aside=st.floats(-2.0, 2.0), turn=st.floats(-0.02, 0.02))
@settings(max_examples=30)
def test_a_body_beside_a_path_is_where_it_was_drawn(aside, turn):
    heading = np.exp(1j * turn * np.arange(80))
    line = 60 + 60j + np.cumsum(1.5 * heading)
    points = np.stack([line.real, line.imag], axis=1)
    drawn = np.zeros((200, 240), np.uint8)
    fixed = np.rint(points * 16).astype(np.int32)
    cv2.polylines(drawn, [fixed], False, LEVEL, round(WIDTH), cv2.LINE_AA, 4)
    n = len(line)
    found = cross_sections(
        drawn,
        line - 1j * heading * aside,
        np.full(n, WIDTH / 2),
        np.full(n, LEVEL),
        WIDTH,
        10,
        Covers.none(n),
        CrossSectionSettings(),
    )
    inner = slice(12, -12)
    assert (found.weight[inner] > 0).all()
    assert_allclose(found.shift[inner], aside, atol=0.35)
