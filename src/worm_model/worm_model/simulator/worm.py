"""A simulated worm that follows the chamber's wall with its head, and its film.

Kinematics, not mechanics: the head goes its way (`head_path`) and a chain of short links
follows it, of limited bending, kept off the wall and drawn inwards, so that the body trails
inside the chamber as in the paper's Fig. 1. It serves tests: the truth of every frame is exact.
"""

from cmath import exp, phase
from collections.abc import Iterator
from math import ceil, cos, pi, radians, sin

import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.film import FilmFrame, frame_stamp_ns
from worm_model.simulator.head_path import LEAN_RAD, HeadPath, Walker
from worm_model.simulator.rig import Body, Rig, draw, truth_of, worm_coverage
from worm_model.simulator.rig.body import HEAD_TAPER_WIDTHS, TAIL_TAPER_WIDTHS

__all__ = ["Walker", "midlines_mm", "rounded_body", "simulate_film"]

LINKS = 40
LARGEST_STEP_S = 0.02
SHARPEST_BEND_RAD = radians(20.0)
"""Between two links; with links of half a millimetre a bend's radius stays above 1.4 mm."""
CLEARANCE_MM = 0.02
LARGEST_PACE_MM_S = 12.0
INWARD_S = 3.0
"""Time in which the body drifts away from the wall."""
INNER_RADIUS = 0.55
"""Radius, in units of R, to which the body's rear drifts."""


def simulate_film(rig: Rig, walker: Walker, duration_s: float, fps: float) -> Iterator[FilmFrame]:
    """Film a simulated worm in chamber a.

    Parameters
    ----------
    rig : Rig
        The rig and its camera.
    walker : Walker
        The worm.
    duration_s, fps : float
        Length of the film and frames per second.

    Yields
    ------
    FilmFrame
        Stamp (from 0), picture and truth.
    """
    chamber = rig.chambers[0]
    for frame, midline_mm in enumerate(midlines_mm(walker, rig.radius_mm, duration_s, fps)):
        u, v = chamber.to_pixels(midline_mm[:, 0] * 1e-3, midline_mm[:, 1] * 1e-3)
        body = rounded_body(np.c_[u, v], walker.width_mm * rig.px_per_mm)
        stamp_ns = frame_stamp_ns(frame, fps)
        truth = truth_of(rig, body, frame, stamp_ns, worm_coverage(body))
        yield FilmFrame(stamp_ns, draw(rig, body, frame), truth)


def midlines_mm(
    walker: Walker, radius_mm: float, duration_s: float, fps: float
) -> Iterator[NDArray[np.float64]]:
    """Yield the worm's midline at each frame.

    Parameters
    ----------
    walker : Walker
        The worm; it must be shorter than twice the chamber's circumference.
    radius_mm : float
        R.
    duration_s, fps : float
        Length of the film and frames per second.

    Yields
    ------
    ndarray, shape (LINKS + 1, 2)
        x, y in the chamber's frame, mm, head tip first. The body, of the walker's width, lies
        inside the wall.
    """
    head = HeadPath(walker, radius_mm)
    chain = _Chain(walker, radius_mm, head)
    steps = ceil(1.0 / (fps * LARGEST_STEP_S))
    step_s = 1.0 / (fps * steps)
    for _ in range(round(8.0 / step_s)):  # until the body has found its shape
        head.advance(step_s)
        chain.follow(head, 0.0, step_s)
    for frame in range(round(duration_s * fps)):
        if frame > 0:
            for part in range(1, steps + 1):
                head.advance(step_s)
                chain.follow(head, (frame - 1) / fps + part * step_s, step_s)
        yield chain.midline_mm(frame / fps)


class _Chain:
    """The body: points as complex numbers in the chamber's frame, mm, head first."""

    def __init__(self, walker: Walker, radius_mm: float, head: HeadPath) -> None:
        self._walker = walker
        self._radius = radius_mm
        s = np.linspace(0.0, walker.length_mm, LINKS + 1)
        self._s = s
        taper = HEAD_TAPER_WIDTHS * walker.width_mm
        half = 0.5 * walker.width_mm * np.sqrt(1.0 - np.clip(1.0 - s / taper, 0.0, 1.0) ** 2)
        self._limit = (radius_mm - half - CLEARANCE_MM).tolist()
        rest = (1.0 - INNER_RADIUS) * radius_mm * (1.0 - np.exp(-s / 5.0))
        self._drift_to = np.array(self._limit) - rest
        tip = self._tip(head)
        back = -exp(1j * (head.theta_rad + head.lean_rad))
        # It starts coiled inwards, clear of the wall.
        turn = np.exp(-1j * np.sign(head.lean_rad) * s / (0.55 * radius_mm))
        self._z = tip + np.r_[0.0, np.cumsum(back * turn[1:] * np.diff(s))]

    def follow(self, head: HeadPath, time_s: float, step_s: float) -> None:
        """Let the body follow the head's new place."""
        walker = self._walker
        stretch = 1.0 + walker.peristalsis * sin(2.0 * pi * time_s / walker.peristalsis_s)
        link = walker.length_mm / LINKS * stretch
        radius = np.abs(self._z)
        beyond = np.maximum(radius - self._drift_to, 0.0) * (step_s / INWARD_S)
        beyond[:3] = 0.0
        z = (self._z * (1.0 - beyond / np.maximum(radius, 1e-9))).tolist()
        z[0] = self._tip(head)
        axis = -exp(1j * (head.theta_rad + head.lean_rad))
        z[1] = z[0] + link * axis
        for k in range(2, LINKS + 1):
            wanted = z[k] - z[k - 1]
            bend = phase(wanted / axis)
            axis *= exp(1j * max(-SHARPEST_BEND_RAD, min(SHARPEST_BEND_RAD, bend)))
            place = z[k - 1] + link * axis
            if abs(place) > self._limit[k]:
                place = self._on_the_wall(z[k - 1], link, axis, self._limit[k])
                axis = (place - z[k - 1]) / abs(place - z[k - 1])
            z[k] = place
        # A push from the head may flip a link over: the body gives way, but not in an instant.
        moved = np.array(z) - self._z
        pace = LARGEST_PACE_MM_S * step_s / np.maximum(np.abs(moved), 1e-12)
        pace[:2] = 1.0
        self._z = self._z + np.minimum(pace, 1.0) * moved

    def midline_mm(self, time_s: float) -> NDArray[np.float64]:
        """Return the midline with its transverse wave, inside the wall."""
        walker = self._walker
        tangent = np.gradient(self._z)
        normal = 1j * tangent / np.abs(tangent)
        s = self._s / walker.length_mm
        wave = np.sin(2.0 * pi * (time_s / walker.undulation_s - 2.0 * s))
        grown = np.clip((s - 0.1) / 0.3, 0.0, 1.0)
        z = self._z + walker.undulation_mm * grown * wave * normal
        # A spline between points and the rounded end may still reach farther than the points.
        body = rounded_body(np.c_[z.real, z.imag] * 100.0, walker.width_mm * 100.0)
        centres, disc = body.discs()
        distance = np.hypot(*centres.T)
        room = (100.0 * self._radius - 0.5 - disc) / np.maximum(distance, 1e-9)
        z = z * min(1.0, float(room[distance > 10.0].min()))
        return np.stack([z.real, z.imag], axis=1)

    def _tip(self, head: HeadPath) -> complex:
        """RelativeState the head tip: its rounded end, leaning, needs a small gap to the wall."""
        long, half = HEAD_TAPER_WIDTHS * self._walker.width_mm, 0.5 * self._walker.width_mm
        lean = min(abs(head.lean_rad), LEAN_RAD)
        reach = np.hypot(long * cos(lean), half * sin(lean)) - long * cos(lean)
        distance = self._radius - float(reach) - CLEARANCE_MM - head.off_wall_mm
        return distance * exp(1j * head.theta_rad)

    @staticmethod
    def _on_the_wall(start: complex, link: float, axis: complex, limit: float) -> complex:
        """Turn a link that would end beyond the limit until it ends on it."""
        d = abs(start)
        if d < 1e-9 or d + limit <= link:
            return start + link * axis
        # The angle at `start` between the outward direction and the link, by the law of cosines.
        cosine = (limit**2 - d**2 - link**2) / (2.0 * d * link)
        angle = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        outward = start / d
        side = 1.0 if phase(axis / outward) >= 0.0 else -1.0
        place = start + link * outward * exp(1j * side * angle)
        return place if abs(place) <= limit + 1e-9 else place * (limit / abs(place))


def rounded_body(points_px: NDArray[np.float64], width_px: float) -> Body:
    """Return the body on a midline (u, v), head first, with the ends that the worms here have."""
    return Body.along(
        points_px, width_px, HEAD_TAPER_WIDTHS * width_px, TAIL_TAPER_WIDTHS * width_px
    )
