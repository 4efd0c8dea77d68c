"""What every frame adds to: histograms of r and ψ, and the sums behind v_w, v_b and contact."""

from collections.abc import Callable
from math import nan, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from worm_analysis.blocks import BlockSums, jackknife_half_width
from worm_analysis.distributions import bin_centres
from worm_analysis.statistics import peak_positions
from worm_msgs_py import Distribution, Observables

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
    "length",
    "length_n",
    "speed",
    "speed_n",
    "v_sin",
    "sin_sin",
    "directed_s",
    "turns_back",
)
_SIZES = {name: RADIUS_BINS if name.startswith("r_") else ANGLE_BINS for name in _HISTOGRAMS}
_STARTS = dict(
    zip(_HISTOGRAMS, np.cumsum([0, *(_SIZES[name] for name in _HISTOGRAMS)])[:-1], strict=True)
)
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

    def push(self, observables: Observables, length_m: float, interval_s: float) -> None:
        """Add a frame with the head in a chamber.

        Parameters
        ----------
        observables : Observables
            Of the frame.
        length_m : float
            Length of the body; may be NaN.
        interval_s : float
            Time since the frame before, 0 after a break.
        """
        row = self._blocks.row(observables.stamp_ns)
        scale = RADIUS_BINS_PER_R / self._radius_m
        _count(row, "r_h", observables.r_h_m * scale)
        _count(row, "r_c", observables.r_c_m * scale)
        _count(row, "r_t", observables.r_t_m * scale)
        _count(row, "psi_b", (observables.psi_b_rad + pi) * (ANGLE_BINS / (2 * pi)))
        _count(row, "psi_h", (observables.psi_h_rad + pi) * (ANGLE_BINS / (2 * pi)))
        if observables.contact is not None:
            row[_AT["contact"]] += observables.contact
            row[_AT["contact_known"]] += 1
        if length_m == length_m:
            row[_AT["length"]] += length_m
            row[_AT["length_n"]] += 1
        v = observables.v_b_m_s
        if v == v:
            self._add_speed(row, v, observables.psi_b_rad, interval_s)
        else:
            self._last_sign = 0.0

    def _add_speed(self, row: Floats, v: float, psi_b_rad: float, interval_s: float) -> None:
        row[_AT["speed"]] += abs(v)
        row[_AT["speed_n"]] += 1
        if psi_b_rad == psi_b_rad:
            s = sin(psi_b_rad)
            row[_AT["v_sin"]] += v * s
            row[_AT["sin_sin"]] += s * s
        if v != 0:
            sign = 1.0 if v > 0 else -1.0
            row[_AT["directed_s"]] += interval_s if self._last_sign else 0.0
            row[_AT["turns_back"]] += sign == -self._last_sign
            self._last_sign = sign

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

    def radius_peak(self, name: str) -> Estimate:
        """Return the mode of P(r)/R, from the histogram smoothed with a Gaussian of R/50."""
        centres = bin_centres(RADIUS_EDGES)

        def estimate(sums: Floats) -> Floats:
            smoothed = gaussian_filter1d(sums, RADIUS_SMOOTHING_BINS, axis=1, mode="constant")
            return peak_positions(smoothed, centres)

        return self._with_interval(estimate, _columns(name))

    def angle_peak(self, name: str, sign: int) -> Estimate:
        """Return the mode of P(ψ) on one side of 0, smoothed with a Gaussian of 8°, rad.

        NaN where the distribution has no maximum of its own on that side.
        """
        side = slice(ANGLE_BINS // 2, None) if sign > 0 else slice(0, ANGLE_BINS // 2)
        centres = bin_centres(ANGLE_EDGES)[side]

        def estimate(sums: Floats) -> Floats:
            smoothed = gaussian_filter1d(sums, ANGLE_SMOOTHING_BINS, axis=1, mode="wrap")
            return peak_positions(smoothed[:, side], centres)

        return self._with_interval(estimate, _columns(name))

    def _with_interval(
        self, estimate: Callable[[Floats], Floats], columns: slice | list[int]
    ) -> Estimate:
        value = float(estimate(self._blocks.total()[None, columns])[0])
        if value != value:
            return value, None
        return value, jackknife_half_width(self._blocks, estimate, columns)


def _count(row: Floats, name: str, position: float) -> None:
    """Add one to the bin at a position in bins; NaN and what is out of range is left out."""
    if 0 <= position < _SIZES[name]:
        row[_STARTS[name] + int(position)] += 1
    elif position == _SIZES[name] == ANGLE_BINS:
        row[_STARTS[name] + ANGLE_BINS - 1] += 1


def _columns(name: str) -> slice:
    return slice(_STARTS[name], _STARTS[name] + _SIZES[name])
