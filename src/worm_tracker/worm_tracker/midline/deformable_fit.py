"""A deformable body of known length and width, fitted to a mask that may touch or cross itself.

Where a body coils, its outline has no two ends and no two sides. The midline of the frame before,
carried on, still explains the mask: its direction is written as a short cosine series along the
body, its picture is that of everything within half a width of the midline, and series, position and
(within a few per cent) length are moved by damped Gauss-Newton steps until picture and mask agree.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from worm_tracker.midline.contour_midline import POINTS, arc_length, resample

Floats = NDArray[np.float64]

MOST_TERMS = 24
"""Cosine terms of the direction along a slender body; a stout one bends in fewer ways."""
FINE = 3
"""Sub-steps between midline points when distances are measured."""
MAX_PIXELS = 3500
BLOCK = 128
LENGTH_SD = 0.05
"""How far, relatively, the length may differ from what it was."""
MOST_STRETCH = 0.06
"""Most that the log of the length may differ: a coil is covered as well by a body too long."""
TERM_SD = 0.5
"""How far a term may move from the prediction, radians over its number."""
PIXEL_SD = 0.5
"""Typical misfit of a pixel near the edge: weighs the picture against the prediction."""
SOFT = ((0.25, 4), (0.12, 4))
"""Softness of the body's edge, in widths, and steps taken with it: coarse, then fine."""

COUNT = (POINTS - 1) * FINE + 1
"""Points of the fine curve."""
_BASIS = np.cos(
    np.pi * ((np.arange(COUNT - 1) + 0.5) / (COUNT - 1))[:, None] * np.arange(MOST_TERMS)[None]
)
_STIFF = ((1 + 0.3 * np.arange(MOST_TERMS)) / TERM_SD) ** 2


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """A fitted body.

    Attributes
    ----------
    points : ndarray, shape (POINTS, 2)
        The midline in window coordinates (u, v).
    overlap : float
        Intersection over union of the drawn body and the mask.
    """

    points: Floats
    overlap: float


def fit_body(mask: NDArray[np.uint8], start: Floats, widths: Floats, length: float) -> Fit:
    """Fit a body to a mask.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object, holes open.
    start : ndarray, shape (POINTS, 2)
        Where the body is thought to be, window coordinates.
    widths : ndarray, shape (POINTS,)
        Known widths along the body.
    length : float
        Known length, pixels.
    """
    terms = int(np.clip(round(1.2 * length / float(np.median(widths))) + 2, 8, MOST_TERMS))
    body = _Series.of(start, length, terms)
    prior = body.values.copy()
    prior[2] = 0.0
    target = np.asarray(cv2.GaussianBlur(mask, (3, 3), 0) / np.float32(255), np.float32)
    half = np.interp(np.linspace(0, 1, COUNT), np.linspace(0, 1, POINTS), widths) / 2
    middle = float(np.median(widths))
    for soft, steps in SOFT:
        for _ in range(steps):
            body = _step(body, prior, target, half, soft * middle)
    points = body.points()[::FINE]
    return Fit(points, overlap(mask, points, widths))


def overlap(mask: NDArray[np.uint8], points: Floats, widths: Floats) -> float:
    """Return intersection over union of a mask and the body with this midline and these widths."""
    drawn = draw_body(mask.shape, points, widths)
    both = cv2.countNonZero(cv2.bitwise_and(mask, drawn))
    either = cv2.countNonZero(cv2.bitwise_or(mask, drawn))
    return both / max(either, 1)


def draw_body(shape: tuple[int, ...], points: Floats, widths: Floats) -> NDArray[np.uint8]:
    """Draw the body as a mask; it may cross itself."""
    drawn = np.zeros(shape, np.uint8)
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-9)[:, None]
    side = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1) * np.maximum(widths, 1.0)[:, None] / 2
    left = np.rint((points + side) * 16).astype(np.int32)
    right = np.rint((points - side) * 16).astype(np.int32)
    for k in range(len(points) - 1):
        quad = np.array([left[k], left[k + 1], right[k + 1], right[k]])
        cv2.fillConvexPoly(drawn, quad, 255, shift=4)
    return drawn


@dataclass(frozen=True, eq=False, slots=True)
class _Series:
    """A curve by numbers: u and v of its middle, log of its stretch, terms of its direction."""

    values: Floats
    length: float

    @classmethod
    def of(cls, points: Floats, length: float, count: int) -> "_Series":
        fine = resample(points, COUNT)
        d = np.diff(fine, axis=0)
        angle = np.unwrap(np.arctan2(d[:, 1], d[:, 0]))
        terms = np.linalg.lstsq(_BASIS[:, :count], angle, rcond=None)[0]
        stretch = np.clip(np.log(arc_length(points)[-1] / length), -0.1, 0.1)
        return cls(np.concatenate([fine.mean(0), [stretch], terms]), length)

    def segments(self) -> tuple[Floats, Floats]:
        """Return the fine segments and their normals times their length, (COUNT − 1, 2) each."""
        angle = _BASIS[:, : len(self.values) - 3] @ self.values[3:]
        step = self.length * np.exp(self.values[2]) / (COUNT - 1)
        d = step * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return d, np.stack([-d[:, 1], d[:, 0]], axis=1)

    def points(self) -> Floats:
        """Return the fine curve, shape (COUNT, 2)."""
        d, _ = self.segments()
        curve = np.concatenate([np.zeros((1, 2)), np.cumsum(d, axis=0)])
        return np.asarray(curve - curve.mean(0) + self.values[:2])

    def derivative(self) -> Floats:
        """Return how each point moves with each value, shape (COUNT, 2, number of values)."""
        d, across = self.segments()
        basis = _BASIS[:, None, : len(self.values) - 3]
        moves = np.concatenate([d[:, :, None], across[:, :, None] * basis], axis=2)
        moves = np.concatenate([np.zeros((1, *moves.shape[1:])), np.cumsum(moves, axis=0)])
        moves -= moves.mean(0)
        shift = np.broadcast_to(np.eye(2), (COUNT, 2, 2))
        return np.concatenate([shift, moves], axis=2)


def _step(
    body: _Series, prior: Floats, target: NDArray[np.float32], half: Floats, soft: float
) -> _Series:
    """Take one damped Gauss-Newton step."""
    curve = body.points()
    pixels, weight = _pixels(target, curve, float(half.max()))
    distance, nearest = cKDTree(curve).query(pixels)
    away = pixels - curve[nearest]
    tangent, _ = body.segments()
    within = (nearest > 0) & (nearest < COUNT - 1)
    t = tangent[np.minimum(nearest, COUNT - 2)]
    t = t / np.maximum(np.hypot(t[:, 0], t[:, 1]), 1e-9)[:, None]
    away -= np.where(within, (away * t).sum(1), 0.0)[:, None] * t
    distance = np.hypot(away[:, 0], away[:, 1])
    drawn = 1 / (1 + np.exp(np.clip((distance - half[nearest]) / soft, -30, 30)))
    slope = drawn * (1 - drawn) / soft
    pull = away * (slope / np.maximum(distance, 1e-6))[:, None]
    jacobian = np.einsum("pk,pkv->pv", pull, body.derivative()[nearest])
    residual = target[pixels[:, 1], pixels[:, 0]] - drawn
    stiffness = (
        np.concatenate([[1e-3, 1e-3, LENGTH_SD**-2], _STIFF[: len(prior) - 3]])
        * PIXEL_SD**2
        / weight
    )
    matrix = _square(jacobian) + np.diag(stiffness + 1e-6)
    ahead = jacobian.T @ residual + stiffness * (prior - body.values)
    step = np.linalg.solve(matrix, ahead)
    step *= min(1.0, float(half.max()) / max(float(np.abs(step[:2]).max()), 1e-9))
    step[3:] = np.clip(step[3:], -0.5, 0.5)
    values = body.values + step
    values[2] = min(max(values[2], -MOST_STRETCH), MOST_STRETCH)
    return _Series(values, body.length)


def _square(jacobian: Floats) -> Floats:
    """Return JᵀJ, in blocks that the linear algebra library does not spread over threads.

    Waking threads for so small a product takes far longer than the product.
    """
    count, values = jacobian.shape
    padded = np.zeros((-(-count // BLOCK) * BLOCK, values))
    padded[:count] = jacobian
    blocks = padded.reshape(-1, BLOCK, values)
    return np.asarray(np.matmul(blocks.transpose(0, 2, 1), blocks).sum(0))


def _pixels(
    target: NDArray[np.float32], curve: Floats, half: float
) -> tuple[NDArray[np.int64], float]:
    """Return the pixels (u, v) on or near mask and body, and how many each one stands for."""
    near = (target > 0).astype(np.uint8)
    line = [np.rint(curve * 16).astype(np.int32)]
    cv2.polylines(near, line, False, 1, max(1, round(4 * half)), shift=4)
    v, u = np.nonzero(near)
    stride = max(1, -(-len(u) // MAX_PIXELS))
    return np.stack([u, v], axis=1)[::stride].astype(np.int64), float(stride)
