"""C_θ(t) = ⟨sgn θ̇_h(t + t₀) · sgn θ̇_h(t₀)⟩ while frames come in, and its decay time t_per."""

from math import isfinite

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from worm_analysis.kinematics.angular_speed import NS
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_analysis.summary.paper_values import paper_value
from worm_msgs_py import Correlation, Quantity

Floats = NDArray[np.float64]

SHORTEST_TRACK_IN_T_PER = 5.0
FEWEST_BLOCKS_AT_LAG = 5
NORMAL = 1.959964
CELLS_AT_ONCE = 1024
"""Bounds the memory of the table of pairs."""


def lag_grid(
    max_lag_s: float, fine_lag_s: float, fine_step_s: float, coarse_step_s: float
) -> NDArray[np.int64]:
    """Return the lags as multiples of the fine step, ascending from 0."""
    last = round(max_lag_s / fine_step_s)
    ratio = round(coarse_step_s / fine_step_s)
    fine = np.arange(0, min(last, round(fine_lag_s / fine_step_s)) + 1)
    coarse = np.arange(0, last + 1, ratio)
    return np.union1d(fine, coarse).astype(np.int64)


class SignCorrelation:
    """Autocorrelation of a sign over time, one pass, in memory that does not grow.

    Time since the first frame is cut into cells of one fine step; the first frame with a direction
    stands for its cell. Pairs of cells are made within an unbroken stretch of one visit only: the
    past cells are forgotten at every break. Sums are kept by blocks of time for the error.

    Parameters
    ----------
    lags : ndarray of int64, shape (n,)
        Lags in cells, ascending from 0.
    step_s : float
        Length of a cell.
    """

    def __init__(self, lags: NDArray[np.int64], step_s: float):
        self._lags = lags
        self._step_ns = round(step_s * NS)
        self._start_ns: int | None = None
        self._cell = -1
        self._memory = int(lags[-1])
        self._past = np.zeros((2, self._memory))
        self._blocks = BlockSums(2 * len(lags))
        self._known: tuple[int, int, Quantity] | None = None

    @property
    def lag_s(self) -> Floats:
        """The lags, s."""
        return np.asarray(self._lags * (self._step_ns / NS), dtype=np.float64)

    def add(self, stamps_ns: NDArray[np.int64], speed: Floats) -> None:
        """Take frames of an unbroken stretch.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (m,)
            Ascending, and later than all before.
        speed : ndarray, shape (m,)
            Only the signs count; NaN is a frame without a direction.
        """
        known = np.isfinite(speed)
        stamps_ns, speed = stamps_ns[known], speed[known]
        if not len(stamps_ns):
            return
        if self._start_ns is None:
            self._start_ns = int(stamps_ns[0])
        cells = (stamps_ns - self._start_ns) // self._step_ns
        new = np.diff(cells, prepend=self._cell) > 0
        cells, stamps_ns, signs = cells[new], stamps_ns[new], np.sign(speed[new])
        apart = np.flatnonzero(np.diff(cells, prepend=self._cell) > self._memory)
        cuts = np.union1d(apart, np.arange(0, len(cells), CELLS_AT_ONCE))
        for part in np.split(np.arange(len(cells)), cuts):
            if len(part):
                self._add_cells(cells[part], stamps_ns[part], signs[part])

    def break_off(self) -> None:
        """Say that what follows is not connected: a gap, or another visit."""
        self._past[:] = 0.0

    def _add_cells(
        self, cells: NDArray[np.int64], stamps_ns: NDArray[np.int64], signs: Floats
    ) -> None:
        """Pair cells with those before; rows of `_past` are signs, and 1 where there is one."""
        first, memory = int(cells[0]), self._memory
        dense = np.zeros((2, memory + int(cells[-1]) - first + 1))
        missing = first - self._cell - 1
        if missing < memory:
            dense[:, : memory - missing] = self._past[:, missing:]
        here = cells - first + memory
        dense[0, here], dense[1, here] = signs, 1.0
        before = here[:, None] - self._lags
        pairs = np.hstack([dense[0, before] * signs[:, None], dense[1, before]])
        self._blocks.add_rows(stamps_ns, pairs)
        self._past = dense[:, dense.shape[1] - memory :].copy()
        self._cell = int(cells[-1])

    def curve(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return C_θ (NaN where there are no pairs) and the number of pairs at each lag."""
        products, pairs = np.split(self._blocks.total(), 2)
        c = np.divide(products, pairs, out=np.full(len(pairs), np.nan), where=pairs > 0)
        return c, np.rint(pairs).astype(np.int64)

    def error(self) -> Floats:
        """Return one standard error at each lag from blocks of time; NaN with fewer than eight.

        The largest one over all lengths of blocks is taken, as blocks shorter than the correlation
        time make it too small. Long lags may have nearly all of their pairs in a few blocks: the
        error is widened by Student's law for the blocks' effective number (Σ pairs)²/Σ pairs², so
        that 1.96 of it make a 95 % interval, and it is NaN with fewer than five.
        """
        c, pairs = self.curve()
        worst = np.full(len(c), np.nan)
        unknown = np.zeros(len(c), dtype=np.bool_)
        for rows in self._blocks.levels():
            squares = np.maximum(np.sum(rows[:, len(c) :] ** 2, axis=0), 1.0)
            k = pairs.astype(np.float64) ** 2 / squares
            few = k < FEWEST_BLOCKS_AT_LAG
            k = np.maximum(k, FEWEST_BLOCKS_AT_LAG)
            squares = np.sum(self._residuals(rows, c) ** 2, axis=0) * (k / (k - 1))
            error = np.sqrt(squares) / np.maximum(pairs, 1)
            worst = np.fmax(worst, error * stdtrit(k - 1, 0.975) / NORMAL)
            unknown |= few
        worst[unknown] = np.nan
        return worst

    def persistence_time(self, minimum_n: int) -> Quantity:
        """Return t_per: the decay time of exp(−t/t_per), fitted to C_θ (paper, Fig. 7a).

        Least squares over all lags, weighted by the number of pairs. The interval is the fit's
        linear response to each block of time, on a logarithmic scale.

        Parameters
        ----------
        minimum_n : int
            Fewest cells with a direction.
        """
        c, pairs = self.curve()
        if self._known is None or self._known[:2] != (int(pairs[0]), minimum_n):
            self._known = (int(pairs[0]), minimum_n, self._persistence_time(c, pairs, minimum_n))
        return self._known[2]

    def _persistence_time(self, c: Floats, pairs: NDArray[np.int64], minimum_n: int) -> Quantity:
        n, unit = int(pairs[0]), "s"
        observed_s = n * self._step_ns / NS

        def without(why: str) -> Quantity:
            return Quantity("t_per", None, n=n, unit=unit, paper=paper_value("t_per"), why=why)

        if n < minimum_n:
            return without(f"not enough data: {observed_s:.0f} s with a direction of motion")
        fitted = fit_decay_time(self.lag_s, c, pairs)
        if not isfinite(fitted):
            return without("C_θ does not decay within the longest lag that was observed")
        if observed_s < SHORTEST_TRACK_IN_T_PER * fitted:
            return without(
                f"not enough data: {observed_s:.0f} s with a direction of motion, less than "
                f"{SHORTEST_TRACK_IN_T_PER:.0f} times the decay time of about {fitted:.0f} s"
            )
        half = self._half_width_of_log(fitted, c, pairs)
        if half is None:
            return without("not enough data: fewer than eight independent stretches of time")
        low, high = fitted * np.exp(-half), fitted * np.exp(half)
        return Quantity("t_per", fitted, float(low), float(high), n, unit, paper_value("t_per"))

    def result(self, minimum_n: int) -> Correlation:
        """Return the curve, its error and the fitted exponential."""
        c, pairs = self.curve()
        t_per = self.persistence_time(minimum_n).value
        model = np.full(len(c), np.nan) if t_per is None else np.exp(-self.lag_s / t_per)
        return Correlation(self.lag_s, c, self.error(), pairs, model)

    def _half_width_of_log(
        self, fitted_s: float, c: Floats, pairs: NDArray[np.int64]
    ) -> float | None:
        slope = self.lag_s / fitted_s * np.exp(-self.lag_s / fitted_s)
        leverage = float(np.sum(pairs * slope**2))
        widest: float | None = None
        for rows in self._blocks.levels():
            response = np.sum(self._residuals(rows, c) * slope, axis=1) / leverage
            k = len(rows)
            error = float(np.sqrt(np.sum(response**2) * (k / (k - 1))))
            half = float(stdtrit(k - 1, 0.975)) * error
            widest = half if widest is None else max(widest, half)
        return widest

    def _residuals(self, rows: Floats, c: Floats) -> Floats:
        products, pairs = np.split(rows, 2, axis=1)
        residuals: Floats = products - np.nan_to_num(c) * pairs
        return residuals


def fit_decay_time(lag_s: Floats, c: Floats, pairs: NDArray[np.int64]) -> float:
    """Return t_per of the exp(−t/t_per) that is nearest to C_θ, weighted by pairs.

    Parameters
    ----------
    lag_s, c : ndarray, shape (n,)
        Lags in s and C_θ, NaN where there are no pairs.
    pairs : ndarray of int64, shape (n,)
        The weights.

    Returns
    -------
    float
        Seconds; NaN where C_θ decays faster than the lags resolve, or not at all.
    """
    known = (pairs > 0) & np.isfinite(c) & (lag_s > 0)
    if np.count_nonzero(known) < 3:
        return float("nan")
    lag, value, weight = lag_s[known], c[known], pairs[known].astype(np.float64)
    weight /= weight.sum()
    shortest, longest = np.log(lag[0] / 3), np.log(lag[-1] * 10)

    def misfit(log_t: float) -> float:
        return float(np.sum(weight * (value - np.exp(-lag / np.exp(log_t))) ** 2))

    grid = np.linspace(shortest, longest, 120)
    misfits = (value - np.exp(-lag / np.exp(grid)[:, None])) ** 2
    best = int(np.argmin(np.sum(weight * misfits, axis=1)))
    if best in (0, len(grid) - 1):
        return float("nan")
    found = minimize_scalar(
        misfit, bounds=(grid[best - 1], grid[best + 1]), method="bounded", options={"xatol": 1e-10}
    )
    return float(np.exp(found.x))
