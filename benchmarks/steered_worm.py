"""Worms that steer by a programme: 18 to 22 mm long, each part soon where the part before it was.

They stroke, pause, go back a little, swing the head and slip sideways, so that a body does not
follow its head exactly.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.steered_path import RADIUS_MM, STEP_MM, Floats, steered_path

FRAMES, FPS, NODES = 1000, 25.0, 401
_STATES = np.array([1, 1, 1, 0, 0.5, 1.6, -0.5])
_STATE_ODDS = np.array([0.3, 0.2, 0.1, 0.15, 0.1, 0.1, 0.05])


@dataclass(frozen=True, eq=False, slots=True)
class SteeredWorm:
    """A worm in motion.

    Attributes
    ----------
    midlines_mm : ndarray, shape (FRAMES, NODES, 2)
        Head first, in the chamber, y up.
    width_mm, tone : ndarray, shape (NODES,)
        Width, and how dark it is over the body's mean.
    """

    midlines_mm: Floats
    width_mm: Floats
    tone: Floats


def steered_worm(seed: int) -> SteeredWorm:
    """Return the worm of a seed; the same one each time."""
    rng = np.random.default_rng(seed)
    length_mm = float(rng.choice([18.0, 20.0, 20.0, 22.0]))
    width_mm = float(rng.choice([0.45, 0.5, 0.55]))
    path = steered_path(rng, length_mm + 110, width_mm)
    head_mm = _head_way(rng, length_mm + 0.5, STEP_MM * (len(path) - 1))
    lines = _bodies(rng, path, head_mm, length_mm, width_mm)
    return SteeredWorm(lines, *_look(rng, length_mm, width_mm))


def _head_way(rng: np.random.Generator, first_mm: float, most_mm: float) -> Floats:
    """Return how far along its path the head is in each frame, mm."""
    at, speed, state, left = first_mm, 0.0, 1.0, 0
    way = []
    for frame in range(FRAMES):
        if left <= 0:
            state = float(rng.choice(_STATES, p=_STATE_ODDS))
            left = int(rng.integers(20, 70) if state >= 0 else rng.integers(10, 25))
        left -= 1
        stroke = 1 + 0.5 * np.sin(2 * np.pi * frame / FPS * 0.9)
        speed += 0.15 * (state * 1.7 * stroke - speed)
        at = min(at + speed / FPS, most_mm)
        way.append(at)
    return np.array(way)


def _bodies(
    rng: np.random.Generator, path: Floats, head_mm: Floats, length_mm: float, width_mm: float
) -> Floats:
    """Lay the body along the path behind the head; it stretches, slips sideways and swings."""
    phase, wavelength_mm = rng.uniform(0, 6.28, 6), rng.uniform(3, 9, 3)
    slips = rng.uniform(0.05, 0.25, 3)
    s, part = np.arange(len(path)) * STEP_MM, np.linspace(0, 1, NODES)
    swinging = 0.35 * np.clip(1 - part * length_mm / 2.5, 0, 1) ** 2
    lines = []
    for frame, head in enumerate(head_mm):
        t = frame / FPS
        stretch = 0.05 * np.sin(2 * np.pi * t * 0.9 + phase[0]) + 0.03 * np.sin(t * 0.5 + phase[1])
        at = np.maximum(head - part * length_mm * (1 + stretch), 0)
        line = np.stack([np.interp(at, s, path[:, k]) for k in (0, 1)], axis=1)
        tangent = np.gradient(line, axis=0)
        tangent /= np.hypot(*tangent.T)[:, None] + 1e-9
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        slip = np.zeros(NODES)
        for wave, offset, rate in zip(wavelength_mm, phase[2:], slips, strict=False):
            slip += 0.07 * width_mm / 0.5 * np.sin(2 * np.pi * at / wave + offset + rate * t * 6)
        swing = swinging * np.sin(2 * np.pi * t * 0.45 + phase[5])
        line += normal * (slip + swing)[:, None]
        r, most = np.hypot(*line.T), RADIUS_MM - 0.51 * width_mm
        line *= np.where(r > most, most / np.maximum(r, 1e-9), 1)[:, None]
        lines.append(line)
    return np.array(lines)


def _look(rng: np.random.Generator, length_mm: float, width_mm: float) -> tuple[Floats, Floats]:
    """Return width (mm) and tone along the body: a blunt, paler head and a thin, paler tail."""
    part = np.linspace(0, 1, NODES)
    from_head, from_tail = part * length_mm, (1 - part) * length_mm
    wide = np.sqrt(np.clip(1 - (1 - np.clip(from_head / 0.5, 0, 1)) ** 2, 0.04, 1))
    wide *= np.interp(from_head, [0, 1.2], [0.8, 1])
    cap = np.sqrt(np.clip(1 - (1 - np.clip(from_tail / 0.25, 0, 1)) ** 2, 0.04, 1))
    wide = np.minimum(wide, cap * np.interp(from_tail, [0, 4], [rng.uniform(0.35, 0.7), 1]))
    marks_mm = np.arange(0, length_mm + 1, 0.8)
    tone = 1 + 0.08 * np.interp(from_head, marks_mm, rng.normal(0, 1, len(marks_mm)))
    tone *= np.interp(from_head, [0, 1.5], [0.8, 1]) * np.interp(from_tail, [0, 4], [0.85, 1])
    return wide * width_mm, tone
