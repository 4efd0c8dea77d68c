"""Bodies whose thin end lies along their own outer flank, drawn by lines."""

import cv2
import numpy as np
from benchmarks.drawn_lines import LineLook, picture_of

LOOK = LineLook(noise=3.0)
LIGHT = 200.0
LEVEL, DARKENING = LIGHT * (1 - LOOK.light_passed), LOOK.light_passed
RADIUS_WIDTHS, POINTS = 3.0, 700


def along_itself(width, start, aside, side=1):
    """Return a body that goes round and on along its own outer flank, and its widths.

    Its thin end lies so many widths beside the axis of the strand that it lies on, the other one
    within the loop.
    """
    turn = np.linspace(-1.2, 2 * np.pi + 2.0, 4000)
    out = np.clip((turn - np.pi) / np.pi, 0.0, 1.0)
    inner = np.clip(-turn / 1.2, 0.0, 1.0)
    radius = width * (RADIUS_WIDTHS + aside * out**2 * (3 - 2 * out) - 1.8 * inner**2)
    line = radius * np.exp(1j * side * (turn + start))
    s = np.r_[0.0, np.cumsum(abs(np.diff(line)))]
    at = np.linspace(0.0, s[-1], POINTS)
    even = np.interp(at, s, line.real) + 1j * np.interp(at, s, line.imag)
    return even + 6 * width * (1 + 1j), width * np.interp(s[-1] - at, [0.0, 4 * width], [0.3, 1.0])


def signal_of(line, widths, blur_px=0.0):
    """Return how much darker than the water the picture of a body is."""
    side = int(12 * widths.max()) + 2
    light, wall = np.full((side, side), LIGHT), np.zeros((side, side))
    points = np.stack([line.real, line.imag], axis=1)
    picture = picture_of(points, widths, LOOK, light, wall, seed=1)
    if blur_px:
        picture = cv2.GaussianBlur(picture, (0, 0), blur_px)
    return np.clip(LIGHT - picture, 0, 255).astype(np.uint8)


def with_last_end_moved(line, width, longer_widths):
    """Return a body whose last end is so many widths farther on, straight on, or within it."""
    count = round(abs(longer_widths) * width / abs(line[1] - line[0]))
    if longer_widths < 0:
        return line[: len(line) - count]
    return np.concatenate([line, line[-1] + np.arange(1, count + 1) * (line[-1] - line[-2])])
