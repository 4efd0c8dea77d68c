"""The singular terms of the law of τ_h, as a transform and as functions of time.

A head that does not turn reaches the exit at one exact time, so τ_h has atoms; the landing of hops,
and single reversals, make its density jump. All recur with each round of the ring.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from worm_model.boundary_walk.parameters import WalkParameters
from worm_msgs_py.arrays import Complex, Floats

_NEGLIGIBLE = 1e-15
_MOST_NUMBERS_HELD = 1_000_000
"""Numbers held at once."""


@dataclass(frozen=True, slots=True)
class Series:
    """Weights at the distances first, first + P, first + 2P, …, with P the ring's length.

    Their generating function is weight + once·z/(1 − vz) + twice·z²/(1 − vz)², where v is the
    probability that a hop at the exit is a hop at the exit one round later.
    """

    first_mm: float
    weight: float
    once: float = 0.0
    twice: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class SingularTerms:
    """The singular terms of the law from one start; distances stand for times.

    Attributes
    ----------
    parameters : WalkParameters
        The walk.
    factor : float
        The v of `Series`.
    fade_per_mm : float
        A jump fades with distance y as exp(−fade·y).
    atoms : tuple of Series
        Probabilities of being found at exact distances, without a reversal (or with one at the
        exit's very edge).
    landings : tuple of (Series, length)
        Hops that begin to pass over the exit, with the length of arc before them.
    jumps : tuple of Series
        Jumps of the remaining density, per mm.
    """

    parameters: WalkParameters
    factor: float
    fade_per_mm: float
    atoms: tuple[Series, ...]
    landings: tuple[tuple[Series, float], ...]
    jumps: tuple[Series, ...]

    def transform(self, kappa: Complex, decay: Callable[[float], Complex]) -> Complex:
        """Return the part of ⟨e^{−κ·distance}⟩ that these parts make.

        Parameters
        ----------
        kappa : ndarray of complex, shape (n,)
            Per mm.
        decay : callable
            Gives e^{−κ·distance} for a distance in mm.
        """
        z = decay(self.parameters.circumference_mm)
        turn = z / (1.0 - self.factor * z)

        def of(series: Series) -> Complex:
            total = series.weight + turn * (series.once + series.twice * turn)
            return np.asarray(total * decay(series.first_mm))

        eta, leave = hop_rates(self.parameters)
        total = np.zeros_like(kappa)
        for atom in self.atoms:
            total += of(atom)
        for series, arc in self.landings:
            lands = eta / (leave + kappa) * (1.0 - np.exp(-leave * arc) * decay(arc))
            total += of(series) * lands
        jumps = np.zeros_like(kappa)
        for jump in self.jumps:
            jumps += of(jump)
        return total + jumps / (kappa + self.fade_per_mm)

    def until(self, longest_mm: float) -> "SingularLaw":
        """Return these parts, each round by itself, up to a distance."""
        arcs = [arc for _, arc in self.landings]
        return SingularLaw(
            hop_rates(self.parameters),
            self.fade_per_mm,
            self._rounds(self.atoms, longest_mm),
            [
                (self._rounds((series,), longest_mm), arc)
                for (series, _), arc in zip(self.landings, arcs, strict=True)
            ],
            self._rounds(self.jumps, longest_mm),
        )

    def _rounds(self, parts: tuple[Series, ...], longest_mm: float) -> tuple[Floats, Floats]:
        ring = self.parameters.circumference_mm
        if not parts:
            return np.empty(0), np.empty(0)
        first, weight, once, twice = np.array(
            [(part.first_mm, part.weight, part.once, part.twice) for part in parts]
        ).T[:, :, np.newaxis]
        k = np.arange(int(max(longest_mm - float(first.min()), 0.0) / ring) + 1, dtype=np.float64)
        weights = np.where(k == 0.0, weight, 0.0)
        weights += np.where(k >= 1.0, self.factor ** np.maximum(k - 1.0, 0.0), 0.0) * once
        later = np.where(k >= 2.0, self.factor ** np.maximum(k - 2.0, 0.0), 0.0) * (k - 1.0)
        weights += later * twice
        keep = np.abs(weights) > _NEGLIGIBLE
        return (first + k * ring)[keep], weights[keep]


@dataclass(frozen=True, eq=False, slots=True)
class SingularLaw:
    """The singular terms as functions of distance: pairs of where each begins and its weight."""

    hop_rates_per_mm: tuple[float, float]
    fade_per_mm: float
    atoms: tuple[Floats, Floats]
    landings: list[tuple[tuple[Floats, Floats], float]]
    jumps: tuple[Floats, Floats]

    def within(self, distance_mm: Floats) -> Floats:
        """Return the probability, from these parts, of being found within distances."""
        lands, leave = self.hop_rates_per_mm
        fade = self.fade_per_mm
        total = _sum(self.atoms, distance_mm, np.ones_like)
        for begins, arc in self.landings:
            share = partial(_landed, lands=lands, leave=leave, arc=arc)
            total += _sum(begins, distance_mm, share)
        return total + _sum(self.jumps, distance_mm, lambda y: -np.expm1(-fade * y) / fade)

    def density(self, distance_mm: Floats) -> Floats:
        """Return the density that these parts make without the atoms, per mm."""
        lands, leave = self.hop_rates_per_mm
        fade = self.fade_per_mm
        total = _sum(self.jumps, distance_mm, lambda y: np.exp(-fade * y))
        for begins, arc in self.landings:
            share = partial(_landing, lands=lands, leave=leave, arc=arc)
            total += _sum(begins, distance_mm, share)
        return total


def _landed(y: Floats, lands: float, leave: float, arc: float) -> Floats:
    return np.asarray(-lands / leave * np.expm1(-leave * np.minimum(y, arc)))


def _landing(y: Floats, lands: float, leave: float, arc: float) -> Floats:
    return np.where(y < arc, lands * np.exp(-leave * y), 0.0)


def _sum(
    begins: tuple[Floats, Floats], distance_mm: Floats, shape: Callable[[Floats], Floats]
) -> Floats:
    """Return Σ weight·shape(distance − begin) over the parts that have begun."""
    where, weights = begins
    total = np.zeros(len(distance_mm))
    rows = max(_MOST_NUMBERS_HELD // max(len(where), 1), 1)
    for first in range(0, len(distance_mm), rows):
        since = distance_mm[first : first + rows, np.newaxis] - where
        begun = since >= 0.0
        total[first : first + rows] = (begun * shape(np.where(begun, since, 0.0))) @ weights
    return total


def hop_rates(parameters: WalkParameters) -> tuple[float, float]:
    """Return the rates, per mm, at which a hop above the exit lands, and ends or turns."""
    rho = parameters.flip_rate_s / parameters.speed_mm_s
    eta = 1.0 / parameters.mean_hop_mm
    return (eta if parameters.hop_may_land else 0.0), eta + rho
