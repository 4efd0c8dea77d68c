"""Numerical inversion of Laplace transforms by a Fourier series along a vertical line.

The series of Dubner and Abate (1968): with s_k = a + iπk/T,

    f(t) ≈ e^{at}/T · (½ F(s₀) + Re Σ_k F(s_k) e^{iπkt/T}),   0 < t ≤ T/4.

What lies beyond 2T folds back with e^{−2aT}, here 2·10⁻⁹; what the series leaves out falls with
the smoothness of f. It is meant for functions between −1 and 1 with a continuous derivative.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, exp, pi, sqrt

import numpy as np
from scipy.special import erfc

from worm_msgs_py.arrays import Complex, Floats

_DAMPING = 10.0
_STEEPNESS = 3.0
LATEST_OVER_PERIOD = 0.25
"""Share of T up to which a contour serves."""


@dataclass(frozen=True, slots=True)
class Contour:
    """A vertical line in the plane of s.

    Attributes
    ----------
    period_s : float
        T; the contour serves times up to T/4, best above T/16.
    terms : int
        Terms of the series; divisible by 16.
    """

    period_s: float
    terms: int

    @property
    def s(self) -> Complex:
        """The points s_k, 1/s, shape (terms + 1,)."""
        return np.asarray((_DAMPING + 1j * pi * np.arange(self.terms + 1)) / self.period_s)

    def decay(self, delay_s: float) -> Complex:
        """Return e^{−s_k·delay}: a geometric sequence, made of two short ones."""
        step = -1j * pi * delay_s / self.period_s
        short = ceil(sqrt(self.terms + 1))
        coarse = np.exp(step * short * np.arange(short))
        product = np.multiply.outer(coarse, np.exp(step * np.arange(short))).ravel()
        return np.asarray(product[: self.terms + 1] * exp(-_DAMPING * delay_s / self.period_s))

    def grid_s(self) -> Floats:
        """Return the times of `invert_on_grid`, shape (terms/4 + 1,), from 0 to T/4."""
        return np.arange(self.terms // 4 + 1, dtype=np.float64) * (self.period_s / self.terms)

    def invert_on_grid(self, transform: Complex) -> Floats:
        """Return f at the times of `grid_s` from its transform at `s`."""
        t = self.grid_s()
        series = np.fft.irfft(transform * _taper(self.terms), 2 * self.terms)[: len(t)] * self.terms
        return np.asarray(series * np.exp(_DAMPING * t / self.period_s) / self.period_s)

    def invert(self, transform: Complex, t_s: Floats) -> Floats:
        """Return f at any times up to T/4 from its transform at `s`."""
        short = ceil(sqrt(self.terms + 1))
        padded = np.zeros(short * short, dtype=np.complex128)
        padded[: self.terms + 1] = transform * _taper(self.terms)
        padded[0] /= 2.0
        angle = 1j * pi * t_s / self.period_s
        fine = np.exp(np.multiply.outer(np.arange(short), angle))
        coarse = np.exp(np.multiply.outer(short * np.arange(short), angle))
        series = (coarse * (padded.reshape(short, short) @ fine)).sum(axis=0).real
        return np.asarray(series * np.exp(_DAMPING * t_s / self.period_s) / self.period_s)


@lru_cache(maxsize=32)
def _taper(terms: int) -> Floats:
    """Return the weights of the terms: the last half fades, shape (terms + 1,).

    A sharp end of the series would let a kink of f spoil f everywhere; so it does nearby only.
    """
    part = np.arange(terms + 1) / terms
    return np.asarray(0.5 * erfc(_STEEPNESS * (4.0 * part - 3.0)))
