"""Frames of the search along the wall, kept for a moment as rows and handed on as arrays."""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Floats, Integers


@dataclass(frozen=True, eq=False, slots=True)
class Frames:
    """Frames in a row, a column a symbol, NaN where it cannot be had; each of shape (m,).

    Attributes
    ----------
    stamp_ns : ndarray of int64
        Stamps, ascending.
    stretch : ndarray of int64
        Number of the unbroken stretch: it grows at every gap and with every visit.
    approach : ndarray of int64
        Number of the unbroken stretch at the wall: it also grows where the head enters the exit.
    search : ndarray of int64
        Number of the stretch in which the direction is followed, over gaps that are bridged: it
        grows with every visit, at gaps that are too long, and where the head enters the exit.
    interval_s : ndarray
        Time since the frame before, 0 after a break.
    r_h_m, r_c_m, r_t_m, theta_h_rad, theta_dot_rad_s, psi_b_rad, psi_h_rad : ndarray
        As in `Observables`.
    contact : ndarray
        1, 0, or NaN.
    depth_widths : ndarray
        (R − r_h)/d_w, the head's distance from the wall in widths of the body.
    """

    stamp_ns: Integers
    stretch: Integers
    approach: Integers
    search: Integers
    interval_s: Floats
    r_h_m: Floats
    r_c_m: Floats
    r_t_m: Floats
    theta_h_rad: Floats
    theta_dot_rad_s: Floats
    psi_b_rad: Floats
    psi_h_rad: Floats
    contact: Floats
    depth_widths: Floats

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def stretches(self) -> list[slice]:
        """Return the parts that lie in one unbroken stretch each."""
        cuts = (np.flatnonzero(np.diff(self.stretch)) + 1).tolist()
        return [slice(a, b) for a, b in zip([0, *cuts], [*cuts, len(self)], strict=True)]


class FrameRows:
    """Gathers rows until there are enough to be worth an array.

    What is summed from arrays of a thousand frames costs a tenth of what it costs frame by frame.
    All sums that rest on them add in the frames' order, so that they do not depend, to the last
    bit, on when the rows are handed on.
    """

    MOST = 1024

    def __init__(self) -> None:
        self._whole: list[tuple[int, int, int, int]] = []
        self._real: list[tuple[float, ...]] = []

    def __len__(self) -> int:
        return len(self._whole)

    def push(self, whole: tuple[int, int, int, int], real: tuple[float, ...]) -> bool:
        """Take a frame's columns in the order of `Frames`; return whether there are enough."""
        self._whole.append(whole)
        self._real.append(real)
        return len(self._whole) >= self.MOST

    def take(self) -> Frames:
        """Return what was gathered, and begin anew."""
        whole = np.array(self._whole, dtype=np.int64).T
        real = np.ascontiguousarray(np.array(self._real, dtype=np.float64).T)
        self._whole, self._real = [], []
        return Frames(*whole, *real)
