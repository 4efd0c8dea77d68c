"""What darkens the water beside the body does not count as body."""

import numpy as np
import pytest

from worm_model.simulator.rig import Body, Optics, Rig, draw
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
