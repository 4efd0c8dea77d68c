"""A deformable body of known length and width, fitted to a mask that may touch or cross itself.

Where a body coils, its contour has no two ends and no two sides. The midline of the frame before
still explains the mask: its direction is written as a short cosine series along the body, its
picture is that of everything within half a width of the midline, and series, position and (within
a few per cent) length are moved by damped Gauss-Newton steps until picture and mask agree.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_msgs_py.compiled import array_read, array_written, compiled, compiled_for
from worm_tracker.midline.curve import TRACKED_POINTS, arc_length, as_complex, resample, unit_grid

_MOST_COSINES = 24
"""Cosine terms of the direction along a long body; a stout one bends in fewer ways."""
_SUBSTEPS = 3
"""Sub-steps between midline points when distances are measured."""
_FINE_POINTS = (TRACKED_POINTS - 1) * _SUBSTEPS + 1
"""Points of the fine curve."""
_MOST_PIXELS = 3500
_BLOCK_NODES = 8
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
    shown = np.asarray(target > 0).view(np.uint8)
    half = np.interp(unit_grid(_FINE_POINTS), unit_grid(TRACKED_POINTS), widths) / 2
    for softness in settings.edge_softness_widths:
        for _ in range(settings.steps_per_softness):
            body = _step(body, prior, target, shown, half, softness * middle, settings)
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
        moves = np.zeros((_FINE_POINTS, 2, len(self.values)))
        moves[:, [0, 1], [0, 1]] = 1.0
        _fill_moves(d, across, _BASIS, moves)
        return moves


@compiled_for(
    array_read(types.float64, 2),
    array_read(types.float64, 2),
    array_read(types.float64, 2),
    array_written(types.float64, 3),
)
def _fill_moves(segments: Floats, across: Floats, basis: Floats, moves: Floats) -> None:
    """Fill in how points move with the stretch and each term; the curve's middle stays."""
    nodes, _, values = moves.shape
    for axis in range(2):
        for value in range(2, values):
            total, at = 0.0, 0.0
            for k in range(nodes - 1):
                by = segments[k, axis] if value == 2 else across[k, axis] * basis[k, value - 3]
                at += by
                total += at
                moves[k + 1, axis, value] = at
            for k in range(nodes):
                moves[k, axis, value] -= total / nodes


def _step(
    body: _Series,
    prior: Floats,
    target: Floats32,
    shown: Picture,
    half: Floats,
    soft: float,
    settings: BodyFitSettings,
) -> _Series:
    """Take one damped Gauss-Newton step."""
    curve = body.points()
    pixels, weight = _sampled_pixels(shown, curve, float(half.max()))
    nearest, pull = np.empty(len(pixels), np.intp), np.empty((len(pixels), 2))
    residual = np.empty(len(pixels))
    _pull(target, pixels, as_complex(curve), half, soft, nearest, pull, residual)
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


@compiled
def _blocks_of_nodes(curve: Complex) -> tuple[Complex, Floats]:
    """Return the middle of each block of neighbouring nodes, and how far the others are from it."""
    count = -(-len(curve) // _BLOCK_NODES)
    middles, reach = np.empty(count, np.complex128), np.zeros(count)
    for block in range(count):
        first, stop = block * _BLOCK_NODES, min((block + 1) * _BLOCK_NODES, len(curve))
        middles[block] = curve[(first + stop) // 2]
        for k in range(first, stop):
            reach[block] = max(reach[block], abs(curve[k] - middles[block]))
    return middles, reach


@compiled
def _squared_distance(at: complex, other: complex) -> float:
    du, dv = at.real - other.real, at.imag - other.imag
    return du * du + dv * dv


@compiled
def _nearest_node(
    curve: Complex, middles: Complex, reach: Floats, away: Floats, at: complex, guess: int
) -> int:
    """Return the node of a curve nearest to a point: a guess, or one in a block that comes near.

    The block whose middle is nearest is looked at first, so that few others come near enough.
    """
    nearest_block = 0
    for block in range(len(middles)):
        away[block] = _squared_distance(at, middles[block])
        if away[block] < away[nearest_block]:
            nearest_block = block
    best, least2 = guess, _squared_distance(at, curve[guess])
    least = np.sqrt(least2)
    for turn in range(-1, len(middles)):
        block = nearest_block if turn < 0 else turn
        if away[block] >= (least + reach[block]) ** 2 or turn == nearest_block:
            continue
        for k in range(block * _BLOCK_NODES, min((block + 1) * _BLOCK_NODES, len(curve))):
            away2 = _squared_distance(at, curve[k])
            if away2 < least2:
                best, least2 = k, away2
        least = np.sqrt(least2)
    return best


@compiled
def _inner_tangents(curve: Complex) -> Complex:
    """Return the unit tangents of a curve's segments at their first nodes; 0 at its two ends."""
    tangents = np.zeros(len(curve), np.complex128)
    for node in range(1, len(curve) - 1):
        segment = curve[node + 1] - curve[node]
        tangents[node] = segment / max(abs(segment), 1e-9)
    return tangents


@compiled_for(
    array_read(types.float32, 2),
    array_read(types.int32, 2),
    array_read(types.complex128),
    array_read(types.float64),
    types.float64,
    array_written(types.intp),
    array_written(types.float64, 2),
    array_written(types.float64),
)
def _pull(
    target: Floats32,
    pixels: NDArray[np.int32],
    curve: Complex,
    half: Floats,
    soft: float,
    nearest: NDArray[np.intp],
    pull: Floats,
    residual: Floats,
) -> None:
    """Fill in what each pixel's misfit does to the body.

    Its nearest node, how its drawn shade changes with where that node is, and how much darker it is
    than drawn.
    """
    middles, reach = _blocks_of_nodes(curve)
    tangents = _inner_tangents(curve)
    blocks_away, node = np.empty(len(middles)), 0
    for j in range(len(pixels)):
        at = complex(pixels[j, 0], pixels[j, 1])
        node = _nearest_node(curve, middles, reach, blocks_away, at, node)
        away = at - curve[node]
        away -= (away * tangents[node].conjugate()).real * tangents[node]
        distance = np.sqrt(away.real * away.real + away.imag * away.imag)
        drawn = 1 / (1 + np.exp(min(max((distance - half[node]) / soft, -30.0), 30.0)))
        by = drawn * (1 - drawn) / soft / max(distance, 1e-6)
        nearest[j], pull[j, 0], pull[j, 1] = node, by * away.real, by * away.imag
        residual[j] = target[pixels[j, 1], pixels[j, 0]] - drawn


def _normal_equations(
    moves: Floats, nearest: NDArray[np.intp], pull: Floats, residual: Floats
) -> tuple[Floats, Floats]:
    """Return JᵀJ and Jᵀr of all pixels, summed up node by node of the curve before by value.

    A pixel's row of J is the derivative of its nearest node, shape (2, values), times its pull: so
    what all pixels of a node add is that derivative about the sum of their pulls' products, and the
    matrix of all pixels, ten times as long, is never made.
    """
    values = moves.shape[2]
    matrix, gradient = np.zeros((values, values)), np.zeros(values)
    _sum_up(moves, nearest, pull, residual, matrix, gradient)
    return matrix, gradient


@compiled_for(
    array_read(types.float64, 3),
    array_read(types.intp),
    array_read(types.float64, 2),
    array_read(types.float64),
    array_written(types.float64, 2),
    array_written(types.float64),
)
def _sum_up(
    moves: Floats,
    nearest: NDArray[np.intp],
    pull: Floats,
    residual: Floats,
    matrix: Floats,
    gradient: Floats,
) -> None:
    """Add up the normal equations, whose matrix and gradient are zero before."""
    nodes, _, values = moves.shape
    sums = np.zeros((nodes, 5))
    for j in range(len(nearest)):
        u, v, of_node = pull[j, 0], pull[j, 1], sums[nearest[j]]
        of_node[0] += u * u
        of_node[1] += u * v
        of_node[2] += v * v
        of_node[3] += u * residual[j]
        of_node[4] += v * residual[j]
    for node in range(nodes):
        uu, uv, vv, along_u, along_v = sums[node]
        du, dv = moves[node, 0], moves[node, 1]
        for k in range(values):
            gradient[k] += along_u * du[k] + along_v * dv[k]
            by_u, by_v = uu * du[k] + uv * dv[k], uv * du[k] + vv * dv[k]
            for other in range(k + 1):
                matrix[k, other] += by_u * du[other] + by_v * dv[other]
    for k in range(values):
        for other in range(k):
            matrix[other, k] = matrix[k, other]


def _sampled_pixels(shown: Picture, curve: Floats, half: float) -> tuple[NDArray[np.int32], float]:
    """Return the pixels (u, v) on or near mask and body, and how many each one stands for."""
    near = shown.copy()
    line = [np.rint(curve * 16).astype(np.int32)]
    cv2.polylines(near, line, False, 1, max(1, round(4 * half)), shift=4)
    at = cv2.findNonZero(near)
    pixels = np.zeros((0, 2), np.int32) if at is None else np.asarray(at, np.int32).reshape(-1, 2)
    stride = max(1, -(-len(pixels) // _MOST_PIXELS))
    return pixels[::stride], float(stride)
