"""A worm whose laws are known: what it does, event by event, and the states that a film would give.

Slides, hops and reversals are those of the boundary walk, drawn one by one; every slide that meets
the exit and every hop that lands in it is an attempt, which succeeds with a fixed chance and
otherwise turns back at a depth of known law. Hops are steps of depth or half sines; a visit begins
at the wall, or in the mouth of the exit, out of which the head comes. `Camera` is what a film adds:
jitter of the radius, a wall that is not where it is thought to be, lost frames. `paper_rule` counts
episodes by the threshold on the radius without any of that: it is the truth that d_c, d_nc, Δr_h
and the reversals are held to. Nothing here is shared with `worm_analysis`.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from worm_msgs_py import BodyState, Chamber, Geometry, Keypoint, Status, Where

Floats = NDArray[np.float64]

R = 0.01
WIDTH = 4e-4
THRESHOLD = 0.3 * WIDTH
NAMES = ("chamber_a", "chamber_b")
IN_CHAMBER = (Where.CHAMBER_A, Where.CHAMBER_B)
BODY_M, PAUSE_S, PASSING_S = 5e-3, 0.7, 2.5
STROKE_S, STRETCHING_M_S = 0.4, 3e-3
ASIDE_S = 0.2
"""Time for which a head that touches nothing goes straight to the exit, and back from it."""
TOUCH_M = 0.1 * WIDTH
"""R − r_h of a head at the wall."""


@dataclass(frozen=True)
class KnownWorm:
    """Its parameters, SI units."""

    speed: float = 2.02e-3
    d_c: float = 1.95e-3
    d_nc: float = 1.46e-3
    delta_r_h: float = 1.14e-3
    reversal: float = 0.0313
    """Chance of turning round after a hop."""
    exit_width: float = 1e-3
    success: float = 0.6
    beta: float = 500.0
    even: float = 0.15
    """Share of the failures that turn back anywhere up to `deepest`."""
    deepest: float = 8e-3
    touching: float = 0.9
    elongating: float = 0.87
    lean: float = float(np.radians(32))
    sway: float = 0.1
    """Of the body, rad: once in 12 s, and as much noise; the speed does not follow it."""
    half_sine: bool = False
    """Whether the depth of a hop is half a sine, from the wall on, rather than one step."""
    emerges: bool = False
    """Whether a visit begins in the mouth of the exit, rather than at the wall."""

    @property
    def half_arc(self) -> float:
        """Half of the exit's arc, rad."""
        return float(np.arcsin(self.exit_width / 2 / R))

    @property
    def geometry(self) -> Geometry:
        """Its rig."""
        chambers = tuple(
            Chamber(name, 300.0, 500.0, 200.0, 0.2, R, exit_width_m=self.exit_width)
            for name in NAMES
        )
        return Geometry(1, 0, 1700, 800, chambers)


@dataclass(frozen=True)
class Camera:
    """What a film adds to the truth, SI units."""

    jitter: float = 0.0
    """Of the head's radius, anew in each frame (standard deviation)."""
    slow_jitter: float = 0.0
    """The same, correlated over `slow_s`."""
    slow_s: float = 0.1
    wall_offset: float = 0.0
    """By how much the wall is thought to be too far outside."""
    gaps_per_s: float = 0.0
    """Of lost frames, each `gap_s` long on average."""
    gap_s: float = 1.0


@dataclass
class Emergence:
    """A head that comes out of the exit and crosses the chamber to the wall at `theta`."""

    chamber: int
    start: float
    theta: float

    def duration(self, speed: float) -> float:
        """Return how long it takes, s."""
        return abs(self.path()[1] - self.path()[0]) / speed

    def touch(self, speed: float) -> tuple[float, float]:
        """Return when and at which θ its head comes within the distance that counts as contact."""
        begin, end = self.path()
        way = end - begin
        along = (way * begin.conjugate()).real / abs(way) ** 2
        beyond = (abs(begin) ** 2 - (R - THRESHOLD) ** 2) / abs(way) ** 2
        part = -along + float(np.sqrt(along**2 - beyond))
        return self.start + part * self.duration(speed), float(np.angle(begin + part * way))

    def path(self) -> tuple[complex, complex]:
        """Return where it begins and ends, m."""
        return complex(R + 1e-6), complex((R - TOUCH_M) * np.exp(1j * self.theta))


@dataclass
class Search:
    """A way along the wall: knots (one more than phases) of time and θ, and each phase's depth."""

    chamber: int
    first: bool
    """Whether it begins a visit."""
    t: Floats
    theta: Floats
    depth: Floats
    skips: int


@dataclass
class Try:
    """An attempt at the exit; `x_p` counts from where the circle bulges over the mouth."""

    chamber: int
    start: float
    success: bool
    x_p: float = 0.0
    touching: bool = False
    elongating: bool = False

    @property
    def aside_s(self) -> float:
        """Time before it in which the head leaves the wall, and after it."""
        return 0.0 if self.success or self.touching else ASIDE_S

    def duration(self, speed: float) -> float:
        """Return how long it takes until the search goes on, s."""
        return PASSING_S if self.success else 2 * self.x_p / speed + PAUSE_S + self.aside_s


def life(
    worm: KnownWorm, seed: int | tuple[int, ...], until_s: float
) -> Iterator[Search | Try | Emergence]:
    """Yield searches and attempts in turn, until a search ends after `until_s`."""
    rng = np.random.default_rng(seed)
    chamber, time, first = 0, 0.0, True
    theta, direction = rng.uniform(worm.half_arc, 2 * np.pi - worm.half_arc), 1
    direction = int(rng.choice([-1, 1]))
    while True:
        if first and worm.emerges:
            theta = direction * rng.uniform(np.pi / 3, 5 * np.pi / 6)
            emergence = Emergence(chamber, time, float(theta))
            yield emergence
            time += emergence.duration(worm.speed)
        search = _search(worm, rng, chamber, time, theta, direction, until_s)
        search.first = first
        yield search
        time = float(search.t[-1])
        if time >= until_s:
            return
        attempt = _attempt(worm, rng, chamber, time)
        yield attempt
        time = attempt.start + attempt.duration(worm.speed)
        first = attempt.success
        direction = int(rng.choice([-1, 1]))
        theta = direction * worm.half_arc * (1 + 1e-9)
        if attempt.success:
            chamber = 1 - chamber
            theta = rng.uniform(worm.half_arc, 2 * np.pi - worm.half_arc)


def _search(worm, rng, chamber, time, theta, direction, until_s):
    t, angles, depth = [time], [theta], []
    sliding, found, skips, turn = True, False, 0, 2 * np.pi
    while not found and time < until_s:
        angle = rng.exponential(worm.d_c if sliding else worm.d_nc) / R
        end = theta + direction * angle
        if sliding:
            nearest = turn * (np.floor(theta / turn) + (direction > 0)) - direction * worm.half_arc
            found = direction * (end - nearest) >= 0
            end = nearest if found else end
        else:
            found = abs(np.angle(np.exp(1j * end))) <= worm.half_arc
            if not found:
                skips += int(abs(np.floor(end / turn) - np.floor(theta / turn)))
        time += abs(end - theta) * R / worm.speed
        theta = end
        t.append(time)
        angles.append(theta)
        above = TOUCH_M if worm.half_sine else THRESHOLD
        depth.append(TOUCH_M if sliding else above + rng.exponential(worm.delta_r_h))
        if not sliding and rng.random() < worm.reversal:
            direction = -direction
        sliding = not sliding
    return Search(chamber, False, np.array(t), np.array(angles), np.array(depth), skips)


def _attempt(worm, rng, chamber, time):
    success = rng.random() < worm.success
    if rng.random() < worm.even:
        x_p = rng.uniform(0, worm.deepest)
    else:
        reach = -np.expm1(-worm.beta * worm.deepest)
        x_p = -np.log1p(-rng.random() * reach) / worm.beta
    touching, elongating = rng.random() < worm.touching, rng.random() < worm.elongating
    attempt = Try(chamber, time, success, float(x_p), touching, elongating)
    attempt.start += attempt.aside_s
    return attempt


def film(
    worm: KnownWorm, seed: int, duration_s: float, rate_hz: float, camera: Camera | None = None
) -> Iterator[BodyState]:
    """Yield the states that a tracker gives of it; without a camera, one without error."""
    rng = np.random.default_rng((seed, 1))
    view = _View(camera or Camera(), seed, rate_hz)
    frame = 0
    length_noise = 5e-5
    for event in life(worm, seed, duration_s):
        end = event.t[-1] if isinstance(event, Search) else event.start + event.duration(worm.speed)
        last = int(np.ceil(end * rate_hz))
        t = np.arange(frame, last) / rate_hz
        if not len(t):
            continue
        length = 0.02 + rng.normal(0, length_noise, len(t))
        if isinstance(event, Search):
            columns = _along_wall(worm, event, t, rng)
        elif isinstance(event, Emergence):
            columns = _out_of_mouth(event, t, end)
        elif event.success:
            columns = _through(event, t)
        else:
            columns = _in_and_out(worm, event, t, length)
        chamber, passing, head, *rest = columns
        head, lost = view.of(t, head)
        rows = (column.tolist() for column in (t, length, chamber, passing, head, *rest, lost))
        for row in zip(*rows, strict=True):
            yield _state(frame, *row)
            frame += 1


class _View:
    """What a camera makes of the head's way, event by event."""

    def __init__(self, camera: Camera, seed: int, rate_hz: float):
        self._camera, self._rate_hz = camera, rate_hz
        self._rng = np.random.default_rng((seed, 2))
        self._slow, self._lost_until = float(self._rng.normal()), -1.0

    def of(self, t: Floats, head: NDArray[np.complex128]) -> tuple[NDArray[np.complex128], Floats]:
        """Return where the head is seen, and the frames that are lost."""
        camera, rng, n = self._camera, self._rng, len(t)
        kept = float(np.exp(-1 / self._rate_hz / camera.slow_s))
        drive = np.sqrt(1 - kept**2) * rng.normal(size=n)
        slow, _ = lfilter([1.0], [1.0, -kept], drive, zi=[kept * self._slow])
        self._slow = float(slow[-1])
        noise = camera.wall_offset - camera.jitter * rng.normal(size=n) - camera.slow_jitter * slow
        lost = t <= self._lost_until
        for k in np.flatnonzero(rng.random(n) < camera.gaps_per_s / self._rate_hz):
            if t[k] > self._lost_until:
                self._lost_until = float(t[k] + camera.gap_s * rng.exponential())
                lost |= (t >= t[k]) & (t <= self._lost_until)
        return head * (1 - noise / np.abs(head)), lost


def depth_at(worm: KnownWorm, search: Search, t: Floats) -> Floats:
    """Return R − r_h at times of a search."""
    phase = np.clip(np.searchsorted(search.t, t, side="right") - 1, 0, len(search.depth) - 1)
    depth = np.minimum(search.depth[phase], 0.9 * R)
    if worm.half_sine:
        part = (t - search.t[phase]) / np.diff(search.t)[phase]
        depth = TOUCH_M + (depth - TOUCH_M) * np.sin(np.pi * np.clip(part, 0, 1))
    return depth


@dataclass
class Counted:
    """What the paper's rule counts of a life, in m: a length in all over the number of ends."""

    d_c: float
    d_nc: float
    delta_r_h: float
    """Of what is deeper than the threshold."""
    reversal: float
    """Part of the cycles that go the other way than the one before."""


def paper_rule(worm: KnownWorm, seed: int | tuple[int, ...], until_s: float) -> Counted:
    """Count contacts and excursions by the paper's threshold, on the radius without noise."""
    slides, hops, depths, turned = [], [], [], []
    for search in life(worm, seed, until_s):
        if not isinstance(search, Search):
            continue
        t, free, deepest = _crossings(worm, search)
        length = R * np.diff(np.interp(t, search.t, search.theta))
        slides.append(np.abs(length[~free]))
        hops.append(np.abs(length[free]))
        depths.append(deepest[free] - THRESHOLD)
        n = 2 * int(free.sum())
        turned.append(np.diff(np.sign(length[0:n:2] + length[1:n:2])) != 0)
    n = sum(map(len, hops))
    lengths = (float(np.concatenate(part).sum()) / n for part in (slides, hops, depths))
    return Counted(*lengths, float(np.concatenate(turned).mean()))


def _crossings(worm: KnownWorm, search: Search) -> tuple[Floats, NDArray[np.bool_], Floats]:
    """Return the times at which episodes meet, which of them are free, and how deep each goes."""
    t, free, deepest = [float(search.t[0])], [False], [0.0]
    for k, depth in enumerate(search.depth):
        if depth <= THRESHOLD:
            continue
        begin, end = float(search.t[k]), float(search.t[k + 1])
        if worm.half_sine:
            edge = np.arcsin((THRESHOLD - TOUCH_M) / (depth - TOUCH_M)) / np.pi * (end - begin)
            begin, end = begin + edge, end - edge
        t += [begin, end]
        free += [True, False]
        deepest += [min(float(depth), 0.9 * R), 0.0]
    return np.array([*t, float(search.t[-1])]), np.array(free), np.array(deepest)


def _along_wall(worm, search, t, rng):
    phase = np.clip(np.searchsorted(search.t, t, side="right") - 1, 0, len(search.depth) - 1)
    heading = np.sign(np.diff(search.theta))[phase]
    theta = np.interp(t, search.t, search.theta)
    r = R - depth_at(worm, search, t)
    if search.first and not worm.emerges:
        r[0] = R - 3e-3  # it comes from the passage to the wall
    sway = worm.sway * (np.sin(2 * np.pi * t / 12) + rng.normal(0, 1, len(t)))
    direction = theta + heading * worm.lean + sway
    head = r * np.exp(1j * theta)
    centroid = head - BODY_M * np.exp(1j * direction)
    chamber = np.full(len(t), search.chamber)
    return chamber, np.zeros(len(t), bool), head, centroid, direction


def _out_of_mouth(emergence, t, end):
    start, stop = emergence.path()
    part = (t - emergence.start) / (end - emergence.start)
    head = start + (stop - start) * part
    direction = np.full(len(t), np.angle(stop - start))
    centroid = head - BODY_M * np.exp(1j * direction)
    chamber = np.full(len(t), emergence.chamber)
    return chamber, np.zeros(len(t), bool), head, centroid, direction


def _in_and_out(worm, attempt, t, length):
    since, way = t - attempt.start, attempt.x_p / worm.speed
    depth = worm.speed * np.minimum(np.minimum(since, 2 * way + PAUSE_S - since), way)
    turn = attempt.start + way
    sign = 1 if attempt.elongating else -1
    stretching = (t > turn - STROKE_S) & (t < turn + 0.05)
    length[stretching] += sign * STRETCHING_M_S * (t - turn)[stretching]
    y = worm.exit_width / 2 - 0.4 * THRESHOLD if attempt.touching else 0.0
    mouth = R * np.cos(worm.half_arc)
    x = mouth + (R - mouth) + 1e-9 + depth
    head = x + 1j * y
    centroid = np.full(len(t), R - BODY_M, dtype=complex)
    chamber = np.full(len(t), attempt.chamber)
    return chamber, depth >= 0, head, centroid, np.zeros(len(t))


def _through(attempt, t):
    part = (t - attempt.start) / PASSING_S
    there = part > 0.7
    x = R + 1e-9 + np.where(there, 8e-3, 14e-3 * part / 0.7)
    head = x + 0j
    centroid = head - np.where(there, 2e-3, BODY_M)
    chamber = np.where(there, 1 - attempt.chamber, attempt.chamber)
    return chamber, np.ones(len(t), bool), head, centroid, np.zeros(len(t))


def _state(frame, t, length, chamber, passing, head, centroid, yaw, lost):
    return BodyState(
        frame=frame,
        stamp_ns=round(t * 1e9),
        frame_id=NAMES[chamber],
        where=Where.PASSAGE if passing else IN_CHAMBER[chamber],
        status=Status.NO_WORM if lost else Status.TRACKED,
        geometry=1,
        confidence=1.0,
        head_certainty=0.0 if lost else 1.0,
        head=Keypoint() if lost else Keypoint(0.0, 0.0, head.real, head.imag, yaw),
        centroid=Keypoint(0.0, 0.0, centroid.real, centroid.imag),
        tail=Keypoint(0.0, 0.0, 0.0, 0.0),
        length_m=length,
        width_m=WIDTH,
    )
