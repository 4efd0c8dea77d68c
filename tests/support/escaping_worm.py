"""A worm of known laws that searches for the exit, fails, tries again and changes chambers.

Its tracks are a table as another tracker would write it: millimetres, all in the first chamber's
frame; the second chamber's centre is at x = 2 R + L. Slides, hops and the reversals between them
are those of the boundary walk; an attempt at the exit succeeds with a fixed chance, and otherwise
turns back at an exponential depth.
"""

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq

R, L = 10.0, 35.0
BODY, LAG, WIDTH = 20.0, 6.0, 0.4
TOUCHING, FREE = 0.04, 0.12
LEAN = np.radians(32.0)


@dataclass(frozen=True)
class Worm:
    exit_width_mm: float = 1.0
    speed_mm_s: float = 2.02
    slide_mm: float = 1.95
    hop_mm: float = 1.46
    depth_mm: float = 1.14
    reversal: float = 0.05
    speed_spread: float = 0.0
    success: float = 0.6
    turn_back_mm: float = 2.0
    seed: int = 0


class _Film:
    """Positions of head and centroid, frame by frame, as the worm is told to move."""

    def __init__(self, worm, fps):
        self.worm, self.fps = worm, fps
        self.random = np.random.default_rng([worm.seed, 7])
        self.head, self.centroid, self.time = [], [], 0.0
        self.in_b = False

    def move(self, seconds, head, centroid):
        """Film a movement: functions of the part 0 to 1 of it, in the chamber's own frame."""
        start, self.time = self.time, self.time + seconds
        first, after = (int(np.ceil(t * self.fps - 1e-9)) for t in (start, self.time))
        if after > first:
            part = (np.arange(first, after) / self.fps - start) / seconds
            for points, place in ((self.head, head), (self.centroid, centroid)):
                x, y = place(part)
                x, y = np.broadcast_arrays(x, y + 0.0 * part)
                points.append(np.c_[2 * R + L - x, -y] if self.in_b else np.c_[x, y])

    def along_wall(self, seconds, theta, turn, depth):
        """Go along the wall by an angle, leaning into the direction."""
        psi = np.sign(turn) * LEAN + self.random.normal(0, 0.1)

        def head(part):
            angle = theta + turn * part
            return (R - depth) * np.cos(angle), (R - depth) * np.sin(angle)

        def centroid(part):
            x, y = head(part)
            angle = theta + turn * part + psi
            return x - LAG * np.cos(angle), y - LAG * np.sin(angle)

        self.move(seconds, head, centroid)

    def along_line(self, speed, start, end, *, lag=(LAG, 0.0)):
        start, end = np.array(start), np.array(end)
        seconds = max(float(np.hypot(*(end - start))) / speed, 1e-3)

        def head(part):
            return tuple(start[k] + (end[k] - start[k]) * part for k in (0, 1))

        def centroid(part):
            x, y = head(part)
            return x - lag[0], y - lag[1]

        self.move(seconds, head, centroid)


def escaping_worm(worm=Worm(), duration_s=300.0, fps=15.0):
    """Return the columns of its table."""
    film = _Film(worm, fps)
    theta = film.random.uniform(0.5, 2 * np.pi - 0.5)
    while film.time < duration_s:
        theta = _search(film, worm, theta, duration_s)
        if film.time >= duration_s:
            break
        theta = _attempt(film, worm, theta)
    rows = int(duration_s * fps)
    head, centroid = (np.concatenate(points)[:rows] for points in (film.head, film.centroid))
    t = np.arange(len(head)) / fps
    noise = np.random.default_rng([worm.seed, 8])
    tail = 2 * centroid - head
    return {
        "time_s": t,
        "head_x_mm": head[:, 0],
        "head_y_mm": head[:, 1],
        "centroid_x_mm": centroid[:, 0],
        "centroid_y_mm": centroid[:, 1],
        "tail_x_mm": tail[:, 0],
        "tail_y_mm": tail[:, 1],
        "head_yaw_deg": np.degrees(np.arctan2(*(head - centroid).T[::-1]))
        + noise.normal(0, 20, len(t)),
        "length_mm": BODY * (1 + 0.02 * np.sin(2 * np.pi * t / 0.6)),
        "width_mm": np.full(len(t), WIDTH),
    }


def _search(film, worm, theta, until_s):
    """Slide and hop until the exit is found; return the angle there."""
    half = np.arcsin(worm.exit_width_mm / 2 / R)
    direction, sliding = film.random.choice([-1.0, 1.0]), True
    while film.time < until_s:
        distance = film.random.exponential(worm.slide_mm if sliding else worm.hop_mm)
        goal = theta + direction * distance / R
        depth = TOUCHING if sliding else FREE + film.random.exponential(worm.depth_mm)
        edge = half if direction < 0 else 2 * np.pi - half
        meets = sliding and (goal <= edge if direction < 0 else goal >= edge)
        goal = edge if meets else goal
        turn = goal - theta
        if turn:
            pace = worm.speed_mm_s * (1 + worm.speed_spread * film.random.uniform(-1, 1))
            film.along_wall(abs(turn) * R / pace, theta, turn, min(depth, 0.8 * R))
        theta = goal % (2 * np.pi)
        if meets or not half < theta < 2 * np.pi - half:
            return theta
        if not sliding and film.random.random() < worm.reversal:
            direction = -direction
        sliding = not sliding
    return theta


def _attempt(film, worm, theta):
    """Enter the exit; come back beside it, or go on into the other chamber and touch its wall."""
    half = worm.exit_width_mm / 2
    y = film.random.uniform(-1, 1) * (half - 0.05)
    mouth = np.sqrt(R**2 - half**2)
    film.along_line(4.0, ((R - 0.2) * np.cos(theta), (R - 0.2) * np.sin(theta)), (mouth, y))
    if film.random.random() < worm.success:
        film.along_line(4.0, (mouth, y), (R + L + 0.1, 0.0))
        film.in_b = not film.in_b
        goal = film.random.uniform(0.6, 2 * np.pi - 0.6)
        film.along_line(4.0, (R - 0.1, 0.0), (0.5 * R, 0.0), lag=(-LAG, 0.0))
        touch = ((R - TOUCHING) * np.cos(goal), (R - TOUCHING) * np.sin(goal))
        film.along_line(4.0, (0.5 * R, 0.0), touch, lag=(-LAG, 0.0))
        return goal
    depth = min(film.random.exponential(worm.turn_back_mm), 5.5)
    film.along_line(4.0, (mouth, y), (mouth + depth, y))
    side = 1.0 if film.random.random() < 0.5 else -1.0
    away = side * (np.arcsin(half / R) + 0.05)
    film.along_line(4.0, (mouth + depth, y), (R - 1.0, 0.0))
    film.along_line(4.0, (R - 1.0, 0.0), ((R - 0.2) * np.cos(away), (R - 0.2) * np.sin(away)))
    return away % (2 * np.pi)


def write_table(path, columns):
    """Write columns to a CSV or a Parquet file."""
    table = pa.table(columns)
    if path.suffix == ".csv":
        pa_csv.write_csv(table, path)
    else:
        pq.write_table(table, path)
    return path
