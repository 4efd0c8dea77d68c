"""One step of an elastic, nearly inextensible, overdamped filament between walls."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from worm_model.filament.walls import Walls, nearest_walls
from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.compiled import compiled

BAND_DIAGONALS = 6
"""Diagonals of the matrix from its middle on: a point's x and y, and those of its two neighbours
on one side."""
ACTIVE_SET_TRIES = 6
"""Solutions of one step until it is settled which points the walls hold."""


class Elasticity(NamedTuple):
    """What one step needs, over the drag along the body for each mm of length (ξ∥ = 1).

    Attributes
    ----------
    step_s : float
        Time step.
    rest_mm : float
        Mean length of a segment: the drag is that of the material, however long it is stretched.
    drag_ratio : float
        ξ⊥/ξ∥.
    bending : float
        B/ξ∥, mm⁴/s.
    stretching : float
        EA/ξ∥, mm²/s.
    wall : float
        Stiffness of the walls, mm/s for each mm: as good as hard.
    width_mm : float
        d_w; 0 lets strands of the body lie over each other.
    apart_mm : float
        Points nearer along the body than this do not push each other apart.
    overlap_part : float
        Part of an overlap of two strands by which each gives way in a step.
    """

    step_s: float
    rest_mm: float
    drag_ratio: float
    bending: float
    stretching: float
    wall: float
    width_mm: float
    apart_mm: float
    overlap_part: float


@compiled
def point_tangents(points: Floats, out: Floats) -> None:
    """Fill in the unit tangent at each point, towards the head."""
    n = len(points)
    for i in range(n):
        a, b = max(i - 1, 0), min(i + 1, n - 1)
        dx, dy = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1]
        norm = sqrt(dx * dx + dy * dy)
        out[i, 0], out[i, 1] = (dx / norm, dy / norm) if norm > 0.0 else (1.0, 0.0)


@compiled
def _add_block(matrix: Floats, i: int, j: int, xx: float, xy: float, yx: float, yy: float) -> None:
    """Add a block of the points i ≥ j to the lower band of a symmetric matrix."""
    d = 2 * (i - j)
    matrix[2 * j, d] += xx
    matrix[2 * j, d + 1] += yx
    matrix[2 * j + 1, d] += yy
    if i != j:
        matrix[2 * j + 1, d - 1] += xy


@compiled
def _add_drag(matrix: Floats, tangent: Floats, body: Elasticity) -> None:
    n = len(tangent)
    for i in range(n):
        length = body.rest_mm * (0.5 if i in (0, n - 1) else 1.0)
        each, more = length / body.step_s, (1.0 - body.drag_ratio) * length / body.step_s
        tx, ty = tangent[i, 0], tangent[i, 1]
        xy = more * tx * ty
        across = body.drag_ratio * each
        _add_block(matrix, i, i, across + more * tx * tx, xy, xy, across + more * ty * ty)


@compiled
def _add_stretching(
    matrix: Floats, force: Floats, points: Floats, rest: Floats, body: Elasticity
) -> None:
    for i in range(len(points) - 1):
        k = body.stretching / rest[i]
        dx, dy = points[i, 0] - points[i + 1, 0], points[i, 1] - points[i + 1, 1]
        length = sqrt(dx * dx + dy * dy)
        tx, ty = dx / length, dy / length
        pull = k * (length - rest[i])
        force[i, 0] -= pull * tx
        force[i, 1] -= pull * ty
        force[i + 1, 0] += pull * tx
        force[i + 1, 1] += pull * ty
        xx, xy, yy = k * tx * tx, k * tx * ty, k * ty * ty
        _add_block(matrix, i, i, xx, xy, xy, yy)
        _add_block(matrix, i + 1, i + 1, xx, xy, xy, yy)
        _add_block(matrix, i + 1, i, -xx, -xy, -xy, -yy)


@compiled
def _add_bending(
    matrix: Floats,
    force: Floats,
    points: Floats,
    tangent: Floats,
    curvature: Floats,
    rest: Floats,
    body: Elasticity,
) -> None:
    """Add the energy B/2 Σ|x₋ − 2x + x₊ − κ rest² n|²/rest³; n is to the left of the tangent.

    Neighbouring segments are of nearly the same length: else this would pull at the longer one.
    """
    weight = (1.0, -2.0, 1.0)
    for i in range(1, len(points) - 1):
        mean = 0.5 * (rest[i - 1] + rest[i])
        k = body.bending / mean**3
        bow = curvature[i] * mean * mean
        bx = points[i - 1, 0] - 2.0 * points[i, 0] + points[i + 1, 0] + bow * tangent[i, 1]
        by = points[i - 1, 1] - 2.0 * points[i, 1] + points[i + 1, 1] - bow * tangent[i, 0]
        for a in range(3):
            force[i - 1 + a, 0] -= k * weight[a] * bx
            force[i - 1 + a, 1] -= k * weight[a] * by
            for b in range(a + 1):
                stiff = k * weight[a] * weight[b]
                _add_block(matrix, i - 1 + a, i - 1 + b, stiff, 0.0, 0.0, stiff)


@compiled
def _add_self_contact(force: Floats, points: Floats, body: Elasticity) -> None:
    """Push strands of the body apart that are nearer to each other than its width."""
    width, n = body.width_mm, len(points)
    apart = int(body.apart_mm / body.rest_mm) + 1
    stiff = body.overlap_part * body.rest_mm / body.step_s
    for i in range(n - apart):
        j = i + apart
        while j < n:
            dx, dy = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            distance = sqrt(dx * dx + dy * dy)
            if distance >= width:
                # The next point that could touch is at least this far along the body.
                j += max(1, int((distance - width) / (1.2 * body.rest_mm)))
                continue
            if distance > 0.0:
                push = stiff * (width - distance) / distance
                force[i, 0] += push * dx
                force[i, 1] += push * dy
                force[j, 0] -= push * dx
                force[j, 1] -= push * dy
            j += 1


@compiled
def solve_band(matrix: Floats, vector: Floats) -> None:
    """Solve a symmetric positive definite system by Cholesky's factors, in place.

    Parameters
    ----------
    matrix : ndarray, shape (n, BAND)
        Column k holds the k-th diagonal below the main one. Overwritten.
    vector : ndarray, shape (n,)
        The right side; becomes the solution.
    """
    n = len(vector)
    for j in range(n):
        for k in range(1, min(BAND_DIAGONALS, j + 1)):
            left = matrix[j - k, k]
            for d in range(BAND_DIAGONALS - k):
                matrix[j, d] -= left * matrix[j - k, d + k]
        root = sqrt(matrix[j, 0])
        for d in range(BAND_DIAGONALS):
            matrix[j, d] /= root
    for j in range(n):
        vector[j] /= matrix[j, 0]
        for d in range(1, min(BAND_DIAGONALS, n - j)):
            vector[j + d] -= matrix[j, d] * vector[j]
    for j in range(n - 1, -1, -1):
        for d in range(1, min(BAND_DIAGONALS, n - j)):
            vector[j] -= matrix[j, d] * vector[j + d]
        vector[j] /= matrix[j, 0]


@compiled
def _find_walls(
    points: Floats, clearance: Floats, walls: Walls, gap: Floats, normal: Floats
) -> None:
    for i in range(len(points)):
        nearest_walls(points[i, 0], points[i, 1], walls, gap[i], normal[i])
        gap[i] -= clearance[i]


@compiled
def _change_held(held: Mask, moved: Floats, gap: Floats, normal: Floats) -> bool:
    """Hold the points that would go into a wall, let go those that it would pull; say if any."""
    changed = False
    for i in range(len(held)):
        for k in range(2):
            after = gap[i, k] + normal[i, k, 0] * moved[2 * i] + normal[i, k, 1] * moved[2 * i + 1]
            if held[i, k] != (after < 0.0):
                held[i, k] = not held[i, k]
                changed = True
    return changed


@compiled
def _moved(
    base: Floats, force: Floats, held: Mask, gap: Floats, normal: Floats, wall: float
) -> Floats:
    """Return how far each point goes in a step, with the walls pushing where they must."""
    n = len(force)
    moved = np.empty(2 * n)
    for _ in range(ACTIVE_SET_TRIES):
        matrix = base.copy()
        moved[:] = force.reshape(2 * n)
        for i in range(n):
            for k in range(2):
                if held[i, k]:
                    nx, ny = normal[i, k, 0], normal[i, k, 1]
                    xy = wall * nx * ny
                    _add_block(matrix, i, i, wall * nx * nx, xy, xy, wall * ny * ny)
                    moved[2 * i] -= wall * gap[i, k] * nx
                    moved[2 * i + 1] -= wall * gap[i, k] * ny
        solve_band(matrix, moved)
        if not _change_held(held, moved, gap, normal):
            break
    return moved.reshape((n, 2))


@compiled
def step_body(
    points: Floats,
    drive: float,
    rest: Floats,
    curvature: Floats,
    clearance: Floats,
    held: Mask,
    walls: Walls,
    body: Elasticity,
) -> None:
    """Move the filament on by one time step, in place: linearly implicit Euler.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        x, y, mm, head first.
    drive : float
        Propulsion towards the head over ξ∥, mm/s.
    rest : ndarray, shape (n - 1,)
        Lengths of the segments at rest, mm.
    curvature : ndarray, shape (n,)
        Curvature at rest, 1/mm, positive where the body bends to the left of its way; that of the
        ends counts for nothing.
    clearance : ndarray, shape (n,)
        How near to a wall each point may come, mm.
    held : ndarray of bool, shape (n, 2)
        Which points the walls hold: those of the step before, overwritten.
    walls : Walls
        The rig.
    body : Elasticity
        The filament.
    """
    n = len(points)
    base, force = np.zeros((2 * n, BAND_DIAGONALS)), np.zeros((n, 2))
    tangent, gap, normal = np.empty((n, 2)), np.empty((n, 2)), np.zeros((n, 2, 2))
    point_tangents(points, tangent)
    for i in range(n):
        length = body.rest_mm * (0.5 if i in (0, n - 1) else 1.0)
        force[i, 0] += length * drive * tangent[i, 0]
        force[i, 1] += length * drive * tangent[i, 1]
    _add_drag(base, tangent, body)
    _add_stretching(base, force, points, rest, body)
    _add_bending(base, force, points, tangent, curvature, rest, body)
    if body.width_mm > 0.0:
        _add_self_contact(force, points, body)
    _find_walls(points, clearance, walls, gap, normal)
    points += _moved(base, force, held, gap, normal, body.wall)
