"""What every frame adds to: histograms of r and ψ, and the sums behind v_w, v_b and contact."""

from collections.abc import Callable
from math import atan2, nan, pi

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from worm_analysis.accumulators.frame_rows import Frames
from worm_analysis.kinematics.observables import wrap_angle
from worm_analysis.statistics.block_jackknife import (
    BlockSums,
    jackknife_half_width,
    jackknife_half_widths,
)
from worm_analysis.statistics.estimators import peak_positions
from worm_analysis.statistics.histograms import bin_centres
from worm_analysis.statistics.sample_correlation import PearsonEstimate, pearson
from worm_msgs_py import Distribution

Floats = NDArray[np.float64]
Estimate = tuple[float, float | None]
"""Value and half width of its 95 % interval (None where it cannot be had)."""

ANGLE_BINS = 180
ANGLE_EDGES = np.linspace(-pi, pi, ANGLE_BINS + 1)
RADIUS_BINS_PER_R = 100
RADIUS_BINS = 120
RADIUS_EDGES = np.linspace(0.0, RADIUS_BINS / RADIUS_BINS_PER_R, RADIUS_BINS + 1)
ANGLE_SMOOTHING_BINS = 4.0
RADIUS_SMOOTHING_BINS = 2.0

_HISTOGRAMS = ("r_h", "r_c", "r_t", "psi_b", "psi_h")
_SUMS = (
    "contact",
    "contact_known",
    "speed",
    "speed_n",
    "velocity",
    "directed_s",
    "turns_back",
    "sin_psi_b",
    "cos_psi_b",
    "pairs",
    "theta_dot",
    "psi_b",
    "theta_dot_2",
    "psi_b_2",
    "theta_dot_psi_b",
)
_SIZES = {name: RADIUS_BINS if name.startswith("r_") else ANGLE_BINS for name in _HISTOGRAMS}
_STARTS = dict(
    zip(_HISTOGRAMS, np.cumsum([0, *(_SIZES[name] for name in _HISTOGRAMS)])[:-1], strict=True)
)
_RADIUS_CENTRES, _ANGLE_CENTRES = bin_centres(RADIUS_EDGES), bin_centres(ANGLE_EDGES)
_FIRST_SUM = sum(_SIZES.values())
_AT = {name: _FIRST_SUM + index for index, name in enumerate(_SUMS)}


class FrameSums:
    """Additive statistics of the frames in a chamber, by blocks of time.

    Parameters
    ----------
    radius_m : float
        R: the histograms of r have bins of R/100 up to 1.2 R; what lies beyond is left out.
    """

    def __init__(self, radius_m: float):
        self._radius_m = radius_m
        self._blocks = BlockSums(_FIRST_SUM + len(_SUMS))
        self._last_sign = 0.0

    def add(self, frames: Frames) -> None:
        """Add frames with the head in a chamber."""
        scale = RADIUS_BINS_PER_R / self._radius_m
        turn = ANGLE_BINS / (2 * pi)
        bins = [
            _bins("r_h", frames.r_h_m * scale),
            _bins("r_c", frames.r_c_m * scale),
            _bins("r_t", frames.r_t_m * scale),
            _bins("psi_b", (frames.psi_b_rad + pi) * turn),
            _bins("psi_h", (frames.psi_h_rad + pi) * turn),
        ]
        v, psi_b = frames.theta_dot_rad_s * self._radius_m, frames.psi_b_rad
        x, y = frames.theta_dot_rad_s, psi_b
        both = np.where(np.isfinite(x) & np.isfinite(y), 1.0, 0.0)
        directed_s, turns_back = self._turns(v, frames.interval_s)
        sums = [
            frames.contact,
            np.isfinite(frames.contact),
            np.abs(v),
            np.isfinite(v),
            v,
            directed_s,
            turns_back,
            np.sin(psi_b),
            np.cos(psi_b),
            both,
            both * x,
            both * y,
            x * x * both,
            y * y * both,
            x * y,
        ]
        values = np.column_stack([np.ones((len(frames), len(bins))), *sums])
        columns = np.empty(values.shape, dtype=np.intp)
        columns[:, : len(bins)] = np.column_stack(bins)
        columns[:, len(bins) :] = _FIRST_SUM + np.arange(len(sums))
        columns[~np.isfinite(values)] = -1
        self._blocks.add(frames.stamp_ns, columns, values)

    def _turns(self, v: Floats, interval_s: Floats) -> tuple[Floats, Floats]:
        """Return, a frame, the time with a direction and whether the direction has turned.

        The direction before a frame is that of the last frame that moved; it is forgotten where
        there is no speed.
        """
        sign = np.where(np.isfinite(v), np.sign(np.nan_to_num(v)), 0.0)
        says = (sign != 0) | ~np.isfinite(v)  # a frame that rests says nothing
        upto = np.maximum.accumulate(np.where(says, np.arange(len(v)), -1))
        latest = np.where(upto >= 0, sign[upto], self._last_sign)
        before = np.concatenate([[self._last_sign], latest[:-1]])
        self._last_sign = float(latest[-1])
        moves = sign != 0
        directed_s = np.where(moves & (before != 0), interval_s, 0.0)
        return directed_s, (moves & (sign == -before)).astype(np.float64)

    def total(self, name: str) -> float:
        """Return one of the sums."""
        return float(self._blocks.total()[_AT[name]])

    def histogram(self, name: str) -> NDArray[np.int64]:
        """Return the counts of one of the histograms."""
        counts: NDArray[np.int64] = np.rint(self._blocks.total()[_columns(name)]).astype(np.int64)
        return counts

    def distributions(self) -> list[Distribution]:
        """Return P(r_h), P(r_c), P(r_t), P(ψ_b), P(ψ_h) as counts."""
        metres = RADIUS_EDGES * self._radius_m
        return [
            Distribution(
                name,
                "m" if name.startswith("r_") else "rad",
                metres if name.startswith("r_") else ANGLE_EDGES,
                self.histogram(name),
            )
            for name in _HISTOGRAMS
        ]

    def ratio(self, above: str, below: str) -> Estimate:
        """Return the ratio of two sums."""
        if self.total(below) == 0:
            return nan, None

        def estimate(sums: Floats) -> Floats:
            with np.errstate(divide="ignore", invalid="ignore"):
                quotient: Floats = sums[:, 0] / sums[:, 1]
            return quotient

        return self._with_interval(estimate, [_AT[above], _AT[below]])

    def correlation(self) -> PearsonEstimate:
        """Return Pearson's correlation of θ̇_h with ψ_b (paper, Fig. 4a)."""
        names = ("pairs", "theta_dot", "psi_b", "theta_dot_2", "psi_b_2", "theta_dot_psi_b")
        return pearson(self._blocks, [_AT[name] for name in names])

    def mean_body_angle(self) -> Estimate:
        """Return the direction of the sum of ψ_b's unit vectors, rad."""
        columns = [_AT["sin_psi_b"], _AT["cos_psi_b"]]
        up, along = self._blocks.total()[columns]
        mean = atan2(up, along)

        def away(sums: Floats) -> Floats:  # from the mean, or π would be far from −π
            angle: Floats = wrap_angle(np.arctan2(sums[:, 0], sums[:, 1]) - mean)
            return angle

        return mean, jackknife_half_width(self._blocks, away, columns)

    def radius_peaks(self) -> tuple[Estimate, ...]:
        """Return the modes of P(r)/R of head, centroid and tail.

        From the histograms smoothed with a Gaussian of R/50.
        """

        def estimate(sums: Floats) -> Floats:
            each = sums.reshape(-1, RADIUS_BINS)
            smoothed = gaussian_filter1d(each, RADIUS_SMOOTHING_BINS, axis=1, mode="constant")
            return peak_positions(smoothed, _RADIUS_CENTRES).reshape(-1, 3)

        return self._peaks(estimate, 3, slice(0, 3 * RADIUS_BINS))

    def angle_peaks(self) -> tuple[Estimate, ...]:
        """Return the modes of P(ψ_b) below and above 0, smoothed with a Gaussian of 8°, rad.

        NaN where the distribution has no maximum of its own on that side.
        """

        def estimate(sums: Floats) -> Floats:
            smoothed = gaussian_filter1d(sums, ANGLE_SMOOTHING_BINS, axis=1, mode="wrap")
            sides = np.split(smoothed, 2, axis=1), np.split(_ANGLE_CENTRES, 2)
            return np.stack([peak_positions(*side) for side in zip(*sides, strict=True)], axis=1)

        return self._peaks(estimate, 2, _columns("psi_b"))

    def _peaks(
        self, estimate: Callable[[Floats], Floats], n: int, columns: slice
    ) -> tuple[Estimate, ...]:
        values = estimate(self._blocks.total()[None, columns])[0]
        halves = jackknife_half_widths(self._blocks, estimate, n, columns)
        return tuple(
            (float(value), float(half) if half == half else None)
            for value, half in zip(values, halves, strict=True)
        )

    def _with_interval(
        self, estimate: Callable[[Floats], Floats], columns: slice | list[int]
    ) -> Estimate:
        value = float(estimate(self._blocks.total()[None, columns])[0])
        if value != value:
            return value, None
        return value, jackknife_half_width(self._blocks, estimate, columns)


def _bins(name: str, position: Floats) -> NDArray[np.intp]:
    """Return each position's column; −1 for NaN and for what is out of range."""
    size = _SIZES[name]
    inside = (position >= 0) & (position < size)
    whole = np.where(inside, position, 0.0).astype(np.intp)
    if size == ANGLE_BINS:  # +π is in the last bin
        inside |= position == size
        whole[position == size] = size - 1
    return np.where(inside, _STARTS[name] + whole, -1)


def _columns(name: str) -> slice:
    return slice(_STARTS[name], _STARTS[name] + _SIZES[name])
