"""What the analysis says: per-frame observables, and estimates that grow with the trial."""

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.contract.frames import Where


@dataclass(frozen=True, slots=True)
class Observables:
    """The symbols of the paper for one frame, NaN where they cannot be had.

    Attributes
    ----------
    frame, stamp_ns : int
        Those of the state that they come from.
    where : Where
        The part of the rig that holds the head.
    r_h_m, r_c_m, r_t_m : float
        Distance of head tip, centroid and tail tip from the chamber's centre.
    theta_h_rad : float
        Polar angle of the head, unwrapped in time since the chamber was entered.
    psi_b_rad : float
        Signed angle from the outward normal at the head to the body vector (head − centroid),
        counter-clockwise positive.
    psi_h_rad : float
        The same with the head's own direction.
    theta_dot_rad_s : float
        Δθ_h/Δt over the last Δt = 1 s.
    v_b_m_s : float
        R·θ̇_h.
    contact : bool or None
        Whether R − r_h < 0.3·d_w without noise, as far as known then; None where it cannot be told.
    """

    frame: int
    stamp_ns: int
    where: Where = Where.UNKNOWN
    r_h_m: float = nan
    r_c_m: float = nan
    r_t_m: float = nan
    theta_h_rad: float = nan
    psi_b_rad: float = nan
    psi_h_rad: float = nan
    theta_dot_rad_s: float = nan
    v_b_m_s: float = nan
    contact: bool | None = None


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with what it takes to trust it.

    Attributes
    ----------
    name : str
        The symbol of docs/science.md in ASCII (``d_c``, ``psi_b_negative_peak``).
    value : float or None
        None where it cannot be had; `why` then says why.
    low, high : float or None
        95 % confidence interval.
    n : int
        Number of independent items that it rests on (episodes, frames, visits).
    unit : str
        As written for people: ``mm``, ``deg``, ``s``, ``mm/s``, ``1``.
    paper : float or None
        The paper's value, same unit.
    why : str
        Empty, or why there is no value.
    """

    name: str
    value: float | None
    low: float | None = None
    high: float | None = None
    n: int = 0
    unit: str = "1"
    paper: float | None = None
    why: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Correlation:
    """C_θ(t) with its error, beside the model's.

    Attributes
    ----------
    lag_s : ndarray, shape (n,)
        Time lags.
    c : ndarray, shape (n,)
        C_θ, NaN where there are no pairs.
    error : ndarray, shape (n,)
        One standard error; NaN where it cannot be had.
    pairs : ndarray of int64, shape (n,)
        Number of pairs of frames.
    model : ndarray, shape (n,)
        exp(−t/t_per) with the fitted t_per; NaN where there is none. (The boundary walk's own
        C_θ comes on `model/correlation`: the analysis does not read the model.)
    """

    lag_s: NDArray[np.float64]
    c: NDArray[np.float64]
    error: NDArray[np.float64]
    pairs: NDArray[np.int64]
    model: NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Distribution:
    """A histogram of one bin or more.

    Attributes
    ----------
    name : str
        ``r_h``, ``r_c``, ``r_t``, ``psi_b``, ``d_c``, ``d_nc``, ``delta_r_h``, ``x_p``.
    unit : str
        Unit of the edges: ``m`` or ``rad``.
    edges : ndarray, shape (n + 1,)
        Bin edges, ascending.
    counts : ndarray of int64, shape (n,)
        Items in each bin.
    """

    name: str
    unit: str
    edges: NDArray[np.float64]
    counts: NDArray[np.int64]
