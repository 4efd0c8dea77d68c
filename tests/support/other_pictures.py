"""Pictures of a worm at the wall by other hands than `worm_model.simulator.rig`'s.

The tracker must not be good on the pictures of one renderer alone. Here bodies are discs along the
midline, drawn with many sub-pixels: blunt head, thin tail, a dark gut; the wall has a texture.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

SUB = 3  # sub-pixels to a side
FRACTION_BITS = 8


@dataclass
class Look:
    """How a picture looks; grey levels, px and mm."""

    size: int = 512
    px_per_mm: float = 20.0
    radius_mm: float = 10.0
    exit_deg: float = 33.0
    exit_width_mm: float = 2.0
    width_mm: float = 0.42
    wall: float = 45.0
    worm: float = 70.0
    texture: float = 4.0
    blur_px: float = 0.8
    noise: float = 3.0
    jpeg_quality: int | None = None
    centre_px: np.ndarray = field(default_factory=lambda: np.array([258.3, 253.4]))


def wall_following(look, frames, step_mm=0.2, length_mm=20.0):
    """Midlines (mm, y up, head first) that follow the wall and lift off it now and then."""
    angle = np.linspace(0.0, 4 * np.pi, 4000)
    clear = look.radius_mm - 0.45 * look.width_mm - 0.02
    radius = clear - np.maximum(0.0, np.sin(2.3 * angle))
    path = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T))]
    for frame in range(frames):
        head = length_mm + 1.0 + step_mm * frame
        at = np.linspace(head, head - length_mm, 300)
        yield np.stack([np.interp(at, s, path[:, k]) for k in (0, 1)], axis=1)


def taken(look, midline_mm, rng):
    """Return a picture, and the outermost points of head and tail in it, px."""
    shape = (look.size * SUB, look.size * SUB)
    scale = look.px_per_mm * SUB
    centre = (look.centre_px + 0.5) * SUB - 0.5
    v = np.linspace(0.0, 3.0, shape[0])[:, None]
    u = np.linspace(0.0, 2.0, shape[1])[None]
    view = blend(wall_of(look, shape, rng), 205.0 + 10.0 * np.sin(v) * np.cos(u), water_of(look))
    line = centre + midline_mm * [scale, -scale]
    s = np.linspace(0.0, 1.0, len(line))
    girth = np.minimum(0.9 + 0.1 * s / 0.15, 0.35 + 0.65 * (1.0 - s) / 0.3).clip(max=1.0)
    girth *= look.width_mm * scale
    shade = look.worm - 25.0 * discs(shape, line[30:-30], girth[30:-30] / 3.0)
    view = blend(view, np.minimum(shade, view), discs(shape, line, girth))
    picture = cv2.resize(view.astype(np.float32), (look.size,) * 2, interpolation=cv2.INTER_AREA)
    picture = cv2.GaussianBlur(picture, (0, 0), look.blur_px)
    picture += look.noise * rng.standard_normal(picture.shape)
    picture = np.clip(np.rint(picture), 0, 255).astype(np.uint8)
    if look.jpeg_quality is not None:
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, look.jpeg_quality])
        picture = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    tips = [tip(line[:4], girth[0]), tip(line[:-5:-1], girth[-1])]
    return picture, [(point + 0.5) / SUB - 0.5 for point in tips]


def tip(end, girth):
    outwards = end[0] - end[-1]
    return end[0] + outwards / np.hypot(*outwards) * girth / 2.0


def blend(under, over, share):
    return under + share * (over - under)


def discs(shape, centres, diameters):
    mask = np.zeros(shape, np.uint8)
    one = 1 << FRACTION_BITS
    for (u, v), diameter in zip(centres * one, diameters * one / 2.0, strict=True):
        at, radius = (round(u), round(v)), round(diameter)
        cv2.circle(mask, at, radius, 255, cv2.FILLED, cv2.LINE_AA, FRACTION_BITS)
    return mask / 255.0


def wall_of(look, shape, rng):
    coarse = rng.standard_normal((look.size // 8, look.size // 8)).astype(np.float32)
    return look.wall + look.texture * cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC)


def water_of(look):
    """Return 1 in the chamber and in the passage, 0 in the wall."""
    scale = look.px_per_mm * SUB
    centre = (look.centre_px + 0.5) * SUB - 0.5
    radius, half = look.radius_mm * scale, look.exit_width_mm * scale / 2.0
    mask = discs((look.size * SUB,) * 2, centre[None], np.array([2.0 * radius]))
    angle = np.radians(look.exit_deg)
    along, across = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    ends = ((0.8, -half), (3.0, -half), (3.0, half), (0.8, half))
    corners = [centre + part * radius * along + side * across for part, side in ends]
    passage = np.zeros(mask.shape, np.uint8)
    points = np.rint(np.array(corners) * (1 << FRACTION_BITS)).astype(np.int32)
    cv2.fillPoly(passage, [points], 255, cv2.LINE_AA, FRACTION_BITS)
    return np.maximum(mask, passage / 255.0)
