"""What a boundary walk predicts for a pool: worked out elsewhere, the analysis reads no model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, eq=False, slots=True)
class WalkPrediction:
    """The walk's numbers at several exit widths.

    Attributes
    ----------
    is_own : bool
        Whether its parameters are those of the pool, rather than the paper's.
    parameters : mapping of str to float or str
        Its parameters, with units in their names.
    width_mm : ndarray, shape (k,)
        W, ascending.
    tau_h_s, n_s : ndarray, shape (k,)
        Mean time to find the exit, and skips in 30 min.
    tau_low_s, tau_high_s, n_s_low, n_s_high : ndarray, shape (k,)
        Their range over the reversals that are thought possible; NaN where no range is given.
    edges_s, density : mapping of float to ndarray
        P(τ_h) in bins, 1/s, by W.
    lag_s, c : ndarray
        C_θ.
    """

    is_own: bool
    parameters: Mapping[str, float | str]
    width_mm: Floats
    tau_h_s: Floats
    n_s: Floats
    tau_low_s: Floats
    tau_high_s: Floats
    n_s_low: Floats
    n_s_high: Floats
    edges_s: Mapping[float, Floats]
    density: Mapping[float, Floats]
    lag_s: Floats
    c: Floats

    def density_at(self, width_mm: float) -> tuple[Floats, Floats]:
        """Return the edges of the bins and the density of τ_h at one of the pool's widths."""
        return self.edges_s[width_mm], self.density[width_mm]

    def at_widths(self, name: str, widths_mm: Sequence[float]) -> list[float]:
        """Return ``tau_h`` or ``n_s`` at some widths, between those that were worked out."""
        values = self.tau_h_s if name == "tau_h" else self.n_s
        return [float(value) for value in np.interp(widths_mm, self.width_mm, values)]
