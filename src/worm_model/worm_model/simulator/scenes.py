"""Short films with truth, one for each thing that makes a worm in the rig hard to track."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
from numpy.typing import NDArray

from worm_model.simulator import crawling
from worm_model.simulator.film import FilmFrame, frame_stamp_ns
from worm_model.simulator.rig import Body, Rig, clear_view, expose, truth_of
from worm_model.simulator.rig import disturbances as seen
from worm_model.simulator.take import Take
from worm_model.simulator.worm import Walker, midlines_mm, rounded_body

FPS = 15.0
WORM_LENGTH_MM, WORM_WIDTH_MM = 20.0, 0.4
CRAWL_MM_S = 2.0
WHOLE_RIG_FPS = 2.5
RESTING_FPS = 0.5
BUMP_MM, BUMP_RAD = (0.15, -0.1), radians(0.8)
"""Shift (right, down) in the picture, in mm of the rig, and turn of a bumped camera."""

Lines = Iterable[NDArray[np.float64]]
Disturb = Callable[[NDArray[np.float32], Rig, Body, int], None]


def at_the_wall(take: Take) -> Iterator[FilmFrame]:
    """Film a head that slides along the wall most of the time, and hops."""
    return _film(take.chamber, _walk(take))


def along_the_wall(take: Take) -> Iterator[FilmFrame]:
    """Film a body that lies along the wall; now and then its head lifts off."""
    rig = take.chamber
    times = np.arange(take.frames) / FPS
    lines = (
        crawling.lie_along_the_wall(
            rig.radius_mm,
            WORM_LENGTH_MM,
            WORM_WIDTH_MM,
            1.2 + 0.7 * take.seed + CRAWL_MM_S / rig.radius_mm * t,
            max(0.0, 1.2 * sin(2.0 * pi * t / 4.0 - 1.0)),
        )
        for t in times
    )
    return _film(rig, lines)


def crossing(take: Take) -> Iterator[FilmFrame]:
    """Film a worm that crawls through loops; where it crosses itself it is darker."""
    return _film(_absorbing_twice(take.chamber), _crawl(take, crawling.looping_path, 2.0))


def crossing_of_one_shade(take: Take) -> Iterator[FilmFrame]:
    """Film the same, where two layers are as dark as one."""
    return _film(take.chamber, _crawl(take, crawling.looping_path, 2.0))


def coil(take: Take) -> Iterator[FilmFrame]:
    """Film a worm that crawls into a coil whose turns touch, stays, and backs out."""
    path = crawling.coiling_path(WORM_WIDTH_MM, WORM_LENGTH_MM + 12.0, WORM_LENGTH_MM)
    part = np.arange(take.frames) / take.frames
    pulled_in = np.clip(np.minimum(part / 0.5, (1.0 - part) / 0.35), 0.0, 1.0)
    heads = WORM_LENGTH_MM + 0.5 + 31.4 * pulled_in
    middle = (0.0, crawling.BOW_MM)
    lines = (
        _turned(line - middle, 0.9 * take.seed)
        for line in crawling.crawl(path, WORM_LENGTH_MM, heads)
    )
    return _film(_absorbing_twice(take.chamber), lines)


def glare(take: Take) -> Iterator[FilmFrame]:
    """Film two smooth bright spots that hide what passes under them."""

    def shine(view: NDArray[np.float32], rig: Rig, _body: Body, _frame: int) -> None:
        seen.add_glare(view, rig, (5.5, 0.5, 0.9), 230.0)
        seen.add_glare(view, rig, (-4.0, 4.0, 0.7), 230.0)

    return _film(take.chamber, _crawl(take, crawling.winding_path), shine)


def moving_glare(take: Take) -> Iterator[FilmFrame]:
    """Film glare of three sizes that comes a while after the start, and wanders over the worm."""

    def shine(view: NDArray[np.float32], rig: Rig, _body: Body, frame: int) -> None:
        t = frame / FPS - 1.0
        if t > 0:
            for turn, radius_mm, sd_mm in ((0.0, 5.0, 0.4), (2.1, 5.6, 0.7), (4.2, 4.4, 1.0)):
                angle = turn + take.seed - 0.15 * t
                seen.add_glare(
                    view, rig, (radius_mm * cos(angle), radius_mm * sin(angle), sd_mm), 230.0
                )

    return _film(take.chamber, _crawl(take, crawling.winding_path), shine)


def wall_bubbles(take: Take) -> Iterator[FilmFrame]:
    """Film a walk along a wall that two bubbles sit on; they stay."""
    rig = take.chamber
    places = [(0.7 + take.seed + turn, size) for turn, size in ((0.0, 0.9), (2.4, 0.6))]
    spots = [
        ((rig.radius_mm - size) * cos(angle), (rig.radius_mm - size) * sin(angle), size)
        for angle, size in places
    ]
    return _film(
        rig, _walk(take), lambda view, rig, _body, _frame: seen.add_bubbles(view, rig, spots)
    )


def carried_dirt(take: Take) -> Iterator[FilmFrame]:
    """Film a worm with a crumb stuck to its flank, a third of the way from its head."""

    def stick(view: NDArray[np.float32], rig: Rig, body: Body, _frame: int) -> None:
        here, ahead = body.at(np.array([0.33, 0.34]) * body.length_px)
        along = (ahead - here) / np.hypot(*(ahead - here))
        u, v = here + 0.55 * body.mean_width_px * np.array([-along[1], along[0]])
        x, y = rig.chambers[0].to_metres(float(u), float(v))
        seen.add_debris(view, rig, [(1e3 * x, 1e3 * y, 0.15)])

    return _film(take.chamber, _crawl(take, crawling.winding_path), stick)


def hair(take: Take) -> Iterator[FilmFrame]:
    """Film a chamber with a hair across it, and a short fibre that drifts."""
    turn = 0.4 + 0.9 * take.seed
    across = np.linspace(-9.0, 9.0, 60)
    lying = np.stack([across, 1.5 * np.sin(0.4 * across)], axis=1)

    def lie(view: NDArray[np.float32], rig: Rig, _body: Body, frame: int) -> None:
        seen.add_line(view, rig, _turned(lying, turn), 0.08, 0.45)
        fibre = lying[20:30] + np.array([0.04 * frame / FPS, 4.0])
        seen.add_line(view, rig, _turned(fibre, -turn), 0.06, 0.4)

    return _film(take.chamber, _crawl(take, crawling.winding_path), lie)


def hand(take: Take) -> Iterator[FilmFrame]:
    """Film a large dark shade that comes over a part of the chamber, stays, and leaves again."""

    def shade(view: NDArray[np.float32], rig: Rig, _body: Body, frame: int) -> None:
        part = frame / take.frames
        if 0.4 < part < 0.6:
            deep = round(0.3 * rig.width_px * min(1.0, 10.0 * min(part - 0.4, 0.6 - part)))
            view[:, :deep] *= np.float32(0.15)

    return _film(take.chamber, _crawl(take, crawling.winding_path), shade)


def light_off(take: Take) -> Iterator[FilmFrame]:
    """Film a lamp that is switched off for a second, and on again."""
    dark = round(0.5 * take.frames)

    def dim(view: NDArray[np.float32], _rig: Rig, _body: Body, frame: int) -> None:
        if dark <= frame < dark + FPS:
            view *= np.float32(0.03)

    return _film(take.chamber, _crawl(take, crawling.winding_path), dim)


def debris(take: Take) -> Iterator[FilmFrame]:
    """Film thirty dark specks in the chamber; the worm crawls over some of them."""
    specks = seen.scattered(30, 9.5, 0.06, 0.25, take.seed)
    return _film(
        take.chamber,
        _crawl(take, crawling.winding_path),
        lambda view, rig, _body, _frame: seen.add_debris(view, rig, specks),
    )


def bubbles(take: Take) -> Iterator[FilmFrame]:
    """Film six bubbles, dark rings with a bright middle, that drift slowly."""
    start = seen.scattered(6, 8.0, 0.4, 1.1, take.seed)

    def drift(view: NDArray[np.float32], rig: Rig, _body: Body, frame: int) -> None:
        moved = 0.05 * frame / FPS
        seen.add_bubbles(view, rig, [(x + moved, y - 0.5 * moved, r) for x, y, r in start])

    return _film(take.chamber, _crawl(take, crawling.winding_path), drift)


def reflection(take: Take) -> Iterator[FilmFrame]:
    """Film a worm that the wall mirrors, and of which the lid shows a faint second image."""

    def mirror(view: NDArray[np.float32], rig: Rig, body: Body, _frame: int) -> None:
        seen.add_reflection(view, rig, body, 0.3)
        seen.add_ghost(view, rig, body, (0.5, -0.7), 0.08)

    return _film(take.chamber, _walk(take), mirror)


def flicker(take: Take) -> Iterator[FilmFrame]:
    """Film by a lamp that jumps by up to 12 % from frame to frame."""

    def dim(view: NDArray[np.float32], _rig: Rig, _body: Body, frame: int) -> None:
        view *= np.float32(seen.flicker_gain(frame, 0.12, take.seed))

    return _film(take.chamber, _walk(take), dim)


def light_drift(take: Take) -> Iterator[FilmFrame]:
    """Film by a lamp that swings by 15 % within a minute."""

    def dim(view: NDArray[np.float32], _rig: Rig, _body: Body, frame: int) -> None:
        view *= np.float32(seen.drift_gain(frame / FPS, 0.15, 60.0))

    return _film(take.chamber, _walk(take), dim)


def uneven_light(take: Take) -> Iterator[FilmFrame]:
    """Film where the light falls to less than a half from one corner to the other."""
    rig = take.chamber
    return _film(
        replace(rig, optics=replace(rig.optics, light=170.0, gradient=(0.22, -0.2))), _walk(take)
    )


def bumped_camera(take: Take) -> Iterator[FilmFrame]:
    """Film with a camera that is shifted and turned a little halfway through (see `bumped`)."""
    before = take.chamber
    after = bumped(before)
    return _film(
        before, _walk(take), rig_at=lambda frame: after if 2 * frame >= take.frames else before
    )


def resting(take: Take) -> Iterator[FilmFrame]:
    """Film a worm that rests from the first frame on, for minutes, and then crawls off."""
    rest = round(0.8 * take.frames)
    heads = np.maximum(np.arange(take.frames) - rest, 0) * 0.3 + WORM_LENGTH_MM + 1.0
    lines = crawling.crawl(crawling.winding_path(10.0, 0.5 + take.seed), WORM_LENGTH_MM, heads)
    return _film(take.chamber, lines, fps=RESTING_FPS)


def there_and_back(take: Take) -> Iterator[FilmFrame]:
    """Film the way from chamber a through the passage into chamber b, and back."""
    path = crawling.smooth_path(
        crawling.WAY_TO_THE_EXIT + crawling.WAY_THROUGH_B + crawling.WAY_BACK
    )
    long = float(np.hypot(*np.diff(path, axis=0).T).sum())
    heads = np.linspace(WORM_LENGTH_MM + 0.1, long - 0.1, take.frames)
    return _film(take.whole_rig, crawling.crawl(path, WORM_LENGTH_MM, heads), fps=WHOLE_RIG_FPS)


def failed_attempt(take: Take) -> Iterator[FilmFrame]:
    """Film a head that comes to the exit, enters 3.5 mm deep, and withdraws, twice."""
    path = crawling.smooth_path(crawling.WAY_TO_THE_EXIT)
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T))]
    deepest = float(np.interp(13.5, path[:, 0], s))
    part = np.arange(take.frames) / take.frames
    to_the_exit = np.minimum(part / 0.4 - 1.0, 0.0) * (deepest - 5.0 - WORM_LENGTH_MM - 0.1)
    in_and_out = 2.5 * (1.0 + np.cos(4.0 * pi * (np.maximum(part, 0.4) - 0.4) / 0.6 + pi))
    heads = deepest - 5.0 + to_the_exit + in_and_out
    return _film(take.chamber, crawling.crawl(path, WORM_LENGTH_MM, heads))


SCENES: dict[str, Callable[[Take], Iterator[FilmFrame]]] = {
    scene.__name__: scene
    for scene in (
        at_the_wall,
        along_the_wall,
        crossing,
        crossing_of_one_shade,
        coil,
        glare,
        moving_glare,
        debris,
        carried_dirt,
        bubbles,
        wall_bubbles,
        hair,
        hand,
        light_off,
        reflection,
        flicker,
        light_drift,
        uneven_light,
        bumped_camera,
        resting,
        there_and_back,
        failed_attempt,
    )
}
"""Every scene by its name."""


def bumped(rig: Rig) -> Rig:
    """Return the rig as the bumped camera sees it: turned about the picture's middle, shifted."""
    middle = 0.5 * np.array([rig.width_px - 1, rig.height_px - 1])
    u, v = np.array(rig.centre_px) - middle
    c, s = cos(BUMP_RAD), sin(BUMP_RAD)
    shift = rig.px_per_mm * np.array(BUMP_MM)
    turned = middle + shift + np.array([c * u + s * v, c * v - s * u])
    return replace(
        rig,
        centre_px=(float(turned[0]), float(turned[1])),
        exit_rad=rig.exit_rad + BUMP_RAD,
    )


def _film(
    rig: Rig,
    lines_mm: Lines,
    disturb: Disturb | None = None,
    *,
    fps: float = FPS,
    rig_at: Callable[[int], Rig] | None = None,
) -> Iterator[FilmFrame]:
    """Film midlines given in the frame of chamber a."""
    for frame, line in enumerate(lines_mm):
        now = rig if rig_at is None else rig_at(frame)
        u, v = now.chambers[0].to_pixels(line[:, 0] * 1e-3, line[:, 1] * 1e-3)
        body = rounded_body(np.c_[u, v], WORM_WIDTH_MM * now.px_per_mm)
        view = clear_view(now, body)
        if disturb is not None:
            disturb(view, now, body, frame)
        stamp_ns = frame_stamp_ns(frame, fps)
        yield FilmFrame(stamp_ns, expose(now, view, frame), truth_of(now, body, frame, stamp_ns))


def _walk(take: Take) -> Lines:
    """Return a walk along the wall in contact for most of the time, at about `CRAWL_MM_S`."""
    walker = Walker(
        length_mm=WORM_LENGTH_MM,
        width_mm=WORM_WIDTH_MM,
        speed_mm_s=2.0 * CRAWL_MM_S,
        mean_slide_mm=4.0,
        mean_hop_mm=1.2,
        seed=take.seed,
    )
    return midlines_mm(walker, take.chamber.radius_mm, take.frames / FPS, FPS)


def _crawl(
    take: Take,
    path: Callable[[float, float], NDArray[np.float64]],
    faster: float = 1.0,
) -> Lines:
    """Return a crawl along a path, with a little peristalsis of the head."""
    times = np.arange(take.frames) / FPS
    heads = (
        WORM_LENGTH_MM + 1.0 + faster * CRAWL_MM_S * times + 0.15 * np.sin(2.0 * pi * times / 0.6)
    )
    return crawling.crawl(path(take.chamber.radius_mm, 1.1 * take.seed), WORM_LENGTH_MM, heads)


def _turned(line: NDArray[np.float64], angle_rad: float) -> NDArray[np.float64]:
    z = (line[:, 0] + 1j * line[:, 1]) * np.exp(1j * angle_rad)
    return np.stack([z.real, z.imag], axis=1)


def _absorbing_twice(rig: Rig) -> Rig:
    return replace(rig, optics=replace(rig.optics, crossings_absorb=True))
