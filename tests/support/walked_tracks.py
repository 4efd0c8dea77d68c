"""Tracks of a worm in the rig with known parameters, as the states that a tracker would give."""

from dataclasses import dataclass, replace

import numpy as np

from worm_msgs_py import BodyState, Chamber, Geometry, Keypoint, Status, Where

R = 0.01
START_NS = 1_700_000_000_000_000_000
BODY_WIDTH = 4e-4
THRESHOLD = 0.3 * BODY_WIDTH
CHAMBERS = {
    "chamber_a": Chamber("chamber_a", 300.0, 500.0, 200.0, 0.2, R, exit_width_m=1e-3),
    "chamber_b": Chamber("chamber_b", 1390.0, 280.0, 200.0, 0.2 + np.pi, R, exit_width_m=1e-3),
}
GEOMETRY = Geometry(1, START_NS, 1700, 800, tuple(CHAMBERS.values()))
WHERE = {"chamber_a": Where.CHAMBER_A, "chamber_b": Where.CHAMBER_B}


@dataclass
class Track:
    """One row a frame; metres in the frame of `chamber`."""

    stamp_ns: np.ndarray
    head: np.ndarray
    centroid: np.ndarray
    tail: np.ndarray
    yaw: np.ndarray
    width: np.ndarray
    length: np.ndarray
    chamber: np.ndarray
    where: np.ndarray
    certainty: np.ndarray | None = None

    def __post_init__(self):
        if self.certainty is None:
            self.certainty = np.full(len(self.stamp_ns), 0.99)

    def states(self):
        """Return the states, with pixel coordinates that agree with the metric ones."""
        return list(self.each_state())

    def each_state(self):
        """Yield the states one by one, for tracks of which not all states fit into memory."""
        return map(self._state, range(len(self.stamp_ns)))

    def _state(self, frame):
        chamber = CHAMBERS[self.chamber[frame]]

        def point(xy, yaw=np.nan):
            x, y = (float(value) for value in xy[frame])
            return Keypoint(*chamber.to_pixels(x, y), x, y, float(yaw))

        tracked = np.isfinite(self.head[frame, 0])
        return BodyState(
            frame=frame,
            stamp_ns=int(self.stamp_ns[frame]),
            frame_id=chamber.name,
            where=Where(int(self.where[frame])) if tracked else Where.UNKNOWN,
            status=Status.TRACKED if tracked else Status.NO_WORM,
            geometry=1,
            confidence=0.95,
            head_certainty=float(self.certainty[frame]) if tracked else 0.5,
            head=point(self.head, self.yaw[frame]),
            centroid=point(self.centroid),
            tail=point(self.tail),
            length_m=float(self.length[frame]),
            width_m=float(self.width[frame]),
        )


def mirrored(state):
    """Return the state of the picture that is flipped about the line from exit to exit."""

    def flip(point):
        return replace(point, y_m=-point.y_m, yaw_rad=-point.yaw_rad)

    return replace(
        state, head=flip(state.head), centroid=flip(state.centroid), tail=flip(state.tail)
    )


def polar(r, theta):
    return np.stack([r * np.cos(theta), r * np.sin(theta)], axis=1)


def track_from_polar(t_s, r_h, theta_h, psi_b, chamber="chamber_a", body=5e-3):
    """A body that points by ψ_b from the wall's normal; the head's own direction is the same."""
    n = len(t_s)
    head = polar(r_h, theta_h)
    direction = polar(np.ones(n), theta_h + psi_b)
    return Track(
        stamp_ns=START_NS + np.round(np.asarray(t_s) * 1e9).astype(np.int64),
        head=head,
        centroid=head - body * direction,
        tail=head - 2 * body * direction,
        yaw=theta_h + psi_b,
        width=np.full(n, BODY_WIDTH),
        length=np.full(n, 0.02),
        chamber=np.full(n, chamber),
        where=np.full(n, WHERE[chamber]),
    )


def walk(seed, duration_s, speed=2e-3, d_c=1.95e-3, d_nc=1.46e-3, delta_r=1.14e-3, reversal=0.05):
    """A head that slides and hops along the wall by exponential distances at constant speed.

    Each excursion goes from the threshold of contact inwards by an exponential depth. After an
    excursion the direction is reversed with a fixed probability. Returns the times and angles at
    which episodes meet (one more than episodes), and the depth of each episode.
    """
    rng = np.random.default_rng(seed)
    times, angles, depths = [0.0], [0.3], []
    direction, sliding = 1, True
    while times[-1] < duration_s:
        distance = rng.exponential(d_c if sliding else d_nc)
        times.append(times[-1] + distance / speed)
        angles.append(angles[-1] + direction * distance / R)
        depths.append(0.1 * BODY_WIDTH if sliding else THRESHOLD + rng.exponential(delta_r))
        if not sliding and rng.random() < reversal:
            direction = -direction
        sliding = not sliding
    return np.array(times), np.array(angles), np.array(depths)


def slides_and_hops(seed, duration_s, rate_hz):
    """The track of `walk`, filmed; the body leans into the direction of motion by 32°."""
    times, angles, depths = walk(seed, duration_s)
    t = np.arange(0, duration_s, 1 / rate_hz)
    episode = np.searchsorted(times, t, side="right") - 1
    heading = np.sign(np.diff(angles))[episode]
    r = R - np.minimum(depths[episode], 0.9 * R)
    psi_b = heading * np.radians(32) + np.random.default_rng([seed, 1]).normal(0, 0.1, len(t))
    return track_from_polar(t, r, np.interp(t, times, angles), psi_b)


def rough_track(seed, n=500, hops=False):
    """Anything that can happen: uneven times, frames without a head, gaps, changes of chamber.

    With hops the head goes round and round, and leaves the wall for a few frames again and again.
    """
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.01, 0.08, n) + rng.choice([0, 0.3, 2.0], n, p=[0.97, 0.02, 0.01]))
    chance = rng.choice([0.0, 0.0, 0.02, 0.1])
    theta = np.cumsum(rng.normal(0.01, 0.05, n)) + rng.uniform(-3, 3)
    depth = np.abs(np.cumsum(rng.normal(0, 8e-5, n)))
    if hops:
        theta = np.cumsum(rng.normal(0.04, 0.03, n))
        touching = np.repeat(np.arange(n) % 2 == 0, rng.integers(1, 7, n))[:n]
        depth = np.where(touching, 0.3 * THRESHOLD, rng.uniform(1.5, 60, n) * THRESHOLD)
    r = np.clip(R - depth, 1e-3, R * (1 - 1e-6))
    track = track_from_polar(t, r, theta, rng.normal(0, 0.8, n), body=2e-3)
    track.width[:] = BODY_WIDTH * rng.uniform(0.8, 1.2, n)
    track.width[rng.random(n) < 0.1] = np.nan
    track.yaw += rng.normal(0, 1, n)
    if rng.random() < 0.7:
        _pass_over(track, rng, n)
    lost = rng.random(n) < chance
    for start in rng.integers(0, n, 2):
        lost[start : start + rng.integers(0, 40)] = True
    for points in (track.head, track.centroid, track.tail):
        points[lost] = np.nan
    track.yaw[lost] = np.nan
    doubted = np.zeros(n, dtype=bool)
    for start in rng.integers(0, n, rng.integers(0, 3)):
        doubted[start : start + rng.integers(0, 40)] = True
    track.certainty[doubted] = rng.uniform(0.5, 0.89, doubted.sum())
    return track


def _pass_over(track, rng, n):
    """Send head and body through the passage in some frames; they come out on either side."""
    chamber = "chamber_a"
    for start in n // 4 * np.arange(1, 4) - rng.integers(0, n // 8, 3):
        passage = slice(start, start + int(rng.integers(1, 25)))
        track.where[passage] = Where.PASSAGE
        track.head[passage] = (R + 3e-3, 0.0)
        track.centroid[passage] = (R + 2e-3, 0.0)
        chamber = str(rng.choice(list(CHAMBERS)))
        after = slice(passage.stop, n)
        track.where[after], track.chamber[after] = WHERE[chamber], chamber
