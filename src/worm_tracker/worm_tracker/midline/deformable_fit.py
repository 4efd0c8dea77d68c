"""A deformable body of known length and width, fitted to a mask that may touch or cross itself.

Where a body coils, its contour has no two ends and no two sides. The midline of the frame before
still explains the mask: its direction is written as a short cosine series along the body, its
picture is that of everything within half a width of the midline, and series, position and (within
a few per cent) length are moved by damped Gauss-Newton steps until picture and mask agree.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from worm_msgs_py.arrays import Floats, Floats32, Picture
from worm_tracker.midline.curve import TRACKED_POINTS, arc_length, resample

_MOST_COSINES = 24
"""Cosine terms of the direction along a long body; a stout one bends in fewer ways."""
_SUBSTEPS = 3
"""Sub-steps between midline points when distances are measured."""
_FINE_POINTS = (TRACKED_POINTS - 1) * _SUBSTEPS + 1
"""Points of the fine curve."""
_MOST_PIXELS = 3500
_BLOCK_ROWS = 128
_BASIS = np.cos(
    np.pi
    * ((np.arange(_FINE_POINTS - 1) + 0.5) / (_FINE_POINTS - 1))[:, None]
    * np.arange(_MOST_COSINES)[None]
)


@dataclass(frozen=True, slots=True)
class BodyFitSettings:
    """What a body may do between a prediction and the picture."""

    length_sd_relative: float = 0.05
    """How far, relatively, the length may differ from what it was."""
    most_log_stretch: float = 0.06
    """Most that the log of the length may differ: a coil is covered as well by a body too long."""
    term_sd_rad: float = 0.5
    """How far the first term may move from the prediction; higher ones less, as a body is stiff."""
    pixel_sd: float = 0.5
    """Typical misfit of a pixel near the edge: weighs the picture against the prediction."""
    edge_softness_widths: tuple[float, ...] = (0.25, 0.12)
    """Softness of the body's edge, coarse and then fine: a soft edge pulls from farther off."""
    steps_per_softness: int = 4
    most_term_step_rad: float = 0.5
    """Most that a term moves in one step: the problem is linear no farther."""


def fit_body(
    mask: Picture,
    start: Floats,
    widths: Floats,
    length: float,
    settings: BodyFitSettings,
) -> Floats:
    """Fit a body to a mask.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object, holes open.
    start : ndarray, shape (TRACKED_POINTS, 2)
        Where the body is thought to be, window coordinates.
    widths : ndarray, shape (TRACKED_POINTS,)
        Known widths along the body.
    length : float
        Known length, pixels.
    settings : BodyFitSettings

    Returns
    -------
    ndarray, shape (TRACKED_POINTS, 2)
        The midline in window coordinates (u, v).
    """
    middle = float(np.median(widths))
    terms = int(np.clip(round(1.2 * length / middle) + 2, 8, _MOST_COSINES))
    body = _Series.of(start, length, terms)
    prior = body.values.copy()
    prior[2] = 0.0
    target = np.asarray(cv2.GaussianBlur(mask, (3, 3), 0) / np.float32(255), np.float32)
    grid = np.linspace(0, 1, _FINE_POINTS)
    half = np.interp(grid, np.linspace(0, 1, TRACKED_POINTS), widths) / 2
    for softness in settings.edge_softness_widths:
        for _ in range(settings.steps_per_softness):
            body = _step(body, prior, target, half, softness * middle, settings)
    return body.points()[::_SUBSTEPS]


@dataclass(frozen=True, eq=False, slots=True)
class _Series:
    """A curve by numbers: u and v of its middle, log of its stretch, terms of its direction."""

    values: Floats
    length: float

    @classmethod
    def of(cls, points: Floats, length: float, count: int) -> "_Series":
        fine = resample(points, _FINE_POINTS)
        d = np.diff(fine, axis=0)
        angle = np.unwrap(np.arctan2(d[:, 1], d[:, 0]))
        terms = np.linalg.lstsq(_BASIS[:, :count], angle, rcond=None)[0]
        stretch = np.clip(np.log(arc_length(points)[-1] / length), -0.1, 0.1)
        return cls(np.concatenate([fine.mean(0), [stretch], terms]), length)

    def segments(self) -> tuple[Floats, Floats]:
        """Return the fine segments and their normals times their length, shape (n − 1, 2) each."""
        angle = _BASIS[:, : len(self.values) - 3] @ self.values[3:]
        step = self.length * np.exp(self.values[2]) / (_FINE_POINTS - 1)
        d = step * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return d, np.stack([-d[:, 1], d[:, 0]], axis=1)

    def points(self) -> Floats:
        """Return the fine curve, shape (fine points, 2)."""
        d, _ = self.segments()
        curve = np.concatenate([np.zeros((1, 2)), np.cumsum(d, axis=0)])
        return np.asarray(curve - curve.mean(0) + self.values[:2])

    def derivative(self) -> Floats:
        """Return how each point moves with each value, shape (fine points, 2, values)."""
        d, across = self.segments()
        basis = _BASIS[:, None, : len(self.values) - 3]
        moves = np.concatenate([d[:, :, None], across[:, :, None] * basis], axis=2)
        moves = np.concatenate([np.zeros((1, *moves.shape[1:])), np.cumsum(moves, axis=0)])
        moves -= moves.mean(0)
        shift = np.broadcast_to(np.eye(2), (_FINE_POINTS, 2, 2))
        return np.concatenate([shift, moves], axis=2)


def _step(
    body: _Series,
    prior: Floats,
    target: Floats32,
    half: Floats,
    soft: float,
    settings: BodyFitSettings,
) -> _Series:
    """Take one damped Gauss-Newton step."""
    curve = body.points()
    pixels, weight = _sampled_pixels(target, curve, float(half.max()))
    nearest = np.asarray(cKDTree(curve).query(pixels)[1], np.intp)
    away = pixels - curve[nearest]
    tangent, _ = body.segments()
    within = (nearest > 0) & (nearest < _FINE_POINTS - 1)
    t = tangent[np.minimum(nearest, _FINE_POINTS - 2)]
    t = t / np.maximum(np.hypot(t[:, 0], t[:, 1]), 1e-9)[:, None]
    away -= np.where(within, (away * t).sum(1), 0.0)[:, None] * t
    distance = np.hypot(away[:, 0], away[:, 1])
    drawn = 1 / (1 + np.exp(np.clip((distance - half[nearest]) / soft, -30, 30)))
    slope = drawn * (1 - drawn) / soft
    pull = away * (slope / np.maximum(distance, 1e-6))[:, None]
    residual = target[pixels[:, 1], pixels[:, 0]] - drawn
    hessian, gradient = _normal_equations(body.derivative(), nearest, pull, residual)
    terms = ((1 + 0.3 * np.arange(len(prior) - 3)) / settings.term_sd_rad) ** 2
    stiffness = np.concatenate([[1e-3, 1e-3, settings.length_sd_relative**-2], terms])
    stiffness = stiffness * settings.pixel_sd**2 / weight
    matrix = hessian + np.diag(stiffness + 1e-6)
    ahead = gradient + stiffness * (prior - body.values)
    step = np.linalg.solve(matrix, ahead)
    step *= min(1.0, float(half.max()) / max(float(np.abs(step[:2]).max()), 1e-9))
    step[3:] = np.clip(step[3:], -settings.most_term_step_rad, settings.most_term_step_rad)
    values = body.values + step
    most = settings.most_log_stretch
    values[2] = min(max(values[2], -most), most)
    return _Series(values, body.length)


def _normal_equations(
    moves: Floats, nearest: NDArray[np.intp], pull: Floats, residual: Floats
) -> tuple[Floats, Floats]:
    """Return JᵀJ and Jᵀr of all pixels, summed up node by node of the curve before by value.

    A pixel's row of J is the derivative of its nearest node, shape (2, values), times its pull: so
    what all pixels of a node add is that derivative about the sum of their pulls' products, and the
    matrix of all pixels, ten times as long, is never made.
    """
    nodes = len(moves)
    u, v = pull.T
    uu, uv, vv, ru, rv = (
        np.bincount(nearest, of_pixel, nodes)[:, None]
        for of_pixel in (u * u, u * v, v * v, u * residual, v * residual)
    )
    du, dv = moves[:, 0], moves[:, 1]
    pulled = np.concatenate([uu * du + uv * dv, uv * du + vv * dv])
    gradient = (ru * du + rv * dv).sum(axis=0)
    return _product(np.concatenate([du, dv]), pulled), gradient


def _product(a: Floats, b: Floats) -> Floats:
    """Return aᵀb, in blocks that the linear algebra library does not spread over threads.

    Waking threads for so small a product takes far longer than the product.
    """
    rows = -(-len(a) // _BLOCK_ROWS) * _BLOCK_ROWS
    blocks = []
    for matrix in (a, b):
        padded = np.zeros((rows, matrix.shape[1]))
        padded[: len(matrix)] = matrix
        blocks.append(padded.reshape(-1, _BLOCK_ROWS, matrix.shape[1]))
    return np.asarray(np.matmul(blocks[0].transpose(0, 2, 1), blocks[1]).sum(0))


def _sampled_pixels(
    target: Floats32, curve: Floats, half: float
) -> tuple[NDArray[np.int64], float]:
    """Return the pixels (u, v) on or near mask and body, and how many each one stands for."""
    near = (target > 0).astype(np.uint8)
    line = [np.rint(curve * 16).astype(np.int32)]
    cv2.polylines(near, line, False, 1, max(1, round(4 * half)), shift=4)
    pixels = np.asarray(cv2.findNonZero(near), np.int64).reshape(-1, 2)
    stride = max(1, -(-len(pixels) // _MOST_PIXELS))
    return pixels[::stride], float(stride)
