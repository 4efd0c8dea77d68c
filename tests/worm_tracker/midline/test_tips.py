"""The tips of a drawn body are found where its midline ends, however the body bends."""

import numpy as np
import pytest

from worm_model.simulator.rig import Optics, Rig, draw
from worm_model.simulator.worm import rounded_body
from worm_tracker.midline.refine import RefineSettings, refine

CLEAR = 200
LENGTH_WIDTHS = 15.0


def errors(bend, width, noise, seed):
    """Return how far both tips lie beyond the true ones, and towards the bend's inner side."""
    optics = Optics(light=CLEAR, gradient=(0.0, 0.0), noise=noise, blur_px=1.0, seed=seed)
    # A chamber wider than the picture: there is nothing but water.
    rig = Rig(width_px=460, height_px=460, centre_px=(230.0, 230.0), radius_mm=40.0, optics=optics)
    rng = np.random.default_rng(seed)
    s = np.linspace(0.0, LENGTH_WIDTHS * width, 151)
    direction = rng.uniform(0.0, 2.0 * np.pi) + bend / width * (s - s[-1] / 2)
    z = np.concatenate([[0.0], np.cumsum(np.exp(1j * direction[:-1]) * np.diff(s))])
    z += 230.0 + 230.0j - z.mean() + rng.uniform(-0.5, 0.5) + 1j * rng.uniform(-0.5, 0.5)
    body = rounded_body(np.stack([z.real, z.imag], axis=1), width)
    dark = draw(rig, body, seed).astype(float)
    signal = np.clip(CLEAR - dark, 0, 255).astype(np.uint8)
    refined = refine(
        signal, (0, 0), body.at(np.linspace(3.0, body.length_px - 3.0, 65)), width, RefineSettings()
    )
    found = []
    for tip, from_tip, inner in ((0, 0.0, 2.0), (-1, body.length_px, body.length_px - 2.0)):
        true, near = (complex(*body.at(at)) for at in (from_tip, inner))
        off = (complex(*refined.points[tip]) - true) / ((true - near) / abs(true - near))
        # Seen outwards, the inner side is at the head's right where it is at the tail's left.
        found.append((off.real, off.imag if tip == -1 else -off.imag))
    return found


@pytest.mark.parametrize("bend", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("width", [10.0, 18.0])
def test_the_tip_of_a_bent_end_lies_on_its_axis(bend, width):
    """A bend of 0.3 radians a width is that of a ring only six widths across."""
    found = np.array([errors(bend, width, 3.0, seed) for seed in range(4)])
    assert np.abs(found[..., 1].mean(0)).max() < 0.12
    assert np.abs(found[..., 1]).max() < 0.4


@pytest.mark.parametrize("bend", [0.0, 0.3])
def test_tips_lie_within_the_body_by_what_the_lens_draws_them_in(bend):
    """By σ²/2ρ, which is 0.17 px at this head (ρ = w/6) and 0.28 px at this tail (ρ = w/10)."""
    width = 18.0
    found = np.array([errors(bend, width, 0.0, seed) for seed in range(4)])
    along = found[..., 0].mean(0)
    assert np.allclose(along, [-3 / width, -5 / width], atol=0.12)
