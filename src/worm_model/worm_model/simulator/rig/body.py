"""The worm's body in the picture: a midline from tip to tip and the width across it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from worm_model.filament.parameters import FILAMENT

HEAD_TAPER_WIDTHS, TAIL_TAPER_WIDTHS = FILAMENT.head_end_widths, FILAMENT.tail_end_widths
"""Lengths over which the ends of the worms here are rounded, as half ellipses."""
FINE_PX = 0.5
"""Step of the resampled midline."""


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """A worm-shaped area: the outline lies half a width to either side of the midline.

    Both ends are rounded: over the taper's length the width falls to zero as that of a half
    ellipse, so that the outline's outermost point at each end is the midline's end.

    Attributes
    ----------
    points_px : ndarray, shape (n, 2)
        The midline (u, v), head tip first, at steps of about `FINE_PX`.
    s_px : ndarray, shape (n,)
        Arc length from the head tip.
    width_px : ndarray, shape (n,)
        Full width across the midline; zero at both ends.
    """

    points_px: NDArray[np.float64]
    s_px: NDArray[np.float64]
    width_px: NDArray[np.float64]

    @classmethod
    def along(
        cls,
        midline_px: ArrayLike,
        width_px: float | ArrayLike,
        head_taper_px: float | None = None,
        tail_taper_px: float | None = None,
    ) -> "Body":
        """Build the body on a smooth curve through some points.

        Parameters
        ----------
        midline_px : array, shape (n, 2), n ≥ 2
            Picture coordinates (u, v), head tip first, tail tip last.
        width_px : float or array, shape (n,)
            Full width across the midline at these points, before the ends are rounded.
        head_taper_px, tail_taper_px : float, optional
            Length over which each end is rounded; at least half a width (a half circle there), by
            default 1.5 widths (head) and 2.5 widths (tail).

        Raises
        ------
        ValueError
            For fewer than two different points, or numbers that are not finite.
        """
        points = np.asarray(midline_px, dtype=np.float64)
        width = np.broadcast_to(np.asarray(width_px, dtype=np.float64), points.shape[:1])
        if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
            raise ValueError("a midline is an array of finite (u, v) rows")
        keep = np.r_[True, np.hypot(*np.diff(points, axis=0).T) > 1e-9]
        points, width = points[keep], width[keep]
        if len(points) < 2:
            raise ValueError("a midline needs two different points")
        fine, fine_width = _resample(points, width)
        s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(fine, axis=0).T))]
        middle = float(np.median(fine_width))
        head = HEAD_TAPER_WIDTHS * middle if head_taper_px is None else head_taper_px
        tail = TAIL_TAPER_WIDTHS * middle if tail_taper_px is None else tail_taper_px
        rounding = _end_factor(s, head) * _end_factor(s[-1] - s, tail)
        return cls(fine, s, fine_width * rounding)

    @property
    def length_px(self) -> float:
        """Length along the midline from tip to tip."""
        return float(self.s_px[-1])

    @property
    def mean_width_px(self) -> float:
        """Mean width over the middle half of the body."""
        part = self.s_px / self.length_px
        return float(self.width_px[(part >= 0.25) & (part <= 0.75)].mean())

    def at(self, s_px: float | NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the midline's points (u, v) at these arc lengths from the head tip."""
        u = np.interp(s_px, self.s_px, self.points_px[:, 0])
        v = np.interp(s_px, self.s_px, self.points_px[:, 1])
        return np.stack([u, v], axis=-1)

    def discs(self, step_px: float = 2.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return discs whose union is the body.

        The disc that touches the outline at arc length s, where the half width is h, is centred at
        s + h h' and has the radius h √(1 + h'²). Both are smooth in h², also at the ends.

        Parameters
        ----------
        step_px : float
            Distance of their centres along the midline.

        Returns
        -------
        centres_px : ndarray, shape (m, 2)
        radius_px : ndarray, shape (m,)
        """
        q = (0.5 * self.width_px) ** 2
        slope = 0.5 * np.gradient(q, self.s_px, edge_order=2)
        centre_s = np.maximum.accumulate(self.s_px + slope)
        radius = np.sqrt(q + slope**2)
        count = max(int(np.ceil((centre_s[-1] - centre_s[0]) / step_px)), 1) + 1
        at = np.linspace(centre_s[0], centre_s[-1], count)
        return self.at(at), np.interp(at, centre_s, radius)


def _resample(
    points: NDArray[np.float64], width: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    chord = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    count = max(int(np.ceil(chord[-1] / FINE_PX)), 8) + 1
    at = np.linspace(0.0, chord[-1], count)
    fine = CubicSpline(chord, points)(at) if len(points) > 2 else _straight(points, at / chord[-1])
    return np.asarray(fine, dtype=np.float64), np.interp(at, chord, width)


def _straight(points: NDArray[np.float64], part: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(points[0] + part[:, np.newaxis] * (points[1] - points[0]), dtype=np.float64)


def _end_factor(from_end: NDArray[np.float64], taper: float) -> NDArray[np.float64]:
    """Width of a half ellipse of this length, as a share of its full width."""
    part = np.clip(1.0 - from_end / taper, 0.0, 1.0)
    return np.asarray(np.sqrt(1.0 - part**2), dtype=np.float64)
