"""Pictures of bodies whose skin has marks, drawn from where each place of the skin lies."""

import numpy as np
from drawn_folds import LEVEL, Drawn

from worm_tracker.midline.body_shade import ACROSS, BodyShade, ShadedObject

PLACES = 65


def marks_from(seed):
    """Return how dark a skin is along the body, over its mean, shape (PLACES,)."""
    knots = np.random.default_rng(seed).uniform(0.75, 1.25, 17)
    return np.interp(np.linspace(0, 16, PLACES), np.arange(17), knots)


def drawn_along(curve, width):
    """Return a body along a curve, in a window that holds it."""
    margin = 4 * width * (1 + 1j)
    return Drawn(curve - complex(curve.real.min(), curve.imag.min()) + margin, width)


def shaded(body, marks, known):
    """Return the picture of a body whose skin has such marks, and others known of it."""
    curve, signal = body.curve, body.signal.astype(float)
    v, u = np.nonzero(body.mask)
    nearest = np.abs((u + 1j * v)[:, None] - curve[::4]).argmin(axis=1) * 4 / (len(curve) - 1)
    signal[v, u] *= np.interp(nearest, np.linspace(0, 1, PLACES), marks)
    mean = np.repeat(LEVEL * known[:, None], len(ACROSS), axis=1)
    shade = BodyShade(mean, np.zeros_like(mean), 50)
    return ShadedObject(np.clip(np.rint(signal), 0, 255).astype(np.uint8), shade, 0.45)
