"""A worm that takes away the same part of the light is as dark in dim light as in bright."""

import numpy as np
import pytest

from worm_tracker.detection.illumination import (
    IlluminationSettings,
    evened,
    evening_of,
    fit_illumination,
)

SETTINGS = IlluminationSettings()
SHAPE = (120, 160)


def lamp(part):
    """Return light that falls off by a part across the picture."""
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float32)
    return np.asarray(220 * (1 - part * u / SHAPE[1]) * (1 - 0.2 * part * v / SHAPE[0]), np.float32)


@pytest.mark.parametrize("part", [0.0, 0.2, 0.4])
@pytest.mark.parametrize("passed", [0.35, 0.6])
def test_one_body_has_one_signal_wherever_it_lies(part, passed):
    light, arena = lamp(part), np.ones(SHAPE, bool)
    picture = np.rint(light).astype(np.uint8)
    picture[50:60] = np.rint(passed * light[50:60])
    fitted = fit_illumination(picture, arena, SETTINGS)
    signal = np.clip(np.rint(fitted) - picture, 0, 255).astype(np.uint8)
    even = evened(signal, evening_of(fitted, arena, SETTINGS))[50:60]
    assert even.std() < 0.02 * even.mean()
    assert even.mean() == pytest.approx((1 - passed) * light.mean(), rel=0.03)
    if part:
        assert signal[50:60].std() > 0.05 * signal[50:60].mean(), "else there is nothing to even"


def test_even_light_leaves_a_signal_as_it_is():
    light, arena = np.full(SHAPE, 200, np.float32), np.ones(SHAPE, bool)
    signal = np.arange(np.prod(SHAPE)).reshape(SHAPE).astype(np.uint8)
    assert np.array_equal(evened(signal, evening_of(light, arena, SETTINGS)), signal)


def test_a_signal_in_the_dark_is_not_blown_up():
    light, arena = lamp(0.2), np.ones(SHAPE, bool)
    light[:, :8] = 1.0  # beyond the view
    evening = evening_of(light, arena, SETTINGS)
    assert evening.max() == 100 * SETTINGS.most_evening
