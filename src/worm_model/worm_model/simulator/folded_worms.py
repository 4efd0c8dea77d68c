"""Films of worms that fold on themselves, from given midlines, in several looks."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from worm_model.simulator.film import FilmFrame, frame_stamp_ns
from worm_model.simulator.filming import Filming
from worm_model.simulator.rig import Body, Rig, expose, truth_of
from worm_model.simulator.rig.disturbances import add_debris, scattered
from worm_model.simulator.rig.strands import (
    Shade,
    Skin,
    covered,
    polyline_body,
    shaded_view,
    skinned_view,
    strands_over,
)
from worm_model.simulator.take import Take
from worm_msgs_py.arrays import Floats
from worm_msgs_py.units import UM_PER_MM

SPECKS = 30
THIN_TAIL_WIDTH, THIN_TAIL_PART = 0.1, 0.35
"""A thin tail falls to this part of the full width, over this part of the length."""
BLUNT_HEAD_WIDTH = 0.6
"""A blunt head's tip is a half circle of this part of the full width."""


@dataclass(frozen=True, eq=False, slots=True)
class FoldedWorm:
    """A worm's true motion.

    Attributes
    ----------
    midlines_mm : ndarray, shape (frames, n, 2)
        x, y in the frame of chamber a, head first; straight between the points.
    width_mm : ndarray, shape (n,)
        Full width at these points.
    fps : float
    """

    midlines_mm: Floats
    width_mm: Floats
    fps: float


DARKER = Shade(overlap_darker=True)


@dataclass(frozen=True, slots=True)
class Look:
    """How a worm is filmed.

    Attributes
    ----------
    px_per_mm : float
    shade : Shade
        Of a worm of one grey.
    skin : str
        Which real skin it wears instead, if any.
    thin_tail_blunt_head : bool
        Whether the tail tapers to a tenth of the width, and the head hardly.
    debris : bool
        Whether thirty specks lie in the chamber.
    jpeg_quality : int
        Of the pictures, where they are stored.
    """

    px_per_mm: float = 40.0
    shade: Shade = DARKER
    skin: str = ""
    thin_tail_blunt_head: bool = False
    debris: bool = False
    jpeg_quality: int = 95


LOOKS = {
    "one_shade": Look(shade=Shade(overlap_darker=False)),
    "darker": Look(),
    "coarse": Look(px_per_mm=25.0, debris=True, jpeg_quality=90),
    "skin_w4": Look(skin="w4"),
    "skin_w5": Look(skin="w5"),
    "thin_tail": Look(thin_tail_blunt_head=True),
}
"""``coarse`` has the overlap darker, debris and a strong JPEG."""


def read_folded_worms(path: Path) -> dict[str, FoldedWorm]:
    """Read the motions kept in ``bags/source/folded_worms.npz``, by the worm's name."""
    with np.load(path) as data:
        names = sorted(key.removeprefix("width_um_") for key in data if key.startswith("width"))
        return {
            name: FoldedWorm(
                midlines_mm=_summed(data[f"midline_steps_{name}"]) / UM_PER_MM,
                width_mm=data[f"width_um_{name}"] / UM_PER_MM,
                fps=float(data["fps"]),
            )
            for name in names
        }


def _summed(steps: np.ndarray) -> Floats:
    """Undo the differences by frame and by point, (2, frames, n), in whole micrometres."""
    um = np.cumsum(np.cumsum(steps.astype(np.int64), axis=1), axis=2)
    return np.asarray(np.moveaxis(um, 0, -1), dtype=np.float64)


def width_in(look: Look, worm: FoldedWorm, skin: Skin | None = None) -> Floats:
    """Return the worm's width in this look, mm, at the points of its midlines."""
    part = np.linspace(0.0, 1.0, len(worm.width_mm))
    if skin is not None:
        return np.interp(part, np.linspace(0.0, 1.0, len(skin.width_mm)), skin.width_mm)
    if not look.thin_tail_blunt_head:
        return worm.width_mm
    into_tail = np.clip((part - 1.0) / THIN_TAIL_PART + 1.0, 0.0, 1.0)
    full = float(worm.width_mm.max())
    head = np.where(part < 0.5, np.maximum(worm.width_mm, BLUNT_HEAD_WIDTH * full), full)
    return head * (1.0 - (1.0 - THIN_TAIL_WIDTH) * into_tail)


def rig_for(look: Look, *, noise: float = 3.0, seed: int = 0) -> Rig:
    """Return the chamber that the look is filmed in, 25.6 mm wide and high."""
    return Take(px_per_mm=look.px_per_mm, noise=noise, seed=seed).chamber


def film_worm(
    rig: Rig, worm: FoldedWorm, look: Look, skin: Skin | None = None
) -> Iterator[tuple[FilmFrame, Body]]:
    """Film a worm along its true midlines.

    Parameters
    ----------
    rig : Rig
        As of `rig_for`.
    worm : FoldedWorm
    look : Look
        All but the JPEG, which is the storage's.
    skin : Skin, optional
        What it wears; the look's own grey without one.

    Yields
    ------
    FilmFrame
        Stamp (from 0), picture and truth. The centroid is that of the area that the body covers;
        what it covers twice counts once.
    Body
        The true body in the picture, for what the truth's row leaves out.
    """
    specks = scattered(SPECKS, 9.5, *Filming().specks_mm, rig.optics.seed)
    for frame, body in enumerate(bodies(rig, worm, width_in(look, worm, skin))):
        strands = strands_over(body)
        if skin is None:
            view = shaded_view(rig, strands, look.shade)
        else:
            view = skinned_view(rig, body, skin)
        if look.debris:
            add_debris(view, rig, specks)
        stamp_ns = frame_stamp_ns(frame, worm.fps)
        truth = truth_of(rig, body, frame, stamp_ns, covered(strands))
        yield FilmFrame(stamp_ns, expose(rig, view, frame), truth), body


def bodies(rig: Rig, worm: FoldedWorm, width_mm: Floats) -> Iterator[Body]:
    """Yield the true body of each frame in the picture."""
    chamber = rig.chambers[0]
    for line in worm.midlines_mm:
        u, v = chamber.to_pixels(line[:, 0] * 1e-3, line[:, 1] * 1e-3)
        yield polyline_body(np.c_[u, v], width_mm * rig.px_per_mm)
