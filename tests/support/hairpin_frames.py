"""A worm bent double that slides and swings: what frames of it tell, and hide."""

from dataclasses import replace

import numpy as np
from waiting_frames import SEEN, WIDTH

from worm_msgs_py import Status
from worm_tracker.observation import Observation
from worm_tracker.waiting.frame_state import PendingFrame

NODES = 121
HIDDEN = 12
MIDDLE = 40
"""The frame asked for, of those that a film has."""
FRAMES = 81


def hairpin(frame, *, apart_widths=1.2):
    """A worm bent double, one arm beside the other, that slides and swings: its true midline."""
    length, arms = 260.0, apart_widths * WIDTH
    s = np.linspace(0, length, NODES) - 130 + 1.5 * frame
    bend = np.clip(s / (0.5 * arms), -0.5 * np.pi, 0.5 * np.pi)
    along = np.abs(s - 0.5 * arms * bend)
    u = 200 - along + 0.5 * arms * np.cos(bend)
    return np.stack([u, 100 + 0.5 * arms * np.sin(bend) + 0.4 * frame], axis=1)


def folded(frame, **more):
    points = hairpin(frame)
    known = Observation(Status.FOLDED, 200.0, 100.0, points, np.full(NODES, WIDTH), 0.9, WIDTH)
    return replace(known, **more)


def with_end_hidden(frame, off_widths=0.0, **more):
    """Its tail is under the body, and supposed aside."""
    seen = folded(frame, status=Status.END_HIDDEN, occluded=(0, HIDDEN), unresolved=SEEN, **more)
    points = seen.points.copy()
    points[-HIDDEN:] += off_widths * WIDTH * np.array([0.6, 0.8])
    return replace(seen, points=points)


def with_end_off(frame, off_widths=1.0, *, seen_sd_widths=0.15, **more):
    """Its tail, which lies on the body, is told aside."""
    sd_px = (0.0, seen_sd_widths * WIDTH)
    seen = folded(frame, end_sd_px=sd_px, seen_end_sd_px=sd_px, **more)
    away_px = WIDTH * np.linspace(0.0, off_widths, HIDDEN)
    seen.points[-HIDDEN:] += away_px[:, np.newaxis] * np.array([0.6, 0.8])
    return seen


def film(hidden, seen_so=with_end_hidden, *, frames_per_s=25.0, leaps_from=FRAMES):
    """Frames of which some hide an end; the tail may be elsewhere from one of them on."""
    frames = []
    for k in range(FRAMES):
        seen = seen_so(k) if k in hidden else folded(k)
        if k >= leaps_from:
            seen.points[-HIDDEN:, 1] += 1.5 * WIDTH
        frames.append(PendingFrame(k, round(1e9 * k / frames_per_s), seen, None))
    return frames


def gap_of(count, middle=MIDDLE):
    first = middle - count // 2
    return range(first, first + count)
