"""Bodies in a skin with marks, whose end lies along their own strand, as the rig draws them."""

import numpy as np
from drawn_folds import as_rows
from flank_ends import along_itself

from worm_model.simulator.rig import Optics, Rig, expose
from worm_model.simulator.rig.strands import Skin, polyline_body, skinned_view
from worm_tracker.midline.body_shade import shade_along
from worm_tracker.midline.drawn_skin import SkinnedBody

LIGHT, PASSED = 200.0, 0.5
LEVEL, DARKENING = LIGHT * (1 - PASSED), PASSED
WIDTH, KNOWN_AT = 14.0, 65
PX_PER_MM = 14.0


def skin_of(widths, length, marks):
    """Return a skin that lets less light through where it has marks, and nothing beyond its edge.

    `widths` and `marks` (over the darkness of most of it) are at equal parts of its length.
    """
    middle, beyond = int(WIDTH), int(WIDTH)
    row = np.arange(-beyond, int(length) + beyond + 1)
    part, from_end = row / length, np.minimum(row, length - row)
    half = np.interp(part, np.linspace(0, 1, len(widths)), widths) / 2
    half = np.sqrt(np.maximum(half**2 - np.maximum(half - from_end, 0.0) ** 2, 0.0))  # round ends
    dark = np.interp(part, np.linspace(0, 1, len(marks)), marks) * (1 - PASSED)
    inside = np.clip(half[:, None] + 0.5 - abs(np.arange(-middle, middle + 1)), 0.0, 1.0)
    inside[half == 0] = 0.0
    across = np.linspace(0, length / PX_PER_MM, KNOWN_AT)
    widths_mm = np.interp(across / across[-1], np.linspace(0, 1, len(widths)), widths) / PX_PER_MM
    return Skin(
        1 - inside * dark[:, None], -beyond / PX_PER_MM, PX_PER_MM, length / PX_PER_MM, widths_mm
    )


def signal_in_skin(line, widths, skin, noise=2.0):
    """Return how much darker than the water the picture of a body in a skin is."""
    size = [int(np.ceil(x.max() + 3 * WIDTH)) for x in (line.real, line.imag)]
    optics = Optics(
        light=LIGHT, worm_transmission=PASSED, gradient=(0.0, 0.0), noise=noise, blur_px=0.8
    )
    far = 0.2 * max(size)
    middle = size[0] / 2, size[1] / 2
    rig = Rig(*size, px_per_mm=PX_PER_MM, centre_px=middle, radius_mm=far, optics=optics)
    picture = expose(rig, skinned_view(rig, polyline_body(as_rows(line), widths), skin), 0)
    return np.clip(np.rint(LIGHT - picture.astype(float)), 0, 255).astype(np.uint8)


def marks_along(seed, pale_end=1.0):
    """Return how dark a skin is along a body, over most of it; its last eighth as pale as said."""
    knots = np.random.default_rng(seed).uniform(0.8, 1.2, 25)
    marks = np.interp(np.linspace(0, 1, KNOWN_AT), np.linspace(0, 1, 25), knots)
    marks[-KNOWN_AT // 8 :] *= pale_end
    return marks


def body_in_skin(start, aside, marks):
    """Return a body along itself, its widths, its picture, and the skin that is known of it.

    The skin is known from a picture of the same body laid straight.
    """
    line, widths = along_itself(WIDTH, start, aside)
    skin = skin_of(widths, length := float(abs(np.diff(line)).sum()), marks)
    straight = np.linspace(0, length, len(line)) + 3 * WIDTH * (1 + 1j)
    opened = signal_in_skin(straight, widths, skin)
    at = np.linspace(0, len(line) - 1, KNOWN_AT).astype(int)
    mean = shade_along(opened, straight[at], widths[at])
    return line, widths[at], signal_in_skin(line, widths, skin), mean


def from_its_end(curve, widths, mean):
    """Return a body that is thought to lie along a curve, from its last end on."""
    return SkinnedBody(curve, widths[::-1], mean[::-1, ::-1], LEVEL, DARKENING)
