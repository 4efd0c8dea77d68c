"""How a scene is filmed: scale, length, noise, and the rig that this makes."""

from dataclasses import dataclass, replace
from math import radians

from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.rig.views import one_chamber

WHOLE_RIG_SCALE = 0.4
"""The scale of a film of the whole rig, as a part of that of a film of one chamber."""


@dataclass(frozen=True, slots=True)
class Take:
    """How a scene is filmed.

    Attributes
    ----------
    px_per_mm : float
        Scale; the picture of one chamber is 25.6 mm wide and high: 1024² at 40 px/mm.
    frames : int
        Length of the film.
    noise : float
        Standard deviation of the noise, grey levels.
    seed : int
        The same seed gives the same bytes.
    """

    px_per_mm: float = 40.0
    frames: int = 300
    noise: float = 3.0
    seed: int = 0

    @property
    def chamber(self) -> Rig:
        """One chamber, not quite in the picture's middle, its exit to the upper right."""
        return replace(one_chamber(self.px_per_mm, 2.0, self._optics), chamber_b=False)

    @property
    def whole_rig(self) -> Rig:
        """Both chambers and the passage, 3 mm wide, lying almost along the picture."""
        scale = WHOLE_RIG_SCALE * self.px_per_mm
        return Rig(
            width_px=round(80.0 * scale),
            height_px=round(30.0 * scale),
            px_per_mm=scale,
            centre_px=(12.4 * scale + 0.3, 15.5 * scale - 0.4),
            exit_rad=radians(1.5),
            exit_width_mm=3.0,
            chamber_b=True,
            optics=self._optics,
        )

    @property
    def _optics(self) -> Optics:
        return Optics(noise=self.noise, blur_px=1.0, seed=self.seed)
