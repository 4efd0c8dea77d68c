"""The exit of a chamber: the gap in its wall, its direction and its width, below a pixel."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from worm_msgs_py.arrays import Floats, Mask, Picture
from worm_tracker.calibration.circle_fit import FittedCircle, radial_profiles


@dataclass(frozen=True, slots=True)
class ExitFitSettings:
    """What gap in a wall is believed to be an exit, and how well it is measured."""

    least_width_px: float = 3.0
    """A narrower gap is a scratch."""
    most_width_over_radius: float = 1.4
    """Widest exit that is looked for: the paper's widest is half a radius."""
    common_edge_sd_px: float = 0.03
    """What all radii have in common of an edge's error: that of the half-height. Measured on
    simulated pictures with noise of 3 grey levels and a blur of 0.6 to 2 px."""
    water_over_radius: float = 0.97
    water_before_that_px: float = 6.0
    """Where the water before an exit is taken: clear of the wall's blur, near enough to be lit as
    the exit is. A worm there falsifies W."""
    first_beyond_wall_px: float = 3.0
    circles: int = 6
    circle_step_over_radius: float = 0.0125
    circle_step_px: tuple[float, float] = (1.0, 5.0)
    """Circles on which the passage's edges are taken: from beyond the wall's blur on, as far apart
    as the picture is fine, within bounds."""
    wall_quantile: float = 0.2
    """Of the brightness on these circles, that is taken for the wall's at first: an exit takes a
    small part of them."""
    angle_smoothing_rays: float = 1.5
    """Along a circle, in rays, two of which are a pixel of the wall."""

    def water_radius_px(self, wall_radius_px: float) -> float:
        """Return the radius at which the water before an exit is taken."""
        return self.water_over_radius * wall_radius_px - self.water_before_that_px

    def passage_radii_px(self, wall_radius_px: float) -> Floats:
        """Return the radii, just outside the wall, at which the passage's edges are taken."""
        step = float(np.clip(self.circle_step_over_radius * wall_radius_px, *self.circle_step_px))
        first = self.first_beyond_wall_px
        return wall_radius_px + np.arange(first, first + self.circles * step, step)


@dataclass(frozen=True, slots=True)
class FittedExit:
    """The straight passage that opens into a chamber.

    Attributes
    ----------
    direction_rad : float
        From the chamber's centre to the middle of the gap, counter-clockwise from the right.
    width_px : float
        Distance of the passage's walls.
    direction_sd_rad, width_sd_px : float
        One standard deviation of each.
    """

    direction_rad: float
    width_px: float
    direction_sd_rad: float
    width_sd_px: float


def find_exit(
    picture: Picture, circle: FittedCircle, settings: ExitFitSettings
) -> FittedExit | None:
    """Find the widest gap in a chamber's wall; None where the wall is closed.

    On circles just outside the wall the passage is bright. Its two edges at each radius r lie at
    asin(W/2r) to either side of its axis, wherever the half-height between water and wall is
    passed; the axis and the width are the means over the radii.
    """
    radii = settings.passage_radii_px(circle.radius)
    n = int(np.ceil(2 * np.pi * circle.radius * 2))
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    outside = radial_profiles(picture, circle, radii, angles)
    water = np.nanmedian(radial_profiles(picture, circle, np.array([0.93 * circle.radius]), angles))
    wall = np.nanquantile(outside, settings.wall_quantile)
    if not np.isfinite(water) or water - wall < 1:
        return None
    half = float(water + wall) / 2
    filled = np.where(np.isfinite(outside), outside, np.float32(wall)).astype(np.float64)
    smooth = ndimage.gaussian_filter1d(filled, settings.angle_smoothing_rays, axis=0, mode="wrap")
    start, stop = _widest_gap(smooth.mean(1) > half, angles)
    if stop <= start:
        return None
    near = settings.water_radius_px(circle.radius)
    half = _local_half(picture, circle, near, smooth, (start, stop), angles)
    found = [_gap_edges(smooth[:, k], half, start, stop, angles) for k in range(len(radii))]
    pairs = np.array([pair for pair in found if pair is not None]).reshape(-1, 2)
    used = radii[[pair is not None for pair in found]]
    if len(pairs) < 2:
        return None
    middle = pairs.mean(1)
    widths = 2 * used * np.sin((pairs[:, 1] - pairs[:, 0]) / 2)
    width = float(np.median(widths))
    if not settings.least_width_px <= width <= settings.most_width_over_radius * circle.radius:
        return None
    direction = float(np.median(middle))
    spread = float(np.std(middle, ddof=1)) / np.sqrt(len(middle))
    common = settings.common_edge_sd_px / np.sqrt(2) / circle.radius
    sd = float(np.hypot(np.hypot(spread, common), circle.centre_sd / circle.radius))
    spread_px = float(np.std(widths, ddof=1)) / np.sqrt(len(widths))
    width_sd = float(np.hypot(spread_px, np.sqrt(2) * settings.common_edge_sd_px))
    return FittedExit(float(np.arctan2(np.sin(direction), np.cos(direction))), width, sd, width_sd)


def _widest_gap(open_: Mask, angles: Floats) -> tuple[int, int]:
    """Return first and last index of the widest bright arc, unwrapped; (0, 0) where none."""
    if not open_.any() or open_.all():
        return 0, 0
    turn = int(np.argmin(open_))  # start at a place where the wall is closed
    rolled = np.roll(open_, -turn)
    # A worm in the exit parts the gap: bridge dark stretches shorter than the bright ones around.
    labels, count = ndimage.label(rolled)
    spans = [(int(s[0].start), int(s[0].stop)) for s in ndimage.find_objects(labels)[:count]]
    merged = [spans[0]]
    for span in spans[1:]:
        last = merged[-1]
        if span[0] - last[1] < (span[1] - span[0]) + (last[1] - last[0]):
            merged[-1] = (last[0], span[1])
        else:
            merged.append(span)
    start, stop = max(merged, key=lambda span: span[1] - span[0])
    return start + turn, stop - 1 + turn


def _local_half(
    picture: Picture,
    circle: FittedCircle,
    water_radius: float,
    rings: Floats,
    gap: tuple[int, int],
    angles: Floats,
) -> float:
    """Return the half-height between the water and the wall on either side of a gap."""
    start, stop = gap
    n, width = len(angles), stop - start
    inside = angles[np.arange(start, stop + 1) % n]
    water = np.nanmedian(radial_profiles(picture, circle, np.array([water_radius]), inside))
    reach = max(16, width // 2)
    beside = [np.arange(start - reach, start - 8), np.arange(stop + 9, stop + reach + 1)]
    wall = np.median(rings[np.concatenate(beside) % n])
    return float(water + wall) / 2


def _gap_edges(
    ring: Floats, half: float, start: int, stop: int, angles: Floats
) -> tuple[float, float] | None:
    """Return the two angles at which one circle's brightness passes the half-height."""
    n, step = len(ring), float(angles[1] - angles[0])
    reach = max(8, (stop - start) // 3)
    index = np.arange(start - reach, stop + reach + 1)
    values = ring[index % n]
    above = values > half
    rises = np.flatnonzero(~above[:-1] & above[1:])
    falls = np.flatnonzero(above[:-1] & ~above[1:])
    if not len(rises) or not len(falls) or falls[-1] <= rises[0]:
        return None
    k, m = int(rises[0]), int(falls[-1])
    low = index[k] + (half - values[k]) / (values[k + 1] - values[k])
    high = index[m] + (values[m] - half) / (values[m] - values[m + 1])
    return float(low * step), float(high * step)
