"""The whole law of τ_h, exactly: mean, variance, skips, survival, density, quantiles.

`SolvedWalk` holds what depends on the parameters alone, so that a new state costs little.
"""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf, log, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from worm_model.boundary_walk.laplace_inversion import LATEST_OVER_PERIOD, Contour
from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.relative_state import RelativeState, relative_state_of
from worm_model.boundary_walk.singular_paths import singular_terms_of
from worm_model.boundary_walk.singular_terms import SingularLaw, SingularTerms
from worm_model.boundary_walk.state import WalkState
from worm_model.boundary_walk.transform import Solution, solve_skips, solve_transform
from worm_msgs_py.arrays import Complex, Floats

EXACT_ERROR = 1e-6
"""Error of probabilities."""
FORECAST_ERROR = 2e-5
"""Error of probabilities in a forecast."""
HIGHEST_PROBABILITY = 1.0 - 1e-4
"""Highest probability of which a quantile is given."""
_POINTS_OF_CIRCLE = 32
"""Points of the circle about s = 0 from which the moments are taken."""
_PERIOD_RATIO = 4.0
"""Of the periods of the Fourier series, each for later times than the one before."""
_FEWEST_TERMS, _MOST_TERMS, _KEPT_TERMS = 1024, 1 << 17, 1 << 14
_TERMS_A_ROUND = 16


class SolvedWalk:
    """A boundary walk, solved.

    Parameters
    ----------
    parameters : WalkParameters
        The walk. Immutable; what is worked out from it is kept.
    """

    def __init__(self, parameters: WalkParameters):
        self._parameters = parameters
        self._contours: dict[tuple[int, int], tuple[Contour, Solution]] = {}

    @property
    def parameters(self) -> WalkParameters:
        """The walk's parameters."""
        return self._parameters

    def first_passage(
        self, start: WalkState | None = None, *, error: float = EXACT_ERROR
    ) -> "FirstPassage":
        """Return the law of τ_h.

        Parameters
        ----------
        start : WalkState, optional
            The state at time 0; else the head slides, uniformly on the wall, in either direction.
        error : float
            How wrong probabilities may be.

        Raises
        ------
        ValueError
            Where the state is a slide within the exit's arc.
        """
        relative = None if start is None else relative_state_of(start, self._parameters)
        return FirstPassage(self, relative, error)

    def forecast(self, state: WalkState) -> "FirstPassage":
        """Return the law of the time that is left, from a state: fast, right to 2e-5.

        Raises
        ------
        ValueError
            Where the state is a slide within the exit's arc.
        """
        return self.first_passage(state, error=FORECAST_ERROR)

    def contour(self, number: int, terms: int) -> tuple[Contour, Solution]:
        """Return a contour and the transform along it."""
        key = number, terms
        if key in self._contours:
            return self._contours[key]
        contour = Contour(self.period_s(number), terms)
        solved = contour, solve_transform(self._parameters, contour.s)
        if terms <= _KEPT_TERMS:
            self._contours[key] = solved
        return solved

    def period_s(self, number: int) -> float:
        """Return a contour's T: the time of one round, times 4^number."""
        return (
            self._parameters.circumference_mm / self._parameters.speed_mm_s * _PERIOD_RATIO**number
        )

    def contour_number(self, t_s: float) -> int:
        """Return which contour serves a time: its T is between 4 and 16 times as long."""
        return ceil(log(t_s / (LATEST_OVER_PERIOD * self.period_s(0)), _PERIOD_RATIO) - 1e-12)

    @cached_property
    def near_zero(self) -> tuple[float, Solution]:
        """The radius of a circle about s = 0, 1/s, and the transform on its upper half."""
        radius = _moment_radius(self._parameters)
        angle = 2.0 * pi * np.arange(_POINTS_OF_CIRCLE // 2 + 1) / _POINTS_OF_CIRCLE
        return radius, solve_transform(self._parameters, radius * np.exp(1j * angle))

    @cached_property
    def skips(self) -> Solution:
        """The mean number of skips."""
        return solve_skips(self._parameters)


def _moment_radius(parameters: WalkParameters) -> float:
    """Return an s well within the circle about 0 in which the transform is analytic.

    ⟨e^{sτ}⟩ is finite where s times the longest mean of τ is below 1, from whatever state; so
    the transform at −s, which is about 1 − s⟨τ⟩, tells where that is.
    """
    s = np.geomspace(1e-12, 1e2, 60) * parameters.speed_mm_s / parameters.circumference_mm
    solution = solve_transform(parameters, s)
    wall = parameters.wall_mm
    states = [
        RelativeState(part * wall, hop, False) for part in (0.25, 0.5, 1.0) for hop in (False, True)
    ]
    lowest = np.min([solution.at(relative).real for relative in states], axis=0)
    return float(s[np.flatnonzero(lowest > 0.8)[-1]])


@dataclass(frozen=True, eq=False)
class FirstPassage:
    """The law of τ_h from one start; made by `SolvedWalk`.

    Moments are right to 1e-9 of their value, probabilities to 1e-6 (to 2e-5 in a forecast).
    """

    walk: SolvedWalk
    relative: RelativeState | None
    error: float
    _singular_laws: dict[int, SingularLaw] = field(default_factory=dict, repr=False)
    _smooth: dict[int, tuple[Contour, Complex, Floats]] = field(default_factory=dict, repr=False)
    _grids: dict[int, tuple[Floats, Floats, Floats]] = field(default_factory=dict, repr=False)

    @property
    def mean_s(self) -> float:
        """⟨τ_h⟩."""
        return self._moments[0]

    @property
    def variance_s2(self) -> float:
        """Variance of τ_h."""
        mean, square = self._moments
        return max(square - mean**2, 0.0)

    @property
    def sd_s(self) -> float:
        """Standard deviation of τ_h."""
        return sqrt(self.variance_s2)

    @property
    def skips(self) -> float:
        """Mean number of skips before the exit is found."""
        solution = self.walk.skips
        return max(float(self._of(solution)[0].real), 0.0)

    @cached_property
    def _moments(self) -> tuple[float, float]:
        """⟨τ⟩ and ⟨τ²⟩, by Cauchy's integrals around s = 0."""
        radius, solution = self.walk.near_zero
        half = self._of(solution)
        coefficients = np.fft.irfft(np.conj(half), _POINTS_OF_CIRCLE)[:3]
        return float(-coefficients[1] / radius), float(2.0 * coefficients[2] / radius**2)

    def within(self, t_s: ArrayLike) -> Floats:
        """Return the probability that the exit is found within times, shape of `t_s`.

        Raises
        ------
        ValueError
            Where a time is below 0 or not finite.
        """
        times = _checked(t_s)
        found = self._singular_law(times).within(times * self._speed)
        self._add_smooth(times, found, per_s=False)
        return np.clip(found, 0.0, 1.0).reshape(np.shape(t_s))

    def survival(self, t_s: ArrayLike) -> Floats:
        """Return the probability that the exit is not found within times, shape of `t_s`.

        Raises
        ------
        ValueError
            Where a time is below 0 or not finite.
        """
        return np.asarray(1.0 - self.within(t_s))

    def density(self, t_s: ArrayLike) -> Floats:
        """Return the density of τ_h, 1/s, without its `atoms`, shape of `t_s`.

        Raises
        ------
        ValueError
            Where a time is below 0 or not finite.
        """
        times = _checked(t_s)
        found = self._singular_law(times).density(times * self._speed) * self._speed
        self._add_smooth(times, found, per_s=True)
        return np.maximum(found, 0.0).reshape(np.shape(t_s))

    def atoms(self, longest_s: float) -> tuple[Floats, Floats]:
        """Return the times, s, up to one, that have a probability of their own, and these.

        A head that never turns reaches the exit, sliding, at exact times. From a uniform start
        there are none.
        """
        where, weights = self._parts.until(longest_s * self._speed).atoms
        kept = (weights > 0.0) & (where <= longest_s * self._speed)
        order = np.argsort(where[kept])
        return where[kept][order] / self._speed, weights[kept][order]

    def quantile(self, probability: float) -> float:
        """Return the first time, s, within which the exit is found with a probability.

        Raises
        ------
        ValueError
            Where the probability is not above 0 and at most `HIGHEST_PROBABILITY`.
        """
        if not 0.0 < probability <= HIGHEST_PROBABILITY:
            raise ValueError(
                f"probability is {probability}; it must be above 0, at most {HIGHEST_PROBABILITY:g}"
            )
        if float(self.within(0.0)) >= probability:
            return 0.0
        number = self._contour_of(probability)
        times, smooth, found = self._grid(number)
        cell = int(np.searchsorted(found, probability))
        cell = min(max(cell, 1), len(times) - 1)
        low, high = times[cell - 1], times[cell]
        first = min(max(cell - 2, 0), len(times) - 4)
        singular = self._singular_law_until(number)
        for _ in range(3):
            fine = np.linspace(low, high, 33)
            value = singular.within(fine * self._speed)
            value += _cubic(fine, times[first : first + 4], smooth[first : first + 4])
            step = int(np.argmax(value >= probability)) if value[-1] >= probability else 32
            step = max(step, 1)
            low, high = fine[step - 1], fine[step]
        return float(high)

    def _contour_of(self, probability: float) -> int:
        """Return the contour on whose grid the probability is reached."""
        number = self.walk.contour_number(self.mean_s)
        while self._grid(number)[2][-1] < probability:
            number += 1
        while self._grid(number)[2][0] >= probability:
            number -= 1
        return number

    def _grid(self, number: int) -> tuple[Floats, Floats, Floats]:
        """Return times from T/16 to T/4, the smooth part of `within`, and all of it."""
        if number not in self._grids:
            contour, _, smooth = self._smooth_part(number)
            first = contour.terms // 16
            times, smooth = contour.grid_s()[first:], smooth[first:]
            found = smooth + self._singular_law_until(number).within(times * self._speed)
            self._grids[number] = times, smooth, np.maximum.accumulate(found)
        return self._grids[number]

    def _add_smooth(self, times: Floats, found: Floats, *, per_s: bool) -> None:
        """Add what is left of the law without its singular terms."""
        positive = np.flatnonzero(times > 0.0)
        numbers = np.array([self.walk.contour_number(t) for t in times[positive]], dtype=np.int64)
        for number in np.unique(numbers):
            at = positive[numbers == number]
            contour, transform, _ = self._smooth_part(int(number))
            found[at] += contour.invert(transform if per_s else transform / contour.s, times[at])

    def _smooth_part(self, number: int) -> tuple[Contour, Complex, Floats]:
        """Return a contour, the density's transform without its singular terms, and `within` of it.

        Terms are doubled until half of them give the same probabilities.
        """
        if number in self._smooth:
            return self._smooth[number]
        # Enough to see single rounds: fewer, and half of them, might both smooth these out.
        a_round = _TERMS_A_ROUND * int(_PERIOD_RATIO ** max(number, 0))
        terms = min(max(_FEWEST_TERMS, a_round), _MOST_TERMS)
        while True:
            contour, transform = self._regular_transform(number, terms)
            half = Contour(contour.period_s, terms // 2)
            cumulative = transform / contour.s
            values = contour.invert_on_grid(cumulative)
            fewer = half.invert_on_grid(cumulative[: half.terms + 1])
            change = float(np.abs(values[::2] - fewer)[half.terms // 16 :].max())
            if change < self.error or terms >= _MOST_TERMS:
                break
            terms *= 2
        self._smooth[number] = contour, transform, values
        return self._smooth[number]

    def _regular_transform(self, number: int, terms: int) -> tuple[Contour, Complex]:
        contour, solution = self.walk.contour(number, terms)
        kappa = contour.s / self._speed
        singular = self._parts.transform(kappa, lambda mm: contour.decay(mm / self._speed))
        return contour, self._of(solution) - singular

    def _of(self, solution: Solution) -> Complex:
        return solution.uniform() if self.relative is None else solution.at(self.relative)

    def _singular_law(self, times: Floats) -> SingularLaw:
        longest = float(times.max(initial=0.0))
        if longest <= 0.0:
            return self._parts.until(0.0)
        return self._singular_law_until(self.walk.contour_number(longest))

    def _singular_law_until(self, number: int) -> SingularLaw:
        """Return the singular terms up to the last time that a contour serves."""
        if number not in self._singular_laws:
            latest_mm = LATEST_OVER_PERIOD * self.walk.period_s(number) * self._speed
            self._singular_laws[number] = self._parts.until(latest_mm)
        return self._singular_laws[number]

    @cached_property
    def _parts(self) -> SingularTerms:
        return singular_terms_of(self.walk.parameters, self.relative)

    @property
    def _speed(self) -> float:
        return self.walk.parameters.speed_mm_s


def _checked(t_s: ArrayLike) -> Floats:
    times = np.atleast_1d(np.asarray(t_s, dtype=np.float64)).ravel()
    if not np.all((times >= 0.0) & (times < inf)):
        raise ValueError("times must be finite and not below 0")
    return times


def _cubic(x: Floats, nodes: Floats, values: Floats) -> Floats:
    """Return the cubic through four evenly spaced points."""
    u = (x - nodes[1]) / (nodes[1] - nodes[0])
    outer = u * (u - 1.0) * (values[3] * (u + 1.0) - values[0] * (u - 2.0)) / 6.0
    inner = (u + 1.0) * (u - 2.0) * (values[1] * (u - 1.0) - values[2] * u) / 2.0
    return np.asarray(outer + inner)
