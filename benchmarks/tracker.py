"""What the tracker costs: a frame through the core beside plain pipelines, in turn, in one run.

The pictures are decoded beforehand, OpenCV has one thread, and it is that thread's time that is
taken, so that what else the machine does hardly counts. The ways take turns, a block of frames
each, so that a machine whose speed drifts slows all of them alike, and none of them finds the
caches as another one has left them.

- *tracker*: the core, from a picture to its state, tips and midline below a pixel.
- *plain OpenCV*: what is usually written, in tutorials as in worm trackers (Tierpsy smooths by a
  median and closes gaps four times), each step in its smallest size. The frame is smoothed, because
  noise would fray the outline; the difference from a fixed background is cut at a threshold; an
  opening takes specks off and a closing mends gaps (3 × 3 pixels, all of them); the largest outline
  is smoothed, its ends are found by its curvature, and the midline lies half-way between its two
  sides, both taken at equal steps.
- *bare OpenCV*: the least that gives a midline at all, with nothing against noise: no smoothing of
  the picture or of the outline, no opening or closing.
- *scikit-image skeleton*: `skeletonize` on the crop around the largest outline of the bare mask.
- *floor*: one absolute difference and threshold over the frame; anything that touches every pixel
  costs as much.
"""

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from statistics import fmean, median
from time import thread_time
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy import ndimage
from skimage.morphology import skeletonize
from threadpoolctl import threadpool_limits

from worm_model.simulator.rig import Body, Optics, Rig, draw
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.bags.pictures import pictures_of_bag
from worm_tracker.tracker import Tracker

Picture = NDArray[np.uint8]
Points = NDArray[np.float64]

BAG = Path(__file__).parents[1] / "bags" / "larva"
FRAMES = 300
WARM_UP = 30
"""First frames, in which the tracker calibrates and learns the background: not timed."""
BLOCK = 30
"""Frames that go through one way before the next way takes its turn."""
FRAME_NS = 33_333_333
THRESHOLD = 40
CROSS = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
MIDLINE_POINTS = 65


class Spent(NamedTuple):
    """Seconds a frame; some of the tracker's work is not done in every frame."""

    median: float
    mean: float


def larva() -> list[Picture]:
    """Return the first pictures of the larva bag."""
    return [picture for picture, _ in islice(pictures_of_bag(BAG), FRAMES)]


def slender_worm() -> list[Picture]:
    """Return a drawn film: a worm of 20 mm, 0.4 mm wide, winds through the chamber."""
    rig = Rig(centre_px=(498.3, 517.6), exit_rad=0.47, optics=Optics(noise=3.0, blur_px=1.0))
    phi = np.linspace(0, 4 * np.pi, 40000)
    r = rig.radius_px * (0.55 + 0.15 * np.sin(phi / 2) + 0.06 * np.sin(7 * phi))
    u, v = rig.centre_px
    path = np.stack([u + r * np.cos(phi), v - r * np.sin(phi)], axis=1)
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    pictures = []
    for frame in range(FRAMES):
        at = 800.0 + 3 * frame - np.linspace(0, 800, 200)
        points = np.stack([np.interp(at, s, path[:, k]) for k in (0, 1)], axis=1)
        pictures.append(draw(rig, Body.along(points, 16.0), frame))
    return pictures


def bare_mask(picture: Picture, ground: Picture) -> Picture:
    """Return what differs from the background."""
    return cv2.threshold(cv2.absdiff(picture, ground), THRESHOLD, 255, cv2.THRESH_BINARY)[1]


def clean_mask(picture: Picture, ground: Picture) -> Picture:
    """Return what differs from the background, without noise, specks and gaps."""
    mask = bare_mask(cv2.GaussianBlur(picture, (3, 3), 0), ground)
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, CROSS)
    return cv2.morphologyEx(mask, cv2.MORPH_CLOSE, CROSS)


def largest_contour(mask: Picture) -> NDArray[np.int32]:
    """Return the outline with the largest area, shape (n, 2)."""
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return max(contours, key=cv2.contourArea)[:, 0]


def smoothed(outline: NDArray[np.int32]) -> Points:
    """Return the outline without the stairs of its pixels."""
    window = len(outline) // 96  # half of one of 24 segments a side
    return ndimage.uniform_filter1d(outline.astype(np.float64), window, axis=0, mode="wrap")


def middle(outline: Points) -> Points:
    """Return the line half-way between the two sides of an outline; ends are its sharpest turns."""
    n = len(outline)
    step = max(2, n // 20)
    ahead = np.roll(outline, -step, axis=0) - outline
    back = np.roll(outline, step, axis=0) - outline
    cosine = (ahead * back).sum(1) / np.hypot(*ahead.T) / np.hypot(*back.T)
    first = int(np.argmax(cosine))
    far = np.abs((np.arange(n) - first + n // 2) % n - n // 2) > n // 4
    second = int(np.argmax(np.where(far, cosine, -1.0)))
    i, j = sorted((first, second))
    one, other = outline[i : j + 1], np.concatenate([outline[j:], outline[: i + 1]])[::-1]
    return (equal_steps(one) + equal_steps(other)) / 2


def equal_steps(line: Points) -> Points:
    """Return points at equal steps along a line."""
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.linspace(0, s[-1], MIDLINE_POINTS)
    return np.stack([np.interp(at, s, x) for x in line.T], axis=1)


def skeleton(picture: Picture, ground: Picture) -> NDArray[np.bool_]:
    """Return the skeleton of the crop around the largest outline."""
    mask = bare_mask(picture, ground)
    u, v, width, height = cv2.boundingRect(largest_contour(mask))
    return skeletonize(mask[v : v + height, u : u + width] > 0)


def timed(pictures: list[Picture], tracker: Tracker) -> dict[str, list[float]]:
    """Return the seconds that each way takes for every frame."""
    ground = np.max(pictures[:: len(pictures) // 12], axis=0)  # the worm is dark, and has moved
    ways: dict[str, Callable[[Picture, int], object]] = {
        "tracker": lambda picture, k: tracker.push(picture, k * FRAME_NS),
        "plain OpenCV": lambda picture, _: middle(
            smoothed(largest_contour(clean_mask(picture, ground)))
        ),
        "bare OpenCV": lambda picture, _: middle(
            largest_contour(bare_mask(picture, ground)).astype(np.float64)
        ),
        "scikit-image skeleton": lambda picture, _: skeleton(picture, ground),
        "floor": lambda picture, _: bare_mask(picture, ground),
    }
    spent: dict[str, list[float]] = {name: [] for name in ways}
    for first in range(0, len(pictures), BLOCK):
        for name, way in ways.items():
            for k in range(first, min(first + BLOCK, len(pictures))):
                began = thread_time()
                way(pictures[k], k)
                spent[name].append(thread_time() - began)
    return spent


def measure(pictures: list[Picture]) -> dict[str, Spent]:
    """Return the seconds a frame of each way."""
    with threadpool_limits(1):
        spent = timed(pictures, Tracker(TrackerParameters()))
    return {
        name: Spent(median(seconds[WARM_UP:]), fmean(seconds[WARM_UP:]))
        for name, seconds in spent.items()
    }


def main() -> None:
    """Print a table for each film."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        for title, film in (("larva bag", larva()), ("worm of 20 mm", slender_worm())):
            spent = measure(film)
            table = Table("way", "ms a frame (median)", "of plain", "of bare", "mean", title=title)
            plain, bare = (spent[f"{which} OpenCV"].median for which in ("plain", "bare"))
            for name, (middle_s, mean_s) in spent.items():
                times = f"{middle_s * 1e3:.3f}", f"{mean_s * 1e3:.3f}"
                ratios = f"{middle_s / plain:.2f}", f"{middle_s / bare:.2f}"
                table.add_row(name, times[0], *ratios, times[1])
            Console().print(table)
    finally:
        cv2.setNumThreads(threads)


if __name__ == "__main__":
    main()
