"""Worms that do as they are told: paths for them, and midlines of a worm that lies on one.

All lengths are millimetres in the frame of chamber a; midlines are head first.
"""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Line = NDArray[np.float64]
MIDLINE_POINTS = 121
"""Points of a midline: a step of a sixth of a millimetre for the worms here."""
HEAD_DEPTH_MM = 0.05
"""How near to the wall the tip of a head comes that leans on it."""
BOW_MM = 8.0
"""Radius of the bow that leads into a coil; the path starts along x, the bow's middle above it."""
WAY_TO_THE_EXIT = (
    (2.0, 0.0),
    (5.6, 1.6),
    (4.6, 5.0),
    (0.0, 6.0),
    (-5.0, 4.5),
    (-7.0, 0.0),
    (-5.5, -4.5),
    (-1.0, -6.0),
    (4.0, -4.0),
    (7.0, -1.3),
    (9.2, -0.1),
    (12.0, 0.0),
    (20.0, 0.2),
    (30.0, -0.2),
    (43.0, 0.0),
)
WAY_THROUGH_B = (
    (45.8, 0.1),
    (50.0, 1.7),
    (54.0, 5.5),
    (60.0, 5.0),
    (62.0, 0.0),
    (60.0, -5.0),
    (54.0, -5.5),
    (50.0, -1.7),
    (45.8, -0.1),
)
WAY_BACK = (
    (43.0, 0.0),
    (30.0, 0.2),
    (20.0, -0.2),
    (12.0, 0.0),
    (9.2, 0.1),
    (6.0, 2.0),
    (2.0, 5.5),
    (-4.0, 6.0),
    (-7.0, 1.0),
    (-5.5, -4.5),
    (0.0, -6.5),
    (5.0, -4.5),
)


def smooth_path(waypoints_mm: Iterable[tuple[float, float]]) -> Line:
    """Return a smooth curve through waypoints, at steps of about 0.05 mm, shape (n, 2)."""
    points = np.array(list(waypoints_mm))
    chord = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    at = np.linspace(0.0, chord[-1], round(chord[-1] / 0.05))
    return np.asarray(CubicSpline(chord, points)(at), dtype=np.float64)


def winding_path(radius_mm: float, start_rad: float = 0.0) -> Line:
    """Return a path through the middle of a chamber, with bends much tighter than its wall."""
    phi = np.linspace(0.0, 6.0 * np.pi, 8000)
    r = radius_mm * (0.55 + 0.15 * np.sin(phi / 2.0) + 0.05 * np.sin(7.0 * phi))
    return _polar_line(phi + start_rad, r)


def looping_path(radius_mm: float, start_rad: float = 0.0) -> Line:
    """Return a path that crosses itself every 35 mm, in loops 11 mm long (for R = 10 mm)."""
    phi = np.linspace(-1.0, 6.0 * np.pi, 8000)
    z = 0.1 * radius_mm * (4.0 * np.exp(1j * phi) + 3.5 * np.exp(3j * phi))
    z = z * np.exp(1j * start_rad)
    return np.stack([z.real, z.imag], axis=1)


def crawl(path_mm: Line, length_mm: float, heads_mm: Iterable[float]) -> Iterator[Line]:
    """Yield the midline of a worm that lies on a path.

    Parameters
    ----------
    path_mm : ndarray, shape (n, 2)
        The path.
    length_mm : float
        The worm's length.
    heads_mm : iterable of float
        Arc length of the head along the path at each frame; falling where it crawls backwards.

    Raises
    ------
    ValueError
        Where the worm would reach beyond an end of the path.
    """
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(path_mm, axis=0).T))]
    for head in heads_mm:
        if not length_mm <= head <= s[-1]:
            raise ValueError(
                f"a head at {head:.1f} mm needs a path from {head - length_mm:.1f} mm on to there;"
                f" this one is {s[-1]:.1f} mm long"
            )
        at = np.linspace(head, head - length_mm, MIDLINE_POINTS)
        yield np.stack([np.interp(at, s, path_mm[:, k]) for k in (0, 1)], axis=1)


def lie_along_the_wall(
    radius_mm: float, length_mm: float, width_mm: float, theta_rad: float, off_wall_mm: float
) -> Line:
    """Return a midline that lies along the wall over its whole length, clockwise of its head.

    Parameters
    ----------
    radius_mm : float
        R.
    length_mm, width_mm : float
        The worm's.
    theta_rad : float
        Polar angle of its head.
    off_wall_mm : float
        How far the head has lifted off; 0 while it touches.
    """
    s = np.linspace(0.0, length_mm, MIDLINE_POINTS)
    beside = 0.5 * width_mm + 0.03
    # The head leans on the wall with its tip, at 50°, so that its rounded end is not in the wall.
    lean = 0.35 * s * np.exp(-s) - (beside - HEAD_DEPTH_MM) * np.exp(-s / 0.4)
    depth = beside + lean + off_wall_mm * np.exp(-s / 2.0)
    return _polar_line(theta_rad - s / (radius_mm - beside), radius_mm - depth)


def coiling_path(width_mm: float, lead_mm: float, coil_mm: float) -> Line:
    """Return a wide bow that ends in a spiral inwards, whose turns touch.

    Parameters
    ----------
    width_mm : float
        The worm's; the spiral's turns are 1.05 widths apart.
    lead_mm, coil_mm : float
        Length of the bow and of the spiral. The path's end is the spiral's inner end.
    """
    inner, gap = 2.5 * width_mm, 1.05 * width_mm / (2.0 * np.pi)
    s = np.arange(0.0, lead_mm + coil_mm, 0.02)
    inwards = np.clip(lead_mm + coil_mm - s, 0.0, coil_mm)
    spiral = 1.0 / np.sqrt(inner**2 + 2.0 * gap * inwards)
    into = np.clip((s - lead_mm) / 2.0 + 1.0, 0.0, 1.0)
    curvature = (1.0 - into) / BOW_MM + into * spiral
    yaw = np.r_[0.0, np.cumsum(0.5 * (curvature[1:] + curvature[:-1]) * np.diff(s))]
    z = np.r_[0.0, np.cumsum(np.exp(0.5j * (yaw[1:] + yaw[:-1])) * np.diff(s))]
    return np.stack([z.real, z.imag], axis=1)


def _polar_line(phi: NDArray[np.float64], r: NDArray[np.float64]) -> Line:
    return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=1)
