"""Whether the camera or the rig has been bumped: the walls' edges, looked at in every frame."""

from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Floats32, Mask, Picture
from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.intervals import SD_OF_MAD


@dataclass(frozen=True, slots=True)
class MotionDetectorSettings:
    """Where the walls' edges are looked at, and when they have moved."""

    circle_points: int = 64
    passage_points: int = 12
    """Points on a chamber's wall, and on each wall of a passage."""
    reach_px: int = 6
    """How far to either side of the edge the brightness is read, at steps of a pixel."""
    least_move_px: float = 0.25
    """Least outward move of a point that counts; five standard deviations where these are more."""
    least_part_moved: float = 0.2
    """Part of a wall's points that must have moved outwards. A translation by d moves a third of
    the circle outwards by d/2 or more; a turn moves half of a passage's points."""
    least_part_in_view: float = 0.3
    """Part of a wall's points that must be in view for anything to be said of it."""
    worm_water_over_expected: float = 0.7
    """Brightness of the water before a point below which the worm is there."""
    darkest_contrast: float = 0.9
    """Brightness of the wall over the water's from which there is no edge to look at."""
    shift_fits: int = 3
    least_points_of_shift: float = 6.0
    """How often a shift is fitted, without the points that are off; and how many points must tell
    of its part in any direction."""


@dataclass(frozen=True, eq=False, slots=True)
class _Wall:
    """Points of one wall among all points watched."""

    first: int
    last: int


class MotionDetector:
    """Tells whether a rig has moved in the picture, by its walls.

    What is bright beyond a wall cannot be the worm, which only makes things darker: a wall has
    moved where enough of its points have moved outwards. That is blind to nothing that a bump can
    do, because the other side of a chamber moves outwards where one moves inwards.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The picture that the rig was found in.
    geometry : Geometry
        The rig.
    settings : MotionDetectorSettings
    """

    def __init__(
        self,
        picture: Picture,
        geometry: Geometry,
        settings: MotionDetectorSettings,
    ) -> None:
        self._settings = settings
        points, self._normals, self._walls = _wall_points(geometry, settings)
        normals = self._normals
        t = np.arange(-settings.reach_px, settings.reach_px + 1, dtype=np.float64)
        u = (points[:, :1] + normals[:, :1] * t).astype(np.float32)
        v = (points[:, 1:] + normals[:, 1:] * t).astype(np.float32)
        h, w = picture.shape
        self._in_view = ((u >= 0) & (v >= 0) & (u <= w - 1) & (v <= h - 1)).all(1)
        self._all_in_view = bool(self._in_view.all())
        self._u, self._v = u, v
        profiles = self._profiles(picture)
        self._water = profiles[:, :2].mean(1)
        wall = profiles[:, -2:].mean(1)
        usual = float(np.median(self._water[self._in_view])) if self._in_view.any() else 1.0
        clear = self._in_view & (self._water > settings.worm_water_over_expected * usual)
        # Where the worm covers a point now, its light is taken to be that of the others.
        self._water = np.where(clear, self._water, usual)
        self._dark = float(np.median(wall[clear] / self._water[clear])) if clear.any() else 1.0
        self._start, valid = self._edges(picture)
        self._start[~valid] = np.nan
        known = self._start[valid]
        spread = float(np.median(np.abs(known - np.median(known)))) if len(known) else 0.0
        self._least = max(settings.least_move_px, 0.5 * SD_OF_MAD * spread)

    def moved(self, picture: Picture) -> bool:
        """Tell whether the rig is elsewhere in the picture than it was."""
        settings = self._settings
        if self._dark > settings.darkest_contrast:
            return False
        edges, valid = self._edges(picture)
        known = ~np.isnan(self._start)
        seen = valid & known
        outward = valid & (edges - self._start > self._least)
        for wall in self._walls:
            here = slice(wall.first, wall.last)
            count = np.count_nonzero(seen[here])
            if count < settings.least_part_in_view * (wall.last - wall.first):
                continue
            if np.count_nonzero(outward[here]) >= settings.least_part_moved * count:
                return True
        if not known.all():
            new = valid & ~known
            self._start[new] = edges[new]
        return False

    def shift(self, picture: Picture) -> Floats | None:
        """Return how far the rig is from where it was, (u, v) in pixels; None if too little tells.

        By a tenth of a pixel and better, up to half of `reach_px`. A turn is not told.
        """
        edges, valid = self._edges(picture)
        outward = edges - self._start
        seen = valid & np.isfinite(outward)
        shift: Floats = np.zeros(2)
        for _ in range(self._settings.shift_fits):
            normals = self._normals[seen]
            tells = normals.T @ normals
            if np.linalg.eigvalsh(tells)[0] < self._settings.least_points_of_shift:
                return None
            shift = np.asarray(np.linalg.solve(tells, normals.T @ outward[seen]))
            off = np.abs(outward - self._normals @ shift)
            most = max(3 * SD_OF_MAD * float(np.median(off[seen])), self._settings.least_move_px)
            seen = valid & (off < most)  # the worm before a wall makes it seem to be elsewhere
        return shift

    def _profiles(self, picture: Picture) -> Floats32:
        sampled = cv2.remap(picture, self._u, self._v, cv2.INTER_LINEAR)
        return sampled.astype(np.float32)

    def _edges(self, picture: Picture) -> tuple[Floats, Mask]:
        """Return how far the light reaches along each normal, and which points can be judged."""
        profiles = self._profiles(picture)
        water = (profiles[:, 0] + profiles[:, 1]) / 2
        relative = water / self._water
        gain = _middle_value(relative if self._all_in_view else relative[self._in_view])
        valid = self._in_view & (relative > self._settings.worm_water_over_expected * gain)
        bright = profiles / np.maximum(water, 1.0)[:, None]
        bright -= self._dark
        bright /= 1 - self._dark
        np.minimum(np.maximum(bright, 0.0, out=bright), 1.1, out=bright)
        return bright.sum(1, dtype=np.float64), valid


def _middle_value(values: Floats32) -> float:
    """Return the (upper) median; NumPy's own takes many times as long for so few values."""
    return float(np.sort(values)[len(values) // 2]) if len(values) else 1.0


def _wall_points(
    geometry: Geometry, settings: MotionDetectorSettings
) -> tuple[Floats, Floats, list[_Wall]]:
    """Return points on all walls, their outward normals, and which wall has which."""
    points, normals, walls, count = [], [], [], 0
    for chamber in geometry.chambers:
        for place, normal in (_circle_and_normals(chamber, settings), _passage(chamber, settings)):
            if not len(place):
                continue
            points.append(place)
            normals.append(normal)
            walls.append(_Wall(count, count + len(place)))
            count += len(place)
    return np.concatenate(points), np.concatenate(normals), walls


def _circle_and_normals(
    chamber: Chamber, settings: MotionDetectorSettings
) -> tuple[Floats, Floats]:
    angles = np.linspace(0, 2 * np.pi, settings.circle_points, endpoint=False)
    if np.isfinite(chamber.exit_width_m):
        half = chamber.exit_width_m / 2 * chamber.px_per_m
        gap = np.arcsin(min(1.0, half / chamber.radius_px))
        gap += 2 * settings.reach_px / chamber.radius_px
        off = np.angle(np.exp(1j * (angles - chamber.exit_rad)))
        angles = angles[np.abs(off) > gap]
    normals = np.stack([np.cos(angles), -np.sin(angles)], axis=1)
    centre = np.array([chamber.centre_u_px, chamber.centre_v_px])
    return centre + chamber.radius_px * normals, normals


def _passage(chamber: Chamber, settings: MotionDetectorSettings) -> tuple[Floats, Floats]:
    """Return points on both walls; none where they are too near each other to be told apart."""
    half = chamber.exit_width_m / 2 * chamber.px_per_m
    if not half > settings.reach_px / 2:
        return np.empty((0, 2)), np.empty((0, 2))
    # Where the passage's walls meet the circle there is no edge across the normal.
    count, first = settings.passage_points, 2 * settings.reach_px
    x = chamber.radius_px + np.linspace(first, 0.5 * chamber.radius_px, count)
    x = np.concatenate([x, x]) / chamber.px_per_m
    side = np.repeat([1.0, -1.0], count)
    u, v = chamber.to_pixels(x, side * chamber.exit_width_m / 2)
    far_u, far_v = chamber.to_pixels(x, side * (chamber.exit_width_m / 2 + 1 / chamber.px_per_m))
    return np.stack([u, v], axis=1), np.stack([far_u - u, far_v - v], axis=1)
