"""A deformable body is fitted to an object; what the fit sums up is what its definition says."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from worm_tracker.midline.curve import TRACKED_POINTS, length_of
from worm_tracker.midline.deformable_fit import (
    BodyFitSettings,
    _normal_equations,
    _pull,
    _Series,
    fit_body,
)
from worm_tracker.midline.strand_drawing import StrandDrawingSettings, drawn_strands

WIDTH = 16.0


@given(seed=st.integers(0, 2**32 - 1), pixels=st.integers(0, 300))
def test_sums_over_nodes_are_those_over_pixels(seed, pixels):
    rng = np.random.default_rng(seed)
    nodes, values = 193, 12
    moves = rng.normal(size=(nodes, 2, values))
    nearest = rng.integers(0, nodes, pixels)
    pull, residual = rng.normal(size=(pixels, 2)), rng.normal(size=pixels)
    jacobian = np.einsum("pk,pkv->pv", pull, moves[nearest])
    matrix, gradient = _normal_equations(moves, nearest, pull, residual)
    assert_allclose(matrix, jacobian.T @ jacobian, atol=1e-9)
    assert_allclose(gradient, jacobian.T @ residual, atol=1e-9)


@given(seed=st.integers(0, 2**32 - 1), nodes=st.integers(2, 200))
def test_each_pixel_pulls_at_its_nearest_node(seed, nodes):
    rng = np.random.default_rng(seed)
    curve = np.cumsum(1.5 * np.exp(1j * np.cumsum(rng.normal(0.0, 0.3, nodes))))
    curve += 40 + 40j - curve.mean()
    target = rng.random((80, 80)).astype(np.float32)
    pixels = rng.integers(0, 80, (300, 2), np.int32)
    half = rng.uniform(2.0, 8.0, nodes)
    nearest, pull, residual = np.empty(300, np.intp), np.empty((300, 2)), np.empty(300)
    _pull(target, pixels, curve, half, 2.0, nearest, pull, residual)
    at = pixels[:, 0] + 1j * pixels[:, 1]
    away = np.abs(at[:, None] - curve)
    assert_allclose(away[np.arange(300), nearest], away.min(axis=1), rtol=1e-12)
    # By as much as is pulled the drawn shade changes where the body is moved.
    darker = np.empty(300)
    _pull(target, pixels, curve + 1e-5, half, 2.0, nearest.copy(), pull.copy(), darker)
    inner = (nearest > 0) & (nearest < nodes - 1)
    same = np.abs((residual - darker) / 1e-5 - pull[:, 0]) < 1e-3
    assert same[inner].sum() >= 0.9 * inner.sum()


@given(seed=st.integers(0, 2**32 - 1), value=st.integers(0, 14))
def test_points_move_with_each_value_as_their_derivative_says(seed, value):
    rng = np.random.default_rng(seed)
    values = np.concatenate([rng.uniform(50, 90, 2), rng.normal(0, 0.05, 1), rng.normal(0, 1, 12)])
    body, by = _Series(values, 320.0), 1e-5 * np.eye(len(values))[value]
    moved = (_Series(values + by, 320.0).points() - _Series(values - by, 320.0).points()) / 2e-5
    assert_allclose(body.derivative()[:, :, value], moved, atol=1e-4)


def test_a_body_that_has_swung_aside_is_found_again():
    part = np.linspace(0.0, 1.0, TRACKED_POINTS)
    line = np.stack([60 + 260 * part, 120 + 50 * np.sin(5 * part)], axis=1)
    widths = np.full(TRACKED_POINTS, WIDTH)
    drawn, *_ = drawn_strands((240, 380), line, widths, WIDTH, StrandDrawingSettings())
    before = line + np.stack([np.zeros_like(part), 8 * np.sin(3 * part)], axis=1)
    fitted = fit_body(drawn, before, widths, length_of(line), BodyFitSettings())
    off_before, off = (
        np.hypot(*np.moveaxis(each[:, None] - line, 2, 0)).min(axis=1) for each in (before, fitted)
    )
    assert np.median(off_before) > 0.25 * WIDTH
    assert np.median(off) < 0.1 * WIDTH
