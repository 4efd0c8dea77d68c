"""The analysis written plainly over whole arrays: the oracle that the streaming one must equal.

Nothing is shared with `worm_analysis`: every definition of docs/science.md is written out again.
"""

import numpy as np

from worm_msgs_py import Where

R = 0.01
GAP_NS = 500_000_000
WINDOW_NS = 1_000_000_000
FACTOR = 0.3


def wrapped(angle):
    return np.arctan2(np.sin(angle), np.cos(angle))


class Offline:
    """Everything of a `Track`, one array a symbol, NaN where it cannot be had."""

    def __init__(self, track):
        self.track = track
        n = len(track.stamp_ns)
        x, y = track.head.T
        self.r_h = np.sqrt(x**2 + y**2)
        self.r_c = np.sqrt((track.centroid**2).sum(axis=1))
        self.r_t = np.sqrt((track.tail**2).sum(axis=1))
        normal = np.arctan2(y, x)
        body = track.head - track.centroid
        self.psi_b = wrapped(np.arctan2(body[:, 1], body[:, 0]) - normal)
        self.psi_h = wrapped(track.yaw - normal)
        in_chamber = np.array([w in (Where.CHAMBER_A, Where.CHAMBER_B) for w in track.where])
        self.valid = np.isfinite(x) & in_chamber
        self._find_stretches(np.isfinite(x) & ~in_chamber)
        self.theta = np.full(n, np.nan)
        self.theta_dot = np.full(n, np.nan)
        for visit in np.unique(self.visit[self.valid]):
            rows = self.valid & (self.visit == visit)
            self.theta[rows] = np.unwrap(normal[rows])
        for stretch in self.stretches():
            self.theta_dot[stretch] = self._speed(stretch)
        self._find_contacts()

    def _find_stretches(self, in_passage):
        """Number the visits, and the unbroken stretches within them."""
        n = len(self.valid)
        self.visit, self.stretch = np.full(n, -1), np.full(n, -1)
        visit, stretch, last = -1, -1, None
        for row in range(n):
            if not self.valid[row]:
                continue
            new_visit = (
                last is None
                or self.track.chamber[row] != self.track.chamber[last]
                or in_passage[last:row].any()
            )
            visit += new_visit
            if new_visit or self.track.stamp_ns[row] - self.track.stamp_ns[last] > GAP_NS:
                stretch += 1
            self.visit[row], self.stretch[row], last = visit, stretch, row

    def stretches(self):
        return [np.flatnonzero(self.stretch == k) for k in range(self.stretch.max() + 1)]

    def _speed(self, rows):
        t = self.track.stamp_ns[rows] - self.track.stamp_ns[rows[0]]
        past = np.interp((t - WINDOW_NS).astype(float), t.astype(float), self.theta[rows])
        speed = (self.theta[rows] - past) / 1.0
        speed[t < WINDOW_NS] = np.nan
        return speed

    def _find_contacts(self):
        """The threshold rests on the median of all widths up to the frame, from bins of 2 µm."""
        counts = np.zeros(1000)
        self.contact = np.full(len(self.valid), np.nan)
        for row, width in enumerate(self.track.width):
            if np.isfinite(width):
                counts[int(width / 2e-6)] += 1
            if not self.valid[row] or counts.sum() == 0:
                continue
            upto = np.cumsum(counts)
            at = np.flatnonzero(upto >= upto[-1] / 2)[0]
            inside = (upto[-1] / 2 - (upto[at] - counts[at])) / counts[at]
            self.contact[row] = R - self.r_h[row] < FACTOR * (at + inside) * 2e-6

    def episodes(self):
        """Rows (chamber, in contact, start, end, distance, Δr, complete) in order of time."""
        found = []
        for rows in self.stretches():
            rows = rows[np.isfinite(self.contact[rows])]
            if not len(rows):
                continue
            change = np.flatnonzero(np.diff(self.contact[rows])) + 1
            starts = [0, *change]
            ends = [*change, len(rows)]
            for k, (start, end) in enumerate(zip(starts, ends, strict=True)):
                last = k == len(starts) - 1
                first_row, end_row = rows[start], rows[end - 1] if last else rows[end]
                in_contact = bool(self.contact[first_row])
                depth = np.nan if in_contact else (R - self.r_h[rows[start:end]]).max()
                distance = R * abs(self.theta[end_row] - self.theta[first_row])
                found.append(
                    (
                        str(self.track.chamber[first_row]),
                        in_contact,
                        int(self.track.stamp_ns[first_row]),
                        int(self.track.stamp_ns[end_row]),
                        distance,
                        depth,
                        bool(k > 0 and not last),
                    )
                )
        return found

    def correlation(self, lag_cells, step_ns):
        """C_θ and its pairs over all pairs of cells of one stretch, the plain double sum."""
        known = np.flatnonzero(np.isfinite(self.theta_dot))
        if not len(known):
            return np.full(len(lag_cells), np.nan), np.zeros(len(lag_cells), dtype=int)
        cells = (self.track.stamp_ns[known] - self.track.stamp_ns[known[0]]) // step_ns
        cells, first = np.unique(cells, return_index=True)
        sign = np.sign(self.theta_dot[known[first]])
        stretch = self.stretch[known[first]]
        apart = cells[:, None] - cells[None, :]
        product = sign[:, None] * sign[None, :]
        together = stretch[:, None] == stretch[None, :]
        c, pairs = [], []
        for lag in lag_cells:
            chosen = (apart == lag) & together
            pairs.append(int(chosen.sum()))
            c.append(product[chosen].mean() if chosen.any() else np.nan)
        return np.array(c), np.array(pairs)

    def slope_of_speed(self):
        """v_w of v_b = v_w sin ψ_b through the origin."""
        rows = np.isfinite(self.theta_dot) & np.isfinite(self.psi_b)
        s, v = np.sin(self.psi_b[rows]), R * self.theta_dot[rows]
        return (s @ v) / (s @ s)
