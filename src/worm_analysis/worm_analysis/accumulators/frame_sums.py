"""What every frame adds to: histograms of r and ψ, and the sums behind v_w, v_b and contact."""

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import NDArray

from worm_analysis.accumulators.bins import (
    ANGLE_BINS,
    ANGLE_EDGES,
    RADIUS_BINS,
    RADIUS_BINS_PER_R,
    RADIUS_EDGES,
)
from worm_analysis.accumulators.direction_bridges import DirectionBridge
from worm_analysis.accumulators.frame_rows import Frames
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_msgs_py import Distribution
from worm_msgs_py.arrays import Floats, Integers
from worm_msgs_py.units import NS_PER_S

_HISTOGRAMS = ("r_h", "r_c", "r_t", "psi_b", "psi_h")
_SUMS = (
    "contact",
    "contact_known",
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
    "gaps",
    "gap_turns",
    "gap_s",
)
_SUMS_OF = {
    "contact_fraction": ("contact_known", "contact"),
    "v_b_mean": ("speed_n", "velocity"),
    "reversal_rate": ("directed_s", "turns_back"),
    "reversal_rate_gaps": ("gaps", "gap_turns", "gap_s"),
    "theta_dot_psi_b": ("pairs", "theta_dot", "psi_b", "theta_dot_2", "psi_b_2", "theta_dot_psi_b"),
}
"""Which sums a quantity rests on."""
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

    def add(self, frames: Frames, bridges: Sequence[DirectionBridge] = ()) -> None:
        """Add frames with the head in a chamber, and the gaps that end in them."""
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
        gaps = np.zeros((3, len(frames)))
        for bridge in bridges:
            duration_s = (bridge.end_ns - bridge.start_ns) / NS_PER_S
            gaps[:, bridge.row] = (1.0, bridge.before != bridge.after, duration_s)
        sums = [
            frames.contact,
            np.isfinite(frames.contact),
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
            *gaps,
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

    def histogram(self, name: str) -> Integers:
        """Return the counts of one of the histograms."""
        counts: Integers = np.rint(self._blocks.total(_columns_of(name))).astype(np.int64)
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

    def sums(self) -> dict[str, Floats]:
        """Return the sums behind each quantity by blocks of time, the number of items first."""
        rows = self._blocks.rows()
        frames = {name: rows[:, _columns_of(name)] for name in ("r_h", "r_c", "r_t", "psi_b")}
        directions = rows[:, [_AT["sin_psi_b"], _AT["cos_psi_b"]]]
        with_body = frames["psi_b"].sum(axis=1, keepdims=True)
        return frames | {
            "psi_b_mean": np.hstack([with_body, directions]),
            **{name: rows[:, [_AT[part] for part in parts]] for name, parts in _SUMS_OF.items()},
        }


def _bins(name: str, position: Floats) -> NDArray[np.intp]:
    """Return each position's column; −1 for NaN and for what is out of range."""
    size = _SIZES[name]
    inside = (position >= 0) & (position < size)
    whole = np.where(inside, position, 0.0).astype(np.intp)
    if size == ANGLE_BINS:  # +π is in the last bin
        inside |= position == size
        whole[position == size] = size - 1
    return np.where(inside, _STARTS[name] + whole, -1)


def _columns_of(name: str) -> slice:
    return slice(_STARTS[name], _STARTS[name] + _SIZES[name])
