"""What else the camera sees: dirt, bubbles, glare, a mirror image, and a lamp that is not steady.

Each function changes a view (mean grey levels, before the noise) in place. Places and sizes are
given in the frame of chamber a and in millimetres, so that a bumped camera moves them with the rig.
"""

from dataclasses import dataclass
from math import ceil, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.rig.body import Body
from worm_model.simulator.rig.drawing import worm_coverage
from worm_model.simulator.rig.geometry import Rig

View = NDArray[np.float32]
Spot = tuple[float, float, float]
"""x_mm, y_mm, radius_mm."""


@dataclass(frozen=True, slots=True)
class DirtLook:
    """What dirt and bubbles do to the light.

    Attributes
    ----------
    speck_transmission, bubble_rim_transmission : float
        Part of the light that is let through.
    bubble_rim_part : float
        Thickness of a bubble's dark rim, as a part of its radius.
    bubble_middle_grey, bubble_middle_per_radius : float
        Grey levels that the middle is brighter by, and how many times that reaches into a radius.
    """

    speck_transmission: float = 0.35
    bubble_rim_transmission: float = 0.35
    bubble_rim_part: float = 0.22
    bubble_middle_grey: float = 30.0
    bubble_middle_per_radius: float = 2.5


DIRT = DirtLook()


def scattered(
    count: int, within_mm: float, smallest_mm: float, largest_mm: float, seed: int
) -> list[Spot]:
    """Return spots at random places, uniform over a disc around the chamber's centre."""
    random = np.random.default_rng([seed, 2])
    radius = within_mm * np.sqrt(random.random(count))
    angle = random.uniform(-pi, pi, count)
    size = random.uniform(smallest_mm, largest_mm, count)
    return list(
        zip(
            *(a.tolist() for a in (radius * np.cos(angle), radius * np.sin(angle), size)),
            strict=True,
        )
    )


class Stain(NamedTuple):
    """A spot as it is seen: where, the share of the light that it lets pass, and what it adds."""

    here: tuple[slice, slice]
    passes: View | None
    adds: View | None

    def draw(self, view: View) -> None:
        """Change a view in place."""
        part = view[self.here]
        if self.passes is not None:
            part *= self.passes
        if self.adds is not None:
            part += self.adds


def speck_stain(rig: Rig, speck: Spot, look: DirtLook = DIRT) -> Stain:
    """Return a round dark speck."""
    here, distance, radius = _part_around(rig, speck)
    covered = np.clip((radius - distance) / _edge_width_px(rig) + 0.5, 0.0, 1.0)
    passes = 1.0 - (1.0 - look.speck_transmission) * covered
    return Stain(here, passes.astype(np.float32), None)


def bubble_stain(rig: Rig, bubble: Spot, look: DirtLook = DIRT) -> Stain:
    """Return a bubble: a dark rim, where light is refracted away, around a bright middle."""
    here, distance, radius = _part_around(rig, bubble)
    rim = 0.5 * look.bubble_rim_part * radius
    off_rim = np.abs(distance - (radius - rim))
    covered = np.clip((rim - off_rim) / _edge_width_px(rig) + 0.5, 0.0, 1.0)
    middle = np.exp(-((look.bubble_middle_per_radius * distance / radius) ** 2))
    return Stain(
        here,
        (1.0 - (1.0 - look.bubble_rim_transmission) * covered).astype(np.float32),
        (look.bubble_middle_grey * middle).astype(np.float32),
    )


def glare_stain(rig: Rig, spot: Spot, strength: float) -> Stain:
    """Return a smooth bright spot, `strength` grey levels in its middle; `spot` holds its sd."""
    here, distance, sd = _part_around(rig, spot, reach=4.0)
    adds = (strength * np.exp(-0.5 * (distance / sd) ** 2)).astype(np.float32)
    return Stain(here, None, adds)


def add_debris(view: View, rig: Rig, specks: list[Spot]) -> None:
    """Darken round specks."""
    for speck in specks:
        speck_stain(rig, speck).draw(view)


def add_bubbles(view: View, rig: Rig, bubbles: list[Spot]) -> None:
    """Draw bubbles."""
    for bubble in bubbles:
        bubble_stain(rig, bubble).draw(view)


def add_glare(view: View, rig: Rig, spot: Spot, strength: float) -> None:
    """Add a smooth bright spot, `strength` grey levels in its middle; `spot` holds its sd."""
    glare_stain(rig, spot, strength).draw(view)


def add_line(
    view: View,
    rig: Rig,
    points_mm: NDArray[np.float64],
    width_mm: float,
    transmission: float,
) -> None:
    """Darken a thread, such as a hair or a fibre, along points (n, 2) in the chamber's frame."""
    u, v = rig.chambers[0].to_pixels(points_mm[:, 0] * 1e-3, points_mm[:, 1] * 1e-3)
    thread = Body.along(np.stack([u, v], axis=1), max(width_mm * rig.px_per_mm, 1.0))
    u0, v0, covered = worm_coverage(thread)
    top, left = max(v0, 0), max(u0, 0)
    covered = covered[top - v0 :, left - u0 :][: rig.height_px - top, : rig.width_px - left]
    here = np.s_[top : top + covered.shape[0], left : left + covered.shape[1]]
    view[here] *= (1.0 - (1.0 - transmission) * covered).astype(np.float32)


def add_reflection(view: View, rig: Rig, body: Body, strength: float) -> None:
    """Darken the wall where it mirrors the worm: at R + d for a part at R − d, up to 2 mm deep.

    Parameters
    ----------
    view : ndarray
        Changed in place.
    rig : Rig
        The rig; the mirror is chamber a's wall.
    body : Body
        The worm.
    strength : float
        Share of the light that the mirror image takes away.
    """
    centre = np.array(rig.centre_px)
    outward = body.points_px - centre
    radius = np.hypot(*outward.T)
    near = radius > rig.radius_px - 2.0 * rig.px_per_mm
    edges = np.flatnonzero(np.diff(np.r_[False, near, False]))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if last - first < 8:
            continue
        part = np.s_[first:last]
        factor = (2.0 * rig.radius_px - radius[part]) / radius[part]
        image = Body.along(centre + outward[part] * factor[:, None], body.mean_width_px)
        here, covered, in_wall = _image(rig, image)
        view[here] *= (1.0 - strength * covered * in_wall).astype(np.float32)


def add_ghost(
    view: View, rig: Rig, body: Body, shift_mm: tuple[float, float], strength: float
) -> None:
    """Darken the water by a faint second image of the worm, as a lid reflects it.

    Parameters
    ----------
    view : ndarray
        Changed in place.
    rig : Rig
        The rig.
    body : Body
        The worm.
    shift_mm : tuple of float
        The image's place beside the worm, right and down in the picture.
    strength : float
        Share of the light that it takes away.
    """
    image = Body.along(body.points_px + rig.px_per_mm * np.array(shift_mm), body.mean_width_px)
    here, covered, in_wall = _image(rig, image)
    view[here] *= (1.0 - strength * covered * (1.0 - in_wall)).astype(np.float32)


def flicker_gain(frame: int, depth: float, seed: int) -> float:
    """Return the lamp's brightness in this frame, uniform in 1 ± depth."""
    return float(1.0 + depth * np.random.default_rng([seed, 3, frame]).uniform(-1.0, 1.0))


def drift_gain(time_s: float, depth: float, period_s: float) -> float:
    """Return the brightness of a lamp that swings slowly, in 1 ± depth."""
    return 1.0 + depth * sin(2.0 * pi * time_s / period_s)


def _image(
    rig: Rig, image: Body
) -> tuple[tuple[slice, slice], NDArray[np.float32], NDArray[np.float64]]:
    """Return a part of the picture, how far the image covers it, and how far it is wall."""
    u0, v0, covered = worm_coverage(image)
    top, left = max(v0, 0), max(u0, 0)
    covered = covered[top - v0 :, left - u0 :][: rig.height_px - top, : rig.width_px - left]
    u = np.arange(left, left + covered.shape[1], dtype=np.float64)
    v = np.arange(top, top + covered.shape[0], dtype=np.float64)[:, np.newaxis]
    in_wall = np.clip(rig.wall_distance_px(u, v) + 0.5, 0.0, 1.0)
    here = np.s_[top : top + covered.shape[0], left : left + covered.shape[1]]
    return here, covered, in_wall


def _edge_width_px(rig: Rig) -> float:
    """Width of a drawn edge: the pixel and the blur."""
    return 1.0 + 2.0 * rig.optics.blur_px


def _part_around(
    rig: Rig, spot: Spot, reach: float = 1.0
) -> tuple[tuple[slice, slice], NDArray[np.float64], float]:
    """Return the part of the picture around a spot, the distances from it, and its radius, px."""
    u, v = rig.chambers[0].to_pixels(spot[0] * 1e-3, spot[1] * 1e-3)
    radius = spot[2] * rig.px_per_mm
    half = ceil(reach * radius + 4.0)
    top, left = max(round(v) - half, 0), max(round(u) - half, 0)
    bottom, right = max(round(v) + half + 1, top), max(round(u) + half + 1, left)
    here = np.s_[top : min(bottom, rig.height_px), left : min(right, rig.width_px)]
    rows = np.arange(here[0].start, max(here[0].stop, here[0].start)) - v
    columns = np.arange(here[1].start, max(here[1].stop, here[1].start)) - u
    return here, np.hypot(columns, rows[:, np.newaxis]), radius
