"""The way of the head of a worm that steers by a programme: along the wall, back, across, round.

Nothing of it comes from the worms that the tracker was tuned on, nor from the simulator: walks
along the wall, U-turns of half a width to a width in radius, ways back beside the own body, ways
across the chamber and loops follow each other at random.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
RADIUS_MM = 10.0
STEP_MM = 0.02
_BEGUN_BY_WAY = ("wall", "beside", "cross")


@dataclass(slots=True)
class _Steering:
    """What the head does now, and for how long.

    Attributes
    ----------
    rng : Generator
    width_mm : float
    mode : str
        `wall`, `beside`, `cross`, `uturn` or `loop`.
    left : float
        Way that is left, mm; of a turn its whole angle, radians.
    target : float
        Distance from the centre that is kept, mm; of a turn its curvature, per mm.
    side : int
        Which way round the chamber, or to which side it turns: 1 or -1.
    """

    rng: np.random.Generator
    width_mm: float
    mode: str
    left: float
    target: float
    side: int
    turned: float = field(default=0.0)
    wander: float = field(default=0.0)

    @property
    def most_curvature(self) -> float:
        """Sharpest bend, per mm: no body bends within less than 0.42 widths."""
        return 1 / (0.42 * self.width_mm)

    def curvature(self, at: complex, heading: float, now: float) -> float:
        """Return the curvature that is steered for, per mm, in one place (mm)."""
        r, angle = abs(at), float(np.angle(at))
        if self.mode in ("wall", "beside"):
            towards = -self.side * np.clip((self.target - r) * 1.5, -1.2, 1.2)
            goal = angle + self.side * (np.pi / 2) + towards
            off = (goal - heading + np.pi) % (2 * np.pi) - np.pi
            return float(np.clip(off * 3, -self.most_curvature * 0.6, self.most_curvature * 0.6))
        if self.mode in ("uturn", "loop"):
            self.turned += abs(now) * STEP_MM
            return self.side * self.target
        noise = self.rng.normal(0, 0.9) * np.sqrt(STEP_MM)
        self.wander += -self.wander * STEP_MM / 1.5 + noise
        if r > RADIUS_MM - 2.2 and np.cos(heading - angle) > -0.1:  # turn along the wall
            return 1.1 if np.sin(heading - angle) > 0 else -1.1
        return float(np.clip(self.wander, -1.2, 1.2))

    def go_on(self, before: complex, at: complex, heading: float) -> None:
        """Go on by one step, and choose what comes next where this is done."""
        self.left -= STEP_MM
        by_way = self.mode in _BEGUN_BY_WAY
        if self.left > 0 if by_way else self.turned < self.left:
            return
        if self.mode == "uturn":
            self._after_turn(at, heading)
        else:
            self._choose(float(np.angle(before)), heading)

    def _choose(self, angle: float, heading: float) -> None:
        """Choose what comes next, in a place at this angle (radians) about the centre."""
        rng, chance = self.rng, self.rng.random()
        inwards = int(np.sign(np.sin((angle + np.pi) - heading))) or 1
        turns_back = {"wall": 0.6, "beside": 0.25, "cross": 0.3}.get(self.mode, 0.0)
        if chance < turns_back:
            radius = self.width_mm * rng.uniform(0.45, 0.9)
            self.mode, self.left = "uturn", np.pi * rng.uniform(0.9, 1.0)
            self.target, self.turned, self.side = 1 / radius, 0.0, inwards
        elif chance < 0.8 and self.mode != "cross":
            self.mode, self.left, self.wander = "cross", rng.uniform(6, 14), 0.0
        elif chance < 0.9:
            radius = rng.uniform(0.9, 2.0)
            self.mode, self.left = "loop", 2 * np.pi * rng.uniform(0.8, 1.1)
            self.target, self.turned, self.side = 1 / radius, 0.0, inwards
        else:
            self.mode, self.left = "wall", rng.uniform(6, 20)
            self.target = RADIUS_MM - self.width_mm * 0.55 - rng.uniform(0.05, 0.5)
            self.side = 1 if np.sin(heading - angle) > 0 else -1

    def _after_turn(self, at: complex, heading: float) -> None:
        """Go back beside the own body near the wall, else across."""
        r, angle = abs(at), float(np.angle(at))
        self.side = 1 if np.sin(heading - angle) > 0 else -1
        if r > RADIUS_MM - 4:
            self.mode, self.left, self.target = "beside", self.rng.uniform(8, 20), r
        else:
            self.mode, self.left, self.wander = "cross", self.rng.uniform(5, 10), 0.0


def steered_path(rng: np.random.Generator, length_mm: float, width_mm: float) -> Floats:
    """Return the head's way, shape (n, 2), mm, y up, a point every STEP_MM.

    Parameters
    ----------
    rng : Generator
    length_mm : float
    width_mm : float
        The worm's: it keeps half of it from the wall.
    """
    r0 = RADIUS_MM - width_mm * 0.55 - rng.uniform(0.05, 0.4)
    angle, side = rng.uniform(0, 2 * np.pi), int(rng.choice([-1, 1]))
    heading, curvature = angle + side * np.pi / 2, 0.0
    steering = _Steering(rng, width_mm, "wall", rng.uniform(21, 28), r0, side)
    at = r0 * np.exp(1j * angle)
    way = [at]
    most_r, most = RADIUS_MM - 0.52 * width_mm, steering.most_curvature
    for _ in range(1, int(length_mm / STEP_MM)):
        wanted = steering.curvature(at, heading, curvature)
        curvature += float(np.clip(wanted - curvature, -STEP_MM * 12, STEP_MM * 12))
        curvature = float(np.clip(curvature, -most, most))
        heading += curvature * STEP_MM
        before, at = at, at + STEP_MM * np.exp(1j * heading)
        at *= min(1.0, most_r / abs(at))
        way.append(at)
        steering.go_on(before, at, heading)
    line = np.array(way)
    return np.stack([line.real, line.imag], axis=1)
