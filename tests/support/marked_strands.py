"""A straight strand of a marked skin, alone or laid back on itself, drawn by plain sums."""

import numpy as np

WIDTH = 12.0
LENGTH = 40 * WIDTH
LEFT, MIDDLE = 60.0, 40.0
NODES = 121


def marks(rng, pale_widths=0.0, pale=0.45, least=60.0, most=110.0):
    """Return the signal of one layer at NODES places of a body, its first end paler."""
    coarse = rng.uniform(least, most, 41)
    level = np.interp(np.linspace(0, 40, NODES), np.arange(41), coarse)
    return np.where(np.linspace(0, 40, NODES) < pale_widths, pale * level, level)


def level_at(levels, s):
    """Return the signal of one layer so far along the body; 0 where there is none."""
    known = np.interp(s, np.linspace(0, LENGTH, len(levels)), levels)
    return np.where((s >= 0) & (s <= LENGTH), known, 0.0)


def laid_back(levels, turns_at, darkening, apart_px=0.0):
    """Return a picture of a body that turns back on itself after so many pixels, and its line.

    Each layer lets the same part of the light through wherever it lies, so much that of two of
    middling signal the second adds that times `darkening`: with none, what lies below is not seen.
    The way back lies so far below the way there.
    """
    v, u = np.indices((int(2 * MIDDLE), int(LEFT + LENGTH + 40)))
    along = u - LEFT
    there = np.where(along <= turns_at, level_at(levels, along), 0.0)
    back = level_at(levels, 2 * turns_at - along) * (along <= turns_at)
    there = there * (np.abs(v - MIDDLE) <= WIDTH / 2)
    back = back * (np.abs(v - MIDDLE - apart_px) <= WIDTH / 2)
    blackest = np.median(levels) / (1 - darkening)
    adds = back * (1 - there / blackest if darkening else there == 0)
    s = np.linspace(0, LENGTH, 400)
    line = LEFT + np.where(s < turns_at, s, 2 * turns_at - s) + 1j * MIDDLE
    line += 1j * apart_px * (s >= turns_at)
    return np.clip(there + adds, 0, 255).astype(np.uint8), line


def alone(levels, cut_px=0.0):
    """Return a picture of a straight body whose first end is cut off, and its line from the cut."""
    v, u = np.indices((int(2 * MIDDLE), int(LEFT + LENGTH + 40)))
    s = np.where(u - LEFT >= cut_px, u - LEFT, -1.0)
    signal = level_at(levels, s) * (np.abs(v - MIDDLE) <= WIDTH / 2)
    line = LEFT + np.linspace(cut_px, LENGTH, 400) + 1j * MIDDLE
    return np.clip(signal, 0, 255).astype(np.uint8), line
