"""Draw the pictures of docs/statuses.md: each status where it truly occurs, and the head tip.

python docs/make_statuses.py

Every picture is a crop of a film of the synthetic rig, taken at a frame to which the tracker gave
that status; found midline in amber, head in blue.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_model.simulator.folded_worms import LOOKS, film_worm, read_folded_worms, rig_for
from worm_model.simulator.rig import Body, Optics, Rig, clear_view, draw, expose
from worm_model.simulator.rig.disturbances import add_glare
from worm_msgs_py import Status, TrackedFrame
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

Picture = NDArray[np.uint8]
OUT = Path(__file__).parent / "statuses"
WORMS = Path(__file__).parents[1] / "bags" / "source" / "folded_worms.npz"
RIG = Rig(
    width_px=512,
    height_px=512,
    px_per_mm=20.0,
    centre_px=(248.3, 259.6),
    exit_rad=np.radians(27.0),
    optics=Optics(noise=2.0, blur_px=1.0),
)
LENGTH, WIDTH, CROP, ZOOM = 150.0, 12.0, 216, 24
# The head is blue everywhere in the project. OpenCV's order: blue, green, red.
AMBER, BLUE, WHITE = (0, 159, 230), (178, 114, 0), (255, 255, 255)
PURPLE = (167, 121, 204)


def main() -> None:
    """Film, track, and draw the first frame of each status."""
    OUT.mkdir(exist_ok=True)
    for status, pictures in films().items():
        picture, tracked = first_of(status, pictures)
        crop = cropped(with_midline(picture, tracked), tracked)
        write(OUT / f"{status.label}.png", crop)
    write(OUT.parent / "head_tip.png", head_tip())


def films() -> dict[Status, list[Picture]]:
    """Return a film for each status in which it occurs."""
    worms = [crawling(k) for k in range(24)]
    seen = [draw(RIG, worm, k) for k, worm in enumerate(worms)]
    empty = [draw(RIG, None, k) for k in range(6)]
    cut = replace(RIG, width_px=470)
    blurred = replace(RIG, optics=replace(RIG.optics, blur_px=30.0))
    pipette = Body.along([(230.0, 450.0), (210.0, 300.0), (190.0, 200.0)], 46.0)
    fragment = Body.along(worms[-1].at(np.linspace(0.0, 40.0, 8)), WIDTH)
    pair = [Body.along(shifted(worms[-1], v), WIDTH) for v in (-30.0, 40.0)]
    return {
        Status.TRACKED: seen,
        Status.COILED: [draw(RIG, coil(), k) for k in range(3)],
        Status.NO_WORM: empty,
        Status.TOUCHES_BORDER: [draw(cut, leaving(k), k) for k in range(30)],
        Status.BAD_IMAGE: [*seen, np.full_like(seen[0], 255)],
        Status.NO_CHAMBER: [draw(blurred, worms[0], 0), *seen],
        Status.TOO_SMALL: [*seen, draw(RIG, fragment, 30)],
        Status.TOO_LARGE: [*seen, np.minimum(draw(RIG, worms[-1], 30), draw(RIG, pipette, 30))],
        Status.AMBIGUOUS: [*seen, *empty, np.minimum(*(draw(RIG, body, 30) for body in pair))],
        Status.BRIDGED: [glaring(worm, k, 0.5) for k, worm in enumerate(worms)],
        Status.FOLDED: [draw(RIG, looping(k), k) for k in range(60)],
        Status.LOOP_IN_DOUBT: filmed("4001", 110),
        Status.END_HIDDEN: [glaring(worm, k, 0.0) for k, worm in enumerate(worms)],
    }


def filmed(name: str, frames: int) -> list[Picture]:
    """Return the first pictures of a worm that folds much."""
    look, worm = LOOKS["coarse"], read_folded_worms(WORMS)[name]
    worm = replace(worm, midlines_mm=worm.midlines_mm[:frames])
    return [frame.picture for frame, _ in film_worm(rig_for(look, seed=int(name)), worm, look)]


def glaring(worm: Body, frame: int, at: float) -> Picture:
    """Return a frame with glare where a part of the last frame's worm will lie, 0 its head."""
    last = crawling(23)
    x, y = RIG.chambers[0].to_metres(*last.at(at * last.length_px))
    view = clear_view(RIG, worm)
    add_glare(view, RIG, (1e3 * x, 1e3 * y, 0.9), 230.0)
    return expose(RIG, view, frame)


def first_of(status: Status, pictures: Iterable[Picture]) -> tuple[Picture, TrackedFrame]:
    """Return the last frame of the film that has a status; the film must have one."""
    pictures = list(pictures)
    tracker = Tracker(TrackerParameters())
    given = [each for k, p in enumerate(pictures) for each in tracker.push(p, k * 50_000_000)]
    given += tracker.finish()
    found = [each for each in given if each.state.status is status]
    if not found:
        raise RuntimeError(f"no frame of its film is {status.label}: {tracker.statuses}")
    return pictures[found[-1].state.frame], found[-1]


def crawling(frame: int) -> Body:
    """Return a worm that winds through the chamber."""
    x = np.linspace(0.0, LENGTH, 40) - 3.0 * frame
    return Body.along(np.stack([150.0 - x, 255.0 + 16.0 * np.sin(x / 22.0)], axis=1), WIDTH)


def leaving(frame: int) -> Body:
    """Return a worm on its way out of the picture through the passage."""
    chamber = RIG.chambers[0]
    x = np.linspace(150.0 + 4.0 * frame, 4.0 * frame, 40) / chamber.px_per_m
    u, v = chamber.to_pixels(x, 0.0002 * np.sin(900 * x))
    return Body.along(np.stack([u, v], axis=1), WIDTH)


def looping(frame: int) -> Body:
    """Return a worm on its way round a loop, in which it crosses itself."""
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = 16.0 * np.stack([np.sin(turn), np.cos(turn) - 1.0], axis=1)
    before, after = [(-200.0, 0.0)], [(200.0, 0.0)]
    path = np.concatenate([before, circle, after]) + np.array([240.0, 255.0])
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    at = 190.0 + 2.5 * frame - np.linspace(0.0, LENGTH, 80)
    return Body.along(np.stack([np.interp(at, s, path[:, k]) for k in (0, 1)], axis=1), WIDTH)


def coil() -> Body:
    """Return a worm wound up so tightly that its turns touch, from the first frame on."""
    angle = np.linspace(0.5, 4.2 * np.pi, 80)
    radius = 0.85 * WIDTH * angle / (2.0 * np.pi) + 2.0
    around = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return Body.along(around + np.array([240.0, 250.0]), WIDTH)


def shifted(body: Body, down_px: float) -> NDArray[np.float64]:
    """Return a body's midline farther down in the picture."""
    return np.asarray(body.at(np.linspace(0.0, body.length_px, 40)) + np.array([0.0, down_px]))


def with_midline(picture: Picture, tracked: TrackedFrame) -> Picture:
    """Draw what was found."""
    colour = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    line = np.stack([tracked.midline.u_px, tracked.midline.v_px], axis=1)
    seen = np.ma.masked_invalid(line[:, 0])
    for part in np.ma.clump_unmasked(seen) if len(line) else ():
        stretch = np.rint(16 * line[part]).astype(np.int32)
        cv2.polylines(colour, [stretch], False, AMBER, 1, cv2.LINE_AA, 4)
    head = tracked.state.head
    if np.isfinite(head.u_px):
        at = (round(16 * head.u_px), round(16 * head.v_px))
        cv2.circle(colour, at, 48, BLUE, -1, cv2.LINE_AA, 4)
    return np.asarray(colour, np.uint8)


def cropped(picture: Picture, tracked: TrackedFrame) -> Picture:
    """Return the worm's surroundings; smaller if it is long, or all of the picture if not seen."""
    at = np.array([tracked.state.centroid.u_px, tracked.state.centroid.v_px])
    height, width = picture.shape[:2]
    if not np.isfinite(at).all():
        small = cv2.resize(picture, (CROP, CROP), interpolation=cv2.INTER_AREA)
        return np.asarray(small, np.uint8)
    line = np.stack([tracked.midline.u_px, tracked.midline.v_px], axis=1)
    far = np.nanmax(np.abs(line - at)) if len(line) else 0.0
    side = CROP if far < CROP / 2 else min(2 * round(far + 20.0), width, height)
    u, v = np.clip(np.rint(at).astype(int) - side // 2, 0, (width - side, height - side))
    crop = picture[v : v + side, u : u + side]
    return np.asarray(cv2.resize(crop, (CROP, CROP), interpolation=cv2.INTER_AREA), np.uint8)


def head_tip() -> Picture:
    """Return a head, magnified: the body's level, half of it, and the tip that was found."""
    pictures = [draw(RIG, crawling(k), k) for k in range(24)]
    picture, tracked = first_of(Status.TRACKED, pictures)
    head = np.array([tracked.state.head.u_px, tracked.state.head.v_px])
    half, margin = 16, 4
    within = np.array([tracked.midline.u_px[4], tracked.midline.v_px[4]])
    u, v = np.rint(within).astype(int) - half
    patch = picture[v : v + 2 * half, u : u + 2 * half]
    size = 2 * half * ZOOM
    large = cv2.resize(patch, (size, size), interpolation=cv2.INTER_NEAREST)
    view = cv2.cvtColor(large, cv2.COLOR_GRAY2BGR)

    def place(points: NDArray[np.float64]) -> NDArray[np.int32]:
        return np.rint(16 * ((points - (u, v) + 0.5) * ZOOM - 0.5)).astype(np.int32)

    level = cv2.resize(patch, (size, size), interpolation=cv2.INTER_CUBIC)
    level = cv2.GaussianBlur(level, (0, 0), 0.5 * ZOOM)
    edge = (int(np.median(picture[200:300, 330:400])) + int(patch.min()) + 4) // 2
    contours, _ = cv2.findContours(
        np.asarray(level < edge, np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    cv2.drawContours(view, contours, -1, PURPLE, 2, cv2.LINE_AA)
    line = np.stack([tracked.midline.u_px, tracked.midline.v_px], axis=1)
    cv2.polylines(view, [place(line)], False, AMBER, 2, cv2.LINE_AA, 4)
    true = crawling(tracked.state.frame).points_px[0]
    cv2.circle(view, tuple(place(true[None])[0].tolist()), 16 * 9, WHITE, 2, cv2.LINE_AA, 4)
    cv2.circle(view, tuple(place(head[None])[0].tolist()), 16 * 5, BLUE, -1, cv2.LINE_AA, 4)
    inner = slice(margin * ZOOM, -margin * ZOOM)  # the outline does not close along the edge
    return np.asarray(view[inner, inner], np.uint8)


def write(path: Path, picture: Picture) -> None:
    """Write a PNG; grey levels in steps of four, which nobody sees, halve its size."""
    cv2.imwrite(str(path), (picture // 4) * 4, [cv2.IMWRITE_PNG_COMPRESSION, 9])


if __name__ == "__main__":
    main()
