"""What darkens the water beside the body does not count as body."""

import numpy as np
import pytest

from worm_model.simulator.rig import Body, Optics, Rig, draw, worm_coverage
from worm_model.simulator.rig.strands import polyline_body
from worm_tracker.midline.curve import resample
from worm_tracker.midline.refine import RefineSettings, refine

CLEAR = 200
RIG = Rig(
    width_px=512,
    height_px=512,
    px_per_mm=20.0,
    centre_px=(255.5, 255.5),
    optics=Optics(light=CLEAR, gradient=(0.0, 0.0), noise=2.0, blur_px=1.0),
)
WIDTH = 12.0


def worm():
    x = np.linspace(-90.0, 90.0, 40)
    return Body.along(np.stack([255.5 + x, 255.5 + 12.0 * np.sin(x / 30.0)], axis=1), WIDTH)


@pytest.mark.parametrize("darker", [0.04, 0.08])
def test_a_faint_image_under_one_flank_of_the_head_moves_no_centroid(darker):
    """A ghost under a third of the body would widen it there: the centroid would go that way."""
    body = worm()
    picture = draw(RIG, body, 0).astype(float)
    clean = picture.copy()
    picture[250:330, 330:400] *= 1 - darker
    found = []
    for each in (clean, picture):
        signal = np.clip(CLEAR - np.rint(each), 0, 255).astype(np.uint8)
        found.append(refine(signal, (0, 0), resample(body.points_px, 65), WIDTH, RefineSettings()))
    without, ghost = found
    assert abs(ghost.u - without.u) < 0.25
    assert abs(ghost.area / without.area - 1) < 0.005


@pytest.mark.parametrize("tail", [0.1, 0.3])
@pytest.mark.parametrize("bend", [0.0, 0.02])
def test_a_tail_thinner_than_its_blur_draws_no_centroid_towards_it(tail, bend):
    """The half-height edges of a line lie 2.4 standard deviations of the blur apart."""
    drawn = thin_tailed(tail, bend)
    errors = []
    for seed in range(4):
        picture = draw(RIG, drawn, seed).astype(float)
        signal = np.clip(CLEAR - np.rint(picture), 0, 255).astype(np.uint8)
        first = drawn.at(np.linspace(3.0, drawn.length_px - 3.0, 65))
        found = refine(signal, (0, 0), first, WIDTH, RefineSettings())
        errors.append(np.array([found.u, found.v]) - worm_coverage(drawn).centroid_px())
    assert np.hypot(*np.mean(errors, axis=0)) < 0.3


def thin_tailed(tail, bend):
    """Return a body whose last third tapers to a part of its width."""
    s = np.linspace(0.0, 300.0, 151)
    z = np.r_[0.0, np.cumsum(np.exp(1j * (0.4 + bend * s[:-1])) * np.diff(s))]
    z += 255.5 + 255.5j - z.mean()
    into_tail = np.clip(3.0 * s / s[-1] - 2.0, 0.0, 1.0)
    width = WIDTH * (1.0 - (1.0 - tail) * into_tail)
    return polyline_body(np.stack([z.real, z.imag], axis=1), width)
