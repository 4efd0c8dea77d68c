"""The real films of other labs in other guises: what is told of a worm must not depend on them.

`python -m benchmarks.guises` tracks each film as it is, and mirrored, turned by a right angle,
enlarged, with more noise, backwards, with every other picture left out and from its 300th on. No
truth of a real coil is known; but where two guises tell a frame's midline, both for certain and
more than a width apart, one of them is wrong. Counted are these, and the frames to which head and
tail have changed places for certain though both are seen. Enlarged pictures are twice as large; the
noise has four grey levels.
"""

import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.midline_distance import frechet_px
from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY, TrackedFrame
from worm_tracker.detection.polarity import Polarity
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.bags.pictures import pictures_of_bag
from worm_tracker.tracker import Tracker

BAGS = Path(__file__).parents[1] / "bags"
NOISE, LATE = 4.0, 300
CROP_SIDE_PX, CROPS_PER_S = 140, 15


@dataclass(frozen=True)
class RealFilm:
    """Pictures of a real worm and their stamps; how bright it is, and how broad in pixels."""

    pictures: list[Picture]
    stamps_ns: list[int]
    polarity: Polarity
    width_px: float


def _same(points: Floats, _: tuple[int, int]) -> Floats:
    return points


@dataclass(frozen=True)
class Guise:
    """How a film is shown, and where a point of it (u, v) lies in the film of that shape."""

    picture: Callable[[Picture], Picture] = lambda picture: picture
    back: Callable[[Floats, tuple[int, int]], Floats] = _same
    frames: slice = field(default_factory=lambda: slice(None))


def _noisy(picture: Picture) -> Picture:
    rng = np.random.default_rng(int(picture.sum()))
    return np.clip(np.rint(picture + rng.normal(0, NOISE, picture.shape)), 0, 255).astype(np.uint8)


def _twice(picture: Picture) -> Picture:
    return np.asarray(cv2.resize(picture, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC))


GUISES = {
    "as it is": Guise(),
    "mirrored": Guise(
        lambda picture: np.ascontiguousarray(picture[:, ::-1]),
        lambda points, shape: np.c_[shape[1] - 1 - points[:, 0], points[:, 1]],
    ),
    "turned": Guise(
        lambda picture: np.ascontiguousarray(np.rot90(picture)),
        lambda points, shape: np.c_[shape[1] - 1 - points[:, 1], points[:, 0]],
    ),
    "enlarged": Guise(_twice, lambda points, _: (points + 0.5) / 2 - 0.5),
    "noisy": Guise(_noisy),
    "backwards": Guise(frames=slice(None, None, -1)),
    "every other": Guise(frames=slice(None, None, 2)),
    "from the 300th on": Guise(frames=slice(LATE, None)),
}


def wormtracer() -> RealFilm:
    """Return the film of coils."""
    pictures, stamps = zip(*pictures_of_bag(BAGS / "wormtracer"), strict=True)
    return RealFilm(list(pictures), list(stamps), Polarity.BRIGHT, 10.7)


def wormpose() -> RealFilm:
    """Return the crops that follow a worm, each in the middle of a canvas of one size."""
    pictures = []
    with zipfile.ZipFile(BAGS / "wormpose_crops.zip") as archive:
        for name in sorted(name for name in archive.namelist() if name.endswith(".png")):
            packed = np.frombuffer(archive.read(name), np.uint8)
            crop = np.asarray(cv2.imdecode(packed, cv2.IMREAD_GRAYSCALE))
            pictures.append(on_canvas(crop)[0])
    stamps = [round(k * 1e9 / CROPS_PER_S) for k in range(len(pictures))]
    return RealFilm(pictures, stamps, Polarity.DARK, 10.6)


def on_canvas(crop: Picture) -> tuple[Picture, tuple[int, int]]:
    """Return a crop in the middle of a canvas of water, and its corner (u, v) there."""
    rim = np.concatenate([crop[0], crop[-1], crop[:, 0], crop[:, -1]])
    canvas = np.full((CROP_SIDE_PX, CROP_SIDE_PX), round(float(np.median(rim))), np.uint8)
    v, u = ((CROP_SIDE_PX - size) // 2 for size in crop.shape)
    canvas[v : v + crop.shape[0], u : u + crop.shape[1]] = crop
    return canvas, (u, v)


@dataclass(frozen=True)
class Told:
    """What is told of a frame: a midline head first (n, 2), NaN where not, and how surely."""

    points: Floats
    certainty: float

    @property
    def is_certain(self) -> bool:
        """Whether it counts."""
        return self.certainty >= SURE_HEAD_CERTAINTY

    @property
    def is_whole(self) -> bool:
        """Whether all of the midline is told."""
        return len(self.points) > 0 and bool(np.isfinite(self.points).all())

    @property
    def ends(self) -> Floats:
        """Head and tail, (2, 2)."""
        return self.points[[0, -1]] if len(self.points) else np.full((2, 2), np.nan)


def tracked(film: RealFilm, guise: Guise) -> dict[int, Told]:
    """Track a film in a guise; return what is told of its frames, in its own coordinates."""
    parameters = TrackerParameters(no_chamber=True, polarity=film.polarity)
    tracker, given = Tracker(parameters), list[TrackedFrame]()
    numbers = range(len(film.pictures))[guise.frames]
    stamps = film.stamps_ns[:: abs(guise.frames.step or 1)]
    for number, stamp_ns in zip(numbers, stamps, strict=False):
        given += tracker.push(guise.picture(film.pictures[number]), stamp_ns)
    given += tracker.finish()
    shape = film.pictures[0].shape[:2]
    found = {}
    for number, frame in zip(numbers, given, strict=True):
        points = np.c_[frame.midline.u_px, frame.midline.v_px]
        points = guise.back(points, (shape[0], shape[1])) if len(points) else points
        found[number] = Told(points, frame.state.head_certainty)
    return found


def apart_px(one: Floats, other: Floats) -> float:
    """Return how far two whole midlines are apart, whichever way round they come (Fréchet)."""
    return min(frechet_px(one, other), frechet_px(one, other[::-1]))


def compared(one: dict[int, Told], other: dict[int, Told]) -> list[int]:
    """Return the frames whose midlines both guises tell, whole and for certain."""
    return [
        number
        for number in sorted(one.keys() & other.keys())
        if all(told.is_certain and told.is_whole for told in (one[number], other[number]))
    ]


def exchanged(told: dict[int, Told], width_px: float) -> list[int]:
    """Return the frames in which both ends are where the other was a frame before, for certain."""
    found = []
    for before, now in pairwise(told):
        if not (told[before].is_certain and told[now].is_certain):
            continue
        ends, were = told[now].ends, told[before].ends
        stay, change = (np.hypot(*(ends - at).T) for at in (were, were[::-1]))
        if change.max() < min(0.8 * width_px, stay.min()):
            found.append(now)
    return found


def main() -> None:
    """Print a table of the real films in all guises."""
    table = Table("film", "guise", "midlines", "certain", "compared", "contradict", "exchanged")
    for name, film in {"wormtracer": wormtracer(), "wormpose": wormpose()}.items():
        told = {guise: tracked(film, how) for guise, how in GUISES.items()}
        for guise, each in told.items():
            both, as_it_is = compared(told["as it is"], each), told["as it is"]
            apart = [
                k for k in both if apart_px(as_it_is[k].points, each[k].points) > film.width_px
            ]
            whole = sum(frame.is_whole for frame in each.values())
            certain = sum(frame.is_certain for frame in each.values())
            counts = f"{whole} of {len(each)}", certain, len(both)
            frames = apart, exchanged(each, film.width_px)
            table.add_row(name, guise, *map(str, (*counts, *frames)))
    Console(width=160).print(table)


if __name__ == "__main__":
    main()
