"""The analysis written plainly over whole arrays: the oracle that the streaming one must equal.

Nothing is shared with `worm_analysis`: every definition of docs/science.md is written out again.
"""

from itertools import pairwise

import numpy as np

from worm_msgs_py import Where

R = 0.01
GAP_NS = 500_000_000
BRIDGE_NS = 10_000_000_000
WINDOW_NS = 1_000_000_000
FACTOR = 0.3
CERTAIN = 0.9
INCIDENCE_NS = 100_000_000
MEAN_NS = 12_000_000_000
HALF_ARC = np.arcsin(0.5e-3 / R)


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
        trusted = np.isfinite(x) & (track.certainty >= CERTAIN)
        self.valid = trusted & in_chamber
        self.in_passage = trusted & ~in_chamber
        self._find_stretches(self.in_passage)
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
        self.visit, self.stretch, self.search = (np.full(n, -1) for _ in range(3))
        visit, stretch, search, last = -1, -1, -1, None
        for row in range(n):
            if not self.valid[row]:
                continue
            new_visit = (
                last is None
                or self.track.chamber[row] != self.track.chamber[last]
                or in_passage[last:row].any()
            )
            visit += new_visit
            gap_ns = 0 if new_visit else self.track.stamp_ns[row] - self.track.stamp_ns[last]
            stretch += new_visit or gap_ns > GAP_NS
            search += new_visit or gap_ns > BRIDGE_NS
            self.visit[row], self.stretch[row], self.search[row] = visit, stretch, search
            last = row

    def stretches(self):
        return [np.flatnonzero(self.stretch == k) for k in range(self.stretch.max() + 1)]

    def _speed(self, rows):
        t = self.track.stamp_ns[rows] - self.track.stamp_ns[rows[0]]
        past = np.interp((t - WINDOW_NS).astype(float), t.astype(float), self.theta[rows])
        speed = (self.theta[rows] - past) / 1.0
        speed[t < WINDOW_NS] = np.nan
        return speed

    def _find_contacts(self):
        """The threshold rests on the median of all tracked widths so far, from bins of 2 µm."""
        counts = np.zeros(1000)
        self.contact = np.full(len(self.valid), np.nan)
        self.depth_widths = np.full(len(self.valid), np.nan)
        for row, width in enumerate(self.track.width):
            if np.isfinite(width) and np.isfinite(self.r_h[row]):
                counts[int(width / 2e-6)] += 1
            if not self.valid[row] or counts.sum() == 0:
                continue
            upto = np.cumsum(counts)
            at = np.flatnonzero(upto >= upto[-1] / 2)[0]
            inside = (upto[-1] / 2 - (upto[at] - counts[at])) / counts[at]
            self.depth_widths[row] = (R - self.r_h[row]) / ((at + inside) * 2e-6)
            self.contact[row] = self.depth_widths[row] < FACTOR

    def _enters(self, row):
        """Whether the next frame that counts sees the head in the exit, without a gap."""
        later = np.flatnonzero((self.valid | self.in_passage)[row + 1 :]) + row + 1
        if not len(later) or not self.in_passage[later[0]]:
            return False
        return self.track.stamp_ns[later[0]] - self.track.stamp_ns[row] <= GAP_NS

    def _runs(self, rows, on, off, min_ns):
        """Cut one stretch into (in contact, first row) by the rule, frame by frame."""
        runs, touching = [], False
        for row in rows:
            touching = self.depth_widths[row] < (off if touching else on)
            if not runs or touching != runs[-1][0]:
                runs.append([touching, row, row])
            runs[-1][2] = row
        kept = runs[:1]
        for kind, first, last in runs[1:]:
            if (
                kind != kept[-1][0]
                and self.track.stamp_ns[last] - self.track.stamp_ns[first] >= min_ns
            ):
                kept.append([kind, first, last])
        return [(kind, first) for kind, first, _ in kept]

    def episodes(self, on=FACTOR, off=FACTOR, min_ns=0):
        """Dicts of one episode each, in order of time."""
        found = []
        for stretch in self.stretches():
            rows = stretch[np.isfinite(self.contact[stretch])]
            if not len(rows):
                continue
            runs = self._runs(rows, on, off, min_ns)
            for k, (in_contact, first) in enumerate(runs):
                last = k == len(runs) - 1
                end = rows[-1] if last else runs[k + 1][1]
                own = rows[(rows >= first) & ((rows <= end) if last else (rows < end))]
                at = np.searchsorted(rows, first)
                found.append(
                    {
                        "chamber": str(self.track.chamber[first]),
                        "in_contact": bool(in_contact),
                        "start_ns": int(self.track.stamp_ns[first]),
                        "end_ns": int(self.track.stamp_ns[end]),
                        "distance": R * abs(self.theta[end] - self.theta[first]),
                        "depth": np.nan if in_contact else (R - self.r_h[own]).max(),
                        "complete": bool(
                            k > 0 and (not last or (not in_contact and self._enters(stretch[-1])))
                        ),
                        "cut": last,
                        "start_seen": k > 0,
                        "first": first,
                        "end": end,
                        "before": rows[at - 1] if k > 0 else None,
                        "stretch": stretch,
                    }
                )
        return found

    def way_near_wall(self):
        """Time and way of the phases near the wall, and the time that turns between frames cost.

        A phase goes from its start to where it turns round first, and so on to its end.
        """
        time_s = way = lost_s = 0.0
        before = None
        told = np.isfinite(self.contact)
        for e in self.episodes():
            here = slice(e["first"], e["end"])
            ends = np.array([self.theta[e["first"]], self.theta[e["end"]]])
            turn, spent_s = np.diff(ends)[0], (e["end_ns"] - e["start_ns"]) / 1e9
            frames = max(told[here].sum(), 1)
            upwards = 1 if turn >= 0 else -1
            seen = upwards * np.append(ends, self.theta[here][told[here]])
            beyond = np.array([upwards * ends[0] - seen.min(), seen.max() - upwards * ends[1]])
            beyond[beyond <= (abs(turn) + 2 * beyond.sum()) / frames] = 0.0
            signs = upwards * np.where(beyond > 0, -1, 1)
            if not e["depth"] > 0.15 * R:
                turned = before is not None and before * signs[0] < 0 and turn != 0
                part = min((turned + np.sum(beyond > 0) / 2) / frames, 1.0)
                time_s += spent_s * (1 - part)
                lost_s += spent_s * part
                way += e["distance"] + 2 * R * beyond.sum()
            before = None if e["cut"] else signs[1] * (turn != 0)
        return time_s, way, lost_s

    def excess(self, in_contact, cutoff, **rule):
        """Complete episodes above a cut-off, and what all above it exceed it by."""
        chosen = [
            e
            for e in self.episodes(**rule)
            if e["start_seen"] and e["in_contact"] == in_contact and e["distance"] >= cutoff
        ]
        return sum(e["complete"] for e in chosen), sum(e["distance"] - cutoff for e in chosen)

    def skips(self):
        """Hops near the wall from one side of the exit to its other side."""
        count = 0
        for e in self.episodes():
            if e["in_contact"] or not e["complete"] or e["cut"] or e["depth"] >= R / 2:
                continue
            ends = sorted(self.theta[[e["before"], e["end"]]])
            for turn in range(-40, 41):
                exit_at = 2 * np.pi * turn
                count += ends[0] <= exit_at - HALF_ARC and exit_at + HALF_ARC <= ends[1]
        return count

    def collisions(self):
        """Rows (incidence, speed over the second after it) of every contact that has both."""
        found = []
        for e in self.episodes():
            rows = e["stretch"]
            t = self.track.stamp_ns[rows]
            after = e["start_ns"] + WINDOW_NS
            if not e["in_contact"] or not e["start_seen"] or t[-1] < after:
                continue
            at = int(np.searchsorted(rows, e["first"]))
            recent = np.flatnonzero(t[:at] >= e["start_ns"] - INCIDENCE_NS)
            before = self.track.head[rows[recent[0] if len(recent) else at - 1]]
            here = self.track.head[e["first"]]
            way = here - before
            incidence = wrapped(np.arctan2(way[1], way[0]) - np.arctan2(here[1], here[0]))
            later = np.interp(float(after - t[0]), (t - t[0]).astype(float), self.theta[rows])
            found.append((incidence, later - self.theta[e["first"]]))
        return np.array(found).reshape(-1, 2)

    def windows(self):
        """Rows (mean v_b, sine of psi_b's mean) of the windows of each stretch, nearly full ones.

        The sine is that of the mean on either side of the normal, weighted by their times.
        """
        known = np.isfinite(self.theta_dot) & np.isfinite(self.psi_b)
        found = []
        for rows in self.stretches():
            rows = rows[known[rows]]
            t = self.track.stamp_ns[rows] - self.track.stamp_ns[rows[:1]]
            for window in np.unique(t // MEAN_NS):
                own = t // MEAN_NS == window
                if np.ptp(t[own]) < 0.9 * MEAN_NS:
                    continue
                psi = self.psi_b[rows[own]]
                sides = [side for side in (psi[psi > 0], psi[psi <= 0]) if len(side)]
                s = sum(len(side) * np.sin(side.mean()) for side in sides) / len(psi)
                found.append(((R * self.theta_dot[rows[own]]).mean(), s))
        return np.array(found).reshape(-1, 2)

    def bridges(self):
        """Pairs of rows with a direction on either side of a gap over which it is followed."""
        known = np.flatnonzero(np.isfinite(self.theta_dot))
        return [
            (a, b)
            for a, b in pairwise(known.tolist())
            if self.stretch[a] != self.stretch[b]
            and self.search[a] == self.search[b]
            and self.track.stamp_ns[b] - self.track.stamp_ns[a] <= BRIDGE_NS + WINDOW_NS
            and self.theta_dot[a] * self.theta_dot[b] != 0
        ]

    def turns(self):
        """Times that the direction turned, and the time with a direction."""
        turns, directed_s, last = 0, 0.0, 0.0
        for row in np.flatnonzero(self.valid):
            sign = np.sign(self.theta_dot[row])
            if np.isnan(sign):
                last = 0.0
            elif sign != 0:
                if last:
                    before = np.flatnonzero(self.valid[:row])[-1]
                    directed_s += (self.track.stamp_ns[row] - self.track.stamp_ns[before]) / 1e9
                turns += sign == -last
                last = sign
        return turns, directed_s

    def gaps(self):
        """Gaps over which the direction is followed, those after which it is another, and s."""
        found = self.bridges()
        turned = sum(self.theta_dot[a] * self.theta_dot[b] < 0 for a, b in found)
        return (
            len(found),
            turned,
            sum(np.diff(self.track.stamp_ns[[a, b]])[0] for a, b in found) / 1e9,
        )

    def correlation(self, lag_cells, step_ns):
        """C_θ and its pairs over all pairs of cells of one search, the plain double sum."""
        known = np.flatnonzero(np.isfinite(self.theta_dot))
        if not len(known):
            return np.full(len(lag_cells), np.nan), np.zeros(len(lag_cells), dtype=int)
        stamps = self.track.stamp_ns - self.track.stamp_ns[known[0]]
        cells, first = np.unique(stamps[known] // step_ns, return_index=True)
        sign = np.sign(self.theta_dot[known[first]])
        joined = dict(self.bridges())
        breaks = [
            self.stretch[a] != self.stretch[b] and a not in joined
            for a, b in pairwise(known.tolist())
        ]
        stretch = np.concatenate([[0], np.cumsum(breaks)])[first]
        for a, b in joined.items():  # the gap's cells, a reversal in its middle
            empty = np.arange(stamps[a] // step_ns + 1, stamps[b] // step_ns)
            early = empty * step_ns < (stamps[a] + stamps[b] - step_ns) // 2
            cells = np.concatenate([cells, empty])
            sign = np.concatenate([sign, np.sign(self.theta_dot[np.where(early, a, b)])])
            here = stretch[np.flatnonzero(known[first] <= a)[-1]]
            stretch = np.concatenate([stretch, np.full(len(empty), here)])
        apart = cells[:, None] - cells[None, :]
        product = sign[:, None] * sign[None, :]
        together = stretch[:, None] == stretch[None, :]
        c, pairs = [], []
        for lag in lag_cells:
            chosen = (apart == lag) & together
            pairs.append(int(chosen.sum()))
            c.append(product[chosen].mean() if chosen.any() else np.nan)
        return np.array(c), np.array(pairs)
