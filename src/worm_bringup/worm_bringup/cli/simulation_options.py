"""Options of simulated trials: the worm, and how it is filmed."""

from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from worm_bringup.cli.number_options import number, numbers
from worm_model.filament.parameters import FilamentParameters
from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.rig.views import both_chambers, one_chamber
from worm_model.simulator.worm import Walker
from worm_msgs_py import limits, paper
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit

if TYPE_CHECKING:
    from worm_model.simulator.filming import Filming

_WORM, _BY_WALK = "The worm", "With --model walk"
_CAMERA, _WATER = "The camera", "Lamp and water"
FILM_FPS = Limit(0.1, 1000.0, "frames/s")
FILM_BODY_LENGTH, FILM_BODY_WIDTH = Limit(1.0, 60.0, "mm"), Limit(0.05, 5.0, "mm")
FILM_SPEED = Limit(0.01, 10.0, "mm/s")
FILM_STEP, FILM_EXCURSION = Limit(0.01, 100.0, "mm"), Limit(0.01, 2.0, "mm")
FILM_SCALE = Limit(2.0, 200.0, "px/mm")
NOISE, SHOT_NOISE = Limit(0.0, 255.0, "grey levels"), Limit(0.0, 100.0, "grey levels")
BLUR, EXPOSURE = Limit(0.0, 50.0, "px"), Limit(0.0, 10_000.0, "ms")
BITS, PIECES = Limit(8, 16), Limit(0, 1000)
LIGHT_PART, DRIFT = Limit(0.0, 1.0), Limit(-100.0, 100.0, "mm/min")
GRADIENT = Limit(-100.0, 100.0, "%")


class Model(Enum):
    """How the worm moves."""

    FILAMENT = "filament"
    WALK = "walk"


class SkinName(Enum):
    """A real worm whose look can be worn."""

    W4 = "w4"
    W5 = "w5"


@dataclass(frozen=True)
class WormOptions:
    """The worm; what is not given has the model's own value."""

    length_mm: Annotated[float, number(FILM_BODY_LENGTH, help="l_w.", rich_help_panel=_WORM)] = 20.0
    body_width_mm: Annotated[float, number(FILM_BODY_WIDTH, help="d_w.", rich_help_panel=_WORM)] = (
        0.4
    )
    speed_mm_s: Annotated[
        float | None,
        number(
            FILM_SPEED,
            help="Of a free filament; of the walk v_w: it goes v_w sin ψ_b along the wall. "
            "The model's own where not given.",
            rich_help_panel=_WORM,
        ),
    ] = None
    slide_mm: Annotated[
        float | None, number(FILM_STEP, help="Mean d_c.", rich_help_panel=_BY_WALK)
    ] = None
    hop_mm: Annotated[
        float | None, number(FILM_STEP, help="Mean d_nc.", rich_help_panel=_BY_WALK)
    ] = None
    excursion_mm: Annotated[
        float | None, number(FILM_EXCURSION, help="Mean Δr_h.", rich_help_panel=_BY_WALK)
    ] = None
    reversal: Annotated[
        float | None, number(limits.SHARE, help="Per slide and hop.", rich_help_panel=_BY_WALK)
    ] = None

    def refuse_walk_options(self) -> None:
        """Raise `BadInput` where an option of the walk was given: the filament has no such law."""
        for option in self._walk_options():
            name = option.replace("_", "-")
            raise BadInput(f"--{name} is the walk's: leave it out, or give --model walk")

    def filament(self) -> FilamentParameters:
        """Return the two-dimensional worm; `BadInput` where there is no such one."""
        try:
            worm = FilamentParameters(length_mm=self.length_mm, width_mm=self.body_width_mm)
        except ValueError as error:
            raise BadInput(f"--length-mm and --body-width-mm: {error}") from None
        if self.speed_mm_s is None:
            return worm
        return replace(worm, crawl_speed_mm_s=self.speed_mm_s)

    def walker(self, seed: int) -> Walker:
        """Return the worm that walks along the wall; `BadInput` where there is no such one."""
        if self.length_mm > paper.PASSAGE_LENGTH_MM:
            raise BadInput(
                f"--length-mm is {self.length_mm:g}: the walk ends when all of the worm is in the "
                f"passage, which is {paper.PASSAGE_LENGTH_MM:g} mm long; give a shorter worm, or "
                "leave out --model walk"
            )
        options = self._walk_options()
        given: dict[str, Any] = {_WALKER[name]: value for name, value in options.items()}
        if self.speed_mm_s is not None:
            given["speed_mm_s"] = self.speed_mm_s
        worm = Walker(length_mm=self.length_mm, width_mm=self.body_width_mm, seed=seed)
        try:
            return replace(worm, **given)
        except ValueError as error:
            raise BadInput(f"--excursion-mm and --hop-mm: {error}") from None

    def _walk_options(self) -> dict[str, float]:
        given = {name: getattr(self, name) for name in _WALKER}
        return {name: value for name, value in given.items() if value is not None}


_WALKER = {
    "slide_mm": "mean_slide_mm",
    "hop_mm": "mean_hop_mm",
    "excursion_mm": "mean_excursion_mm",
    "reversal": "reversal_per_cycle",
}
"""Which of the walker's numbers an option is."""


@dataclass(frozen=True)
class FilmOptions:
    """The camera over the rig, and what else it sees."""

    fps: Annotated[float, number(FILM_FPS, rich_help_panel=_CAMERA)] = 30.0
    single_chamber: Annotated[
        bool,
        typer.Option(
            "--one-chamber", help="Film chamber a alone, larger.", rich_help_panel=_CAMERA
        ),
    ] = False
    px_per_mm: Annotated[
        float | None,
        number(
            FILM_SCALE,
            help="20 where not given, 40 of one chamber: a picture of a megapixel.",
            rich_help_panel=_CAMERA,
        ),
    ] = None
    bits: Annotated[int, number(BITS, help="A pixel: 8 or 16.", rich_help_panel=_CAMERA)] = 8
    noise: Annotated[
        float, number(NOISE, help="Read noise, grey levels, sd.", rich_help_panel=_CAMERA)
    ] = 2.0
    shot_noise: Annotated[
        float,
        number(SHOT_NOISE, help="Its variance for each grey level.", rich_help_panel=_CAMERA),
    ] = 0.0
    blur_px: Annotated[float, number(BLUR, help="Of the lens, sd.", rich_help_panel=_CAMERA)] = 0.8
    exposure_ms: Annotated[
        float, number(EXPOSURE, help="Motion blur.", rich_help_panel=_CAMERA)
    ] = 0.0
    drift_mm_per_min: Annotated[
        tuple[float, float],
        numbers("How fast the camera drifts.", rich_help_panel=_CAMERA, RIGHT=DRIFT, DOWN=DRIFT),
    ] = (0.0, 0.0)
    jpeg_quality: Annotated[
        int, number(limits.JPEG_QUALITY, help="Of 8 bits.", rich_help_panel=_CAMERA)
    ] = 90
    gradient_percent: Annotated[
        tuple[float, float],
        numbers(
            "Change of the light from the middle to the right and the lower edge.",
            rich_help_panel=_WATER,
            RIGHT=GRADIENT,
            DOWN=GRADIENT,
        ),
    ] = (12.0, -8.0)
    flicker: Annotated[
        float, number(LIGHT_PART, help="The lamp is in 1 ± this.", rich_help_panel=_WATER)
    ] = 0.0
    wall_light: Annotated[
        float, number(LIGHT_PART, help="Light that the wall lets pass.", rich_help_panel=_WATER)
    ] = 0.2
    debris: Annotated[int, number(PIECES, help="Specks.", rich_help_panel=_WATER)] = 0
    bubbles: Annotated[int, number(PIECES, rich_help_panel=_WATER)] = 0
    glare: Annotated[int, number(PIECES, help="Bright spots.", rich_help_panel=_WATER)] = 0
    skin: Annotated[
        SkinName | None,
        typer.Option(
            help="Wear the skin of a photographed Lumbriculus; one grey where not given.",
            rich_help_panel=_WATER,
        ),
    ] = None

    def rig(self, exit_width_mm: float, seed: int) -> Rig:
        """Return the rig in the camera's view."""
        view = one_chamber if self.single_chamber else both_chambers
        scale = self.px_per_mm or (40.0 if self.single_chamber else 20.0)
        if self.bits not in (8, 16):
            raise BadInput(f"--bits is {self.bits}: give 8 or 16")
        right, down = self.gradient_percent
        optics = Optics(
            gradient=(right / 100.0, down / 100.0),
            wall_transmission=self.wall_light,
            blur_px=self.blur_px,
            noise=self.noise,
            shot_noise=self.shot_noise,
            bits=self.bits,
            seed=seed,
        )
        return view(scale, exit_width_mm, optics)

    def filming(self, body_width_mm: float) -> "Filming":
        """Return how a worm of this width is filmed."""
        # Compiled code is slow to import, and most commands simulate nothing.
        from worm_model.simulator.filming import Filming
        from worm_model.simulator.rig.skins import read_skins

        if self.exposure_ms * self.fps > 1e3:
            raise BadInput(
                f"--exposure-ms is {self.exposure_ms:g}, longer than a frame: "
                f"give {1e3 / self.fps:g} or less"
            )
        return Filming(
            frames_per_s=self.fps,
            body_width_mm=body_width_mm,
            skin=None if self.skin is None else read_skins()[self.skin.value],
            exposure_s=1e-3 * self.exposure_ms,
            flicker=self.flicker,
            debris=self.debris,
            bubbles=self.bubbles,
            glare=self.glare,
            drift_mm_per_min=self.drift_mm_per_min,
        )
