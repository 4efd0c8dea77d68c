"""A simulated worm that follows the chamber's wall with its head, and its film.

Kinematics, not mechanics: the head goes its way (`head_path`) and a chain of short links
follows it, of limited bending, kept off the wall and drawn inwards, so that the body trails
inside the chamber as in the paper's Fig. 1. It serves tests: the truth of every frame is exact.
"""

from cmath import exp, phase
from collections.abc import Iterator
from math import asin, ceil, cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from worm_model.simulator import crawling
from worm_model.simulator.body_width import tapered
from worm_model.simulator.film import FilmFrame, frame_stamp_ns
from worm_model.simulator.gait import GAIT, GaitSettings
from worm_model.simulator.head_path import HeadPath, Walker
from worm_model.simulator.rig import Body, Rig, draw, truth_of, worm_coverage
from worm_model.simulator.rig.body import FINE_PX, HEAD_TAPER_WIDTHS, TAIL_TAPER_WIDTHS
from worm_msgs_py import paper

__all__ = ["Walker", "midlines_mm", "rounded_body", "simulate_film"]

FINE_MM = 0.02
"""Steps along the body at which it is held against the wall."""


def simulate_film(
    rig: Rig, walker: Walker, duration_s: float, fps: float, gait: GaitSettings = GAIT
) -> Iterator[FilmFrame]:
    """Film a simulated worm in chamber a.

    Parameters
    ----------
    rig : Rig
        The rig and its camera.
    walker : Walker
        The worm.
    duration_s, fps : float
        Length of the film and frames per second.
    gait : GaitSettings

    Yields
    ------
    FilmFrame
        Stamp (from 0), picture and truth.
    """
    chamber = rig.chambers[0]
    lines = midlines_mm(walker, rig.radius_mm, duration_s, fps, rig.exit_width_mm, gait)
    for frame, midline_mm in enumerate(lines):
        u, v = chamber.to_pixels(midline_mm[:, 0] * 1e-3, midline_mm[:, 1] * 1e-3)
        body = rounded_body(np.c_[u, v], walker.width_mm * rig.px_per_mm)
        stamp_ns = frame_stamp_ns(frame, fps)
        truth = truth_of(rig, body, frame, stamp_ns, worm_coverage(body))
        yield FilmFrame(stamp_ns, draw(rig, body, frame), truth)


def midlines_mm(
    walker: Walker,
    radius_mm: float,
    duration_s: float,
    fps: float,
    exit_width_mm: float = 0.0,
    gait: GaitSettings = GAIT,
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
    exit_width_mm : float
        W. Where it leaves no room for the body, or is 0, the head goes over the exit.
    gait : GaitSettings

    Yields
    ------
    ndarray, shape (n, 2)
        x, y in the chamber's frame, mm, head tip first. The body, of the walker's width, lies
        inside the wall, or in the passage. There are fewer frames where it gets out: the last one
        is that in which all of the worm is in the passage, as a trial ends with the escape.
    """
    head = HeadPath(walker, radius_mm, gait)
    chain = _Chain(walker, radius_mm, head, gait)
    steps = ceil(1.0 / (fps * gait.largest_step_s))
    step_s = 1.0 / (fps * steps)
    for _ in range(round(gait.settles_s / step_s)):
        head.advance(step_s, chain.psi_b_rad)
        chain.follow(head, 0.0, step_s)
    free_mm = 0.5 * (exit_width_mm - walker.width_mm) - gait.clearance_mm
    head.exit_half_rad = asin(max(free_mm, 0.0) / radius_mm)
    frames = round(duration_s * fps)
    for step in range(steps * (frames - 1) + 1):
        time_s = step * step_s
        if step > 0:
            head.advance(step_s, chain.psi_b_rad)
            chain.follow(head, time_s, step_s)
        if head.in_exit:
            left_s = np.arange(ceil(step / steps), frames) / fps - time_s
            yield from _way_out(walker, radius_mm, chain.midline_mm(time_s), left_s)
            return
        if step % steps == 0:
            yield chain.midline_mm(time_s)


def _way_out(
    walker: Walker, radius_mm: float, midline_mm: NDArray[np.float64], times_s: NDArray[np.float64]
) -> Iterator[NDArray[np.float64]]:
    """Yield the worm that follows its head at v_w, down the passage, until its tail is there."""
    x, y = midline_mm[0]
    bend_mm = max(4.0 * abs(y), 1.0)
    end_mm = radius_mm + paper.PASSAGE_LENGTH_MM
    ahead = np.arange(x + 0.05, max(end_mm, x + bend_mm), 0.05)
    across = 0.5 * y * (1.0 + np.cos(pi * np.minimum((ahead - x) / bend_mm, 1.0)))
    path = np.concatenate([midline_mm[::-1], np.stack([ahead, across], axis=1)])
    length = float(np.hypot(*np.diff(midline_mm, axis=0).T).sum())
    long = float(np.hypot(*np.diff(path, axis=0).T).sum())
    heads = length + walker.speed_mm_s * times_s
    yield from crawling.crawl(path, length, heads[heads <= min(2.0 * length + 1.0, long)])


class _Chain:
    """The body: points as complex numbers in the chamber's frame, mm, head first."""

    def __init__(
        self, walker: Walker, radius_mm: float, head: HeadPath, gait: GaitSettings
    ) -> None:
        self._walker = walker
        self._gait = gait
        self._radius = radius_mm
        s = np.linspace(0.0, walker.length_mm, gait.links + 1)
        self._s = s
        area = tapered(s / walker.width_mm) * np.r_[0.5, np.ones(gait.links - 1), 0.5]
        self._share = area / area.sum()
        taper = HEAD_TAPER_WIDTHS * walker.width_mm
        half = 0.5 * walker.width_mm * np.sqrt(1.0 - np.clip(1.0 - s / taper, 0.0, 1.0) ** 2)
        self._limit = (radius_mm - half - gait.clearance_mm).tolist()
        rest = (1.0 - gait.inner_radius_radii) * radius_mm * (1.0 - np.exp(-s / gait.rear_mm))
        self._drift_to = np.array(self._limit) - rest
        tip = self._tip(head)
        back = -exp(1j * (head.theta_rad + head.lean_rad))
        # It starts coiled inwards, clear of the wall.
        turn = np.exp(-1j * np.sign(head.lean_rad) * s / (gait.inner_radius_radii * radius_mm))
        self._z = tip + np.r_[0.0, np.cumsum(back * turn[1:] * np.diff(s))]

    @property
    def psi_b_rad(self) -> float:
        """ψ_b, without the transverse wave's sway."""
        return phase((self._z[0] - self._share @ self._z) / self._z[0])

    def follow(self, head: HeadPath, time_s: float, step_s: float) -> None:
        """Let the body follow the head's new place."""
        walker, gait = self._walker, self._gait
        stretch = 1.0 + walker.peristalsis * sin(2.0 * pi * time_s / walker.peristalsis_s)
        link = walker.length_mm / gait.links * stretch
        radius = np.abs(self._z)
        beyond = np.maximum(radius - self._drift_to, 0.0) * (step_s / gait.inward_s)
        beyond[:3] = 0.0
        z = self._z * (1.0 - beyond / np.maximum(radius, 1e-9))
        z = (z[0] + (z - z[0]) * exp(1j * head.turning * gait.swing_rad_s * step_s)).tolist()
        z[0] = self._tip(head)
        axis = -exp(1j * (head.theta_rad + head.lean_rad))
        z[1] = z[0] + link * axis
        for k in range(2, gait.links + 1):
            wanted = z[k] - z[k - 1]
            bend = phase(wanted / axis)
            axis *= exp(1j * max(-gait.sharpest_bend_rad, min(gait.sharpest_bend_rad, bend)))
            place = z[k - 1] + link * axis
            if abs(place) > self._limit[k]:
                place = self._on_the_wall(z[k - 1], link, axis, self._limit[k])
                axis = (place - z[k - 1]) / abs(place - z[k - 1])
            z[k] = place
        # A push from the head may flip a link over: the body gives way, but not in an instant.
        moved = np.array(z) - self._z
        pace = gait.largest_pace_mm_s * step_s / np.maximum(np.abs(moved), 1e-12)
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
        scale = FINE_PX / FINE_MM
        body = rounded_body(np.c_[z.real, z.imag] * scale, walker.width_mm * scale)
        centres, disc = body.discs()
        distance = np.hypot(*centres.T)
        room = (scale * (self._radius - 0.25 * self._gait.clearance_mm) - disc) / np.maximum(
            distance, 1e-9
        )
        z = z * min(1.0, float(room[distance > 0.01 * scale * self._radius].min()))
        return np.stack([z.real, z.imag], axis=1)

    def _tip(self, head: HeadPath) -> complex:
        """Place the head tip: its rounded end, leaning, needs a small gap to the wall."""
        long, half = HEAD_TAPER_WIDTHS * self._walker.width_mm, 0.5 * self._walker.width_mm
        lean = min(abs(head.lean_rad), self._gait.lean_rad)
        reach = np.hypot(long * cos(lean), half * sin(lean)) - long * cos(lean)
        distance = self._radius - max(float(reach) + self._gait.clearance_mm, head.depth_mm)
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
