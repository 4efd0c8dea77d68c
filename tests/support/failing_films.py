"""Films that the tracker gets nothing from, each for one reason that a person could mend."""

from collections.abc import Callable, Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.rig import Body, Optics
from worm_model.simulator.rig.drawing import worm_coverage

SIDE_PX = 320
FRAMES = 40
FRAME_NS = 40_000_000
Picture = NDArray[np.uint8]


def crawling(frame: int, phase: float = 0.0) -> NDArray[np.float64]:
    """Return the midline (u, v), px, of a worm that winds its way through the picture."""
    s = np.linspace(0.0, 110.0, 120) - 0.8 * frame
    u = 215.0 - s
    return np.stack([u, 160.0 + 22.0 * np.sin(s / 21.0 + phase)], axis=1)


def water(
    frame: int,
    bodies: list[Body],
    *,
    light: float = 190.0,
    gradient: tuple[float, float] = (0.05, -0.04),
    worm_transmission: float = 0.35,
    noise: float = 2.0,
    side_px: int = SIDE_PX,
) -> NDArray[np.float32]:
    """Return worms in clear water without walls, before rounding."""
    optics = Optics(light=light, gradient=gradient, noise=noise)
    field = optics.light_field(side_px, side_px)
    view = field.copy()
    for body in bodies:
        u0, v0, part = worm_coverage(body, margin_px=4)
        top, left = max(v0, 0), max(u0, 0)
        part = part[top - v0 :, left - u0 :][: side_px - top, : side_px - left]
        here = np.s_[top : top + part.shape[0], left : left + part.shape[1]]
        seen = cv2.GaussianBlur(part, (0, 0), 0.9)
        view[here] -= np.float32(1.0 - worm_transmission) * seen * field[here]
    return view + optics.noise_of_frame(frame, view.shape)


def exposed(view: NDArray[np.float32]) -> Picture:
    return np.clip(np.rint(view), 0, 255).astype(np.uint8)


def worm(frame: int, width_px: float = 7.0) -> Body:
    return Body.along(crawling(frame), width_px)


def seen_well(frame: int) -> Picture:
    return exposed(water(frame, [worm(frame)]))


def bright_on_dark(frame: int) -> Picture:
    return np.asarray(cv2.bitwise_not(seen_well(frame)), np.uint8)


def overexposed(frame: int, light: float = 235.0) -> Picture:
    """The lamp is too bright: where its diffuser is thin the water is white, in patches."""
    coarse = np.random.default_rng(7).standard_normal((24, 24)).astype(np.float32)
    patches = cv2.resize(coarse, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_CUBIC)
    return exposed(water(frame, [worm(frame)], light=light, noise=4.0) * (1 + 0.12 * patches))


def barely_overexposed(frame: int) -> Picture:
    return overexposed(frame, 215.0)


def underexposed(frame: int) -> Picture:
    return exposed(water(frame, [worm(frame)], light=2.5, noise=0.6))


def six_worms(frame: int) -> Picture:
    bodies = []
    for k in range(6):
        turn = 2 * np.pi * k / 6
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        line = (crawling(frame, 0.7 * k) - 160.0) * 0.5
        bodies.append(Body.along((line + np.array([45.0, 0.0])) @ rotation.T + 160.0, 5.0))
    return exposed(water(frame, bodies))


def in_a_well(frame: int) -> Picture:
    """A round well whose dark rim is in view, water inside and out."""
    view = water(frame, [Body.along((crawling(frame) - 160) * 0.7 + 160, 6.0)])
    rim = np.zeros(view.shape, np.uint8)
    cv2.circle(rim, (161 * 16, 158 * 16), 128 * 16, 255, 9, cv2.LINE_AA, 4)
    return exposed(view * (1.0 - 0.7 * cv2.GaussianBlur(rim, (0, 0), 1.0) / 255.0))


def faint(frame: int) -> Picture:
    """A thin worm that a poor codec has left of single dark pixels."""
    view = water(frame, [], noise=1.5)
    line = crawling(frame) + np.random.default_rng(frame).normal(0.0, 0.9, (120, 2))
    u, v = np.rint(line[::2]).astype(int).T
    view[v, u] -= 40.0
    return exposed(view)


def dithered(frame: int) -> Picture:
    """A thin pale worm as a film of two grey levels has it: one pixel in five is dark."""
    view = water(frame, [], noise=1.5)
    u0, v0, part = worm_coverage(worm(frame, 4.0), margin_px=4)
    dark = np.random.default_rng(frame).random(part.shape) < 0.2 * part
    view[v0 : v0 + part.shape[0], u0 : u0 + part.shape[1]] -= np.float32(60.0) * dark
    return exposed(view)


def in_an_open_well(frame: int) -> Picture:
    """The same, the rim broken by a reflection: an object with two ends."""
    picture = in_a_well(frame)
    cv2.ellipse(picture, (161, 158), (128, 128), 0, 20, 32, 196, 16)
    return picture


def pictures(of: Callable[[int], Picture], frames: int = FRAMES) -> Iterator[tuple[Picture, int]]:
    for frame in range(frames):
        yield of(frame), frame * FRAME_NS
