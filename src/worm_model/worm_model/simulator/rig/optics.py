"""The light behind the rig and the camera above it: brightness, gradient, blur, noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FilmedPicture = NDArray[np.uint8] | NDArray[np.uint16]
"""A picture, shape (height, width), of 8 or of 16 bits."""


@dataclass(frozen=True, slots=True)
class Optics:
    """What turns transmissions into grey levels.

    A pixel's mean grey level is ``light × gradient × (transmission ∗ Gaussian of blur_px)``.

    Attributes
    ----------
    light : float
        Grey level (0–255) of clear water at the picture's middle.
    wall_transmission, worm_transmission : float
        Share of the light that passes the wall and the worm, 0 (black) to 1.
    gradient : tuple of float
        Relative change of the light from the picture's middle to its right and to its lower edge.
    blur_px : float
        Standard deviation of the camera's point spread; 0 for none.
    noise : float
        Standard deviation of a pixel's noise in the dark (the sensor's read noise), grey levels.
    shot_noise : float
        How much its variance grows with each grey level (0–255), as counted photons vary.
    bits : int
        8 or 16 a pixel; grey levels are given in 0–255 for both.
    crossings_absorb : bool
        Whether the worm absorbs twice where it crosses itself, as a real one does; else it is one
        dark area.
    seed : int
        Seed of the noise; each frame has a stream of its own.
    """

    light: float = 200.0
    wall_transmission: float = 0.2
    worm_transmission: float = 0.3
    gradient: tuple[float, float] = (0.12, -0.08)
    blur_px: float = 0.8
    noise: float = 2.0
    shot_noise: float = 0.0
    bits: int = 8
    crossings_absorb: bool = False
    seed: int = 0

    def light_field(self, width_px: int, height_px: int) -> NDArray[np.float32]:
        """Return the grey level of clear water at each pixel, shape (height, width)."""
        u = np.linspace(-1.0, 1.0, width_px)
        v = np.linspace(-1.0, 1.0, height_px)[:, np.newaxis]
        relative = 1.0 + self.gradient[0] * u + self.gradient[1] * v
        return np.asarray(self.light * relative, dtype=np.float32)

    def noise_of_frame(self, frame: int, shape: tuple[int, int]) -> NDArray[np.float32]:
        """Return a standard normal number for each pixel: the same frame has the same ones."""
        stream = np.random.Generator(np.random.SFC64([self.seed, frame]))
        return stream.standard_normal(shape, dtype=np.float32)
