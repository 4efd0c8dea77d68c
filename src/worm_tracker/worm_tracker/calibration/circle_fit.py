"""The wall's circle in a picture, below a pixel: rays, robust consensus, least squares."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage, optimize

from worm_msgs_py.arrays import Floats, Floats32, Picture
from worm_msgs_py.intervals import SD_OF_MAD


@dataclass(frozen=True, slots=True)
class CircleFitSettings:
    """What is believed to be the wall of a chamber."""

    coarse_side_px: int = 256
    """Longer side of the reduced picture in which chambers are looked for: a worm closes there."""
    least_radius_px: float = 25.0
    """A smaller circle is no chamber in which a worm can be tracked."""
    least_step_over_water: float = 0.25
    """Least step from water to wall, as a part of the water's brightness."""
    least_step_grey: float = 12.0
    """Least step from water to wall in grey levels, well above the noise of any camera."""
    least_coverage: float = 0.45
    """Least part of the circle on which the wall must be seen: the exit and a worm hide some."""
    most_radius_ratio_off: float = 0.1
    """How much two chambers of one rig may differ in radius, relatively."""
    blanked_over_radius: float = 1.1
    """What of a chamber is taken out of the picture to look for the next one, in radii."""
    fit_rounds: int = 3
    """Times that the edge is measured about the circle found so far."""
    coarse_tolerance_over_side: float = 0.004
    least_coarse_tolerance_px: float = 2.0
    """Distance from the circle of rays' edges that agree with it, before it is known to a pixel."""
    fine_tolerance_px: float = 0.5
    """The same after: a worm along the wall is an edge too, but not on the same circle."""
    least_water_over_median: float = 0.7
    """Brightness before the wall below which a worm lies along it."""
    most_residual_px: float = 0.7
    most_residual_over_radius: float = 0.004
    """RMS distance of the edges from the circle beyond both of which the wall is none."""
    coarse_rays: int = 720
    fine_rays: int = 1440
    """Rays on which the wall is looked for, before the circle is known to a pixel, and after."""
    coarse_smoothing_px: float = 1.5
    """Before: noise is no step."""
    fine_step_px: float = 0.25
    """Distance of the samples on a ray after."""
    fine_reach_over_radius: float = 0.03
    fine_reach_px: tuple[float, float] = (6.0, 14.0)
    """How far to either side of the circle a ray goes then, within bounds: beyond the blur."""
    fine_smoothing_steps: float = 3.0
    """Along it, in its steps."""
    plateau_rays: int = 31
    """Rays over which the brightness of water and wall is steadied."""
    consensus_draws: int = 600
    """Circles through three edges each that are tried: a third of the edges may be the wall's."""
    most_off_guess_px: float = 2.0
    """Edges farther from the circle that most agree with are not used, unless too few are left."""
    soft_residual_px: float = 0.3
    """Distance from which on an edge pulls less than with its square."""
    most_off_fit_sd: float = 3.0
    least_sd_px: float = 0.05
    """Edges farther from the fit than so many robust deviations, of so much at least, are dropped
    at the end."""


@dataclass(frozen=True, slots=True)
class FittedCircle:
    """A circle fitted to the wall's inner edge.

    Attributes
    ----------
    u, v, radius : float
        Pixels.
    residual : float
        RMS distance of the edge points from the circle, pixels.
    centre_sd, radius_sd : float
        One standard deviation of the fit, pixels.
    coverage : float
        Fraction of the full circle on which the edge was seen.
    """

    u: float
    v: float
    radius: float
    residual: float = float("nan")
    centre_sd: float = float("nan")
    radius_sd: float = float("nan")
    coverage: float = 1.0


def find_circles(
    picture: Picture, settings: CircleFitSettings, most: int = 2
) -> list[FittedCircle]:
    """Find the chambers in a back-lit picture, the largest first.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        Bright water, dark walls.
    settings : CircleFitSettings
    most : int
        Number of chambers to look for; they must be of about equal size.

    Returns
    -------
    list of FittedCircle
        Those that stand up to the tests of contrast, coverage and residual; may be empty.
    """
    shrink = max(1.0, max(picture.shape) / settings.coarse_side_px)
    small = cv2.resize(picture, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA)
    threshold, bright = cv2.threshold(small, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    if np.ptp(small) < settings.least_step_grey or threshold <= 0:
        return []
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))
    bright = cv2.morphologyEx(bright, cv2.MORPH_CLOSE, kernel)  # a worm must not split the disc
    if bright.all():
        return []
    found: list[FittedCircle] = []
    for _ in range(most + 1):
        depth = cv2.distanceTransform(bright, cv2.DIST_L2, 5)
        _, inscribed, _, (x, y) = cv2.minMaxLoc(depth)
        if inscribed * shrink < settings.least_radius_px / 2 or len(found) == most:
            break
        inside = ((x + 0.5) * shrink - 0.5, (y + 0.5) * shrink - 0.5)
        circle = fit_circle(picture, inside, settings)
        blank = circle or FittedCircle(x * shrink, y * shrink, inscribed * shrink)
        centre = (round(blank.u / shrink), round(blank.v / shrink))
        around = round(settings.blanked_over_radius * blank.radius / shrink) + 1
        cv2.circle(bright, centre, around, 0, -1)
        most_off = settings.most_radius_ratio_off
        if circle and (not found or abs(circle.radius / found[0].radius - 1) < most_off):
            found.append(circle)
    return found


def fit_circle(
    picture: Picture, inside: tuple[float, float], settings: CircleFitSettings
) -> FittedCircle | None:
    """Fit the wall around a point inside a chamber; None where there is no circular wall.

    The wall's edge is where the brightness falls through half its step from water to wall. A worm
    along the wall, the exit and debris are outliers to the consensus and to the robust fit.
    """
    points = _coarse_edges(picture, inside, settings)
    tolerance = settings.coarse_tolerance_over_side * max(picture.shape)
    tolerance = max(settings.least_coarse_tolerance_px, tolerance)
    guess = _consensus(points, tolerance, settings)
    for _ in range(settings.fit_rounds):
        if guess is None or not _plausible(guess, picture, settings):
            return None
        edges = _fine_edges(picture, guess, settings)
        if len(edges) < settings.least_coverage * settings.fine_rays:
            return None
        start = _consensus(edges, settings.fine_tolerance_px, settings) or guess
        guess = _least_squares(edges, start, settings)
    return guess if guess is not None and _is_wall(guess, picture, settings) else None


def refit_circle(
    picture: Picture, circle: FittedCircle, settings: CircleFitSettings
) -> FittedCircle | None:
    """Fit the wall once more where it was; None where it is not there any more.

    Costs a twentieth of `fit_circle`, which looks for a wall that may be anywhere.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
    circle : FittedCircle
        Right to a pixel.
    settings : CircleFitSettings
    """
    edges = _fine_edges(picture, circle, settings)
    if len(edges) < settings.least_coverage * settings.fine_rays:
        return None
    fitted = _least_squares(edges, circle, settings)
    return fitted if _is_wall(fitted, picture, settings) else None


def _is_wall(circle: FittedCircle, picture: Picture, settings: CircleFitSettings) -> bool:
    """Tell whether so much of a circle is seen, and so well, that it is a wall."""
    most = max(settings.most_residual_px, settings.most_residual_over_radius * circle.radius)
    seen = circle.coverage >= settings.least_coverage and circle.residual <= most
    return seen and _plausible(circle, picture, settings)


def _plausible(circle: FittedCircle, picture: Picture, settings: CircleFitSettings) -> bool:
    """Tell whether a circle's centre is in the picture and its size can be one in view."""
    h, w = picture.shape
    inside = 0 <= circle.u < w and 0 <= circle.v < h
    return inside and bool(settings.least_radius_px <= circle.radius <= max(h, w))


def radial_profiles(
    picture: Picture, circle: FittedCircle, radii: Floats, angles: Floats
) -> Floats32:
    """Sample the picture on a polar grid about the circle's centre.

    Returns
    -------
    ndarray of float32, shape (angles, radii)
        NaN outside the picture. Angles grow counter-clockwise as seen.
    """
    u = circle.u + radii[None] * np.cos(angles)[:, None]
    v = circle.v - radii[None] * np.sin(angles)[:, None]
    sampled = cv2.remap(
        picture.astype(np.float32),
        u.astype(np.float32),
        v.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(float("nan"),) * 4,
    )
    return np.asarray(sampled, np.float32)


def _coarse_edges(
    picture: Picture, inside: tuple[float, float], settings: CircleFitSettings
) -> Floats:
    """Return, on each ray, the point of the steepest fall from bright to dark."""
    reach = int(np.hypot(*picture.shape))
    angles = np.linspace(0, 2 * np.pi, settings.coarse_rays, endpoint=False)
    smooth = np.asarray(cv2.GaussianBlur(picture, (0, 0), settings.coarse_smoothing_px), np.uint8)
    around = FittedCircle(inside[0], inside[1], 0.0)
    radii = np.arange(0.0, reach)
    profiles = radial_profiles(smooth, around, radii, angles)
    with np.errstate(invalid="ignore"):
        step = profiles[:, :-4] - profiles[:, 4:]
        level = np.maximum(profiles[:, :-4], 1.0)
        high = (step > settings.least_step_grey) & (step > settings.least_step_over_water * level)
        step = np.where(high, step, 0.0)
    best = np.argmax(step, axis=1)
    seen = step[np.arange(len(best)), best] > 0
    r = best[seen] + 2.0
    return np.stack(
        [inside[0] + r * np.cos(angles[seen]), inside[1] - r * np.sin(angles[seen])], axis=1
    )


def _consensus(
    points: Floats, tolerance: float, settings: CircleFitSettings
) -> FittedCircle | None:
    """Return the circle through three points that most points agree with (RANSAC, seeded)."""
    if len(points) < settings.coarse_rays // 4:
        return None
    rng = np.random.default_rng(0)
    triples = points[rng.integers(0, len(points), (settings.consensus_draws, 3))]
    a, b, c = triples[:, 0], triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0]
    det = 2 * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    usable = np.abs(det) > 1.0
    a, b, c, det = a[usable], b[usable], c[usable], det[usable]
    bb, cc = (b**2).sum(1), (c**2).sum(1)
    x = (c[:, 1] * bb - b[:, 1] * cc) / det
    y = (b[:, 0] * cc - c[:, 0] * bb) / det
    radii = np.hypot(x, y)
    centres = a + np.stack([x, y], axis=1)
    distance = np.hypot(*(points[None] - centres[:, None]).transpose(2, 0, 1))
    votes = (np.abs(distance - radii[:, None]) < tolerance).sum(1)
    if not len(votes) or votes.max() < settings.least_coverage * settings.coarse_rays / 2:
        return None
    best = int(np.argmax(votes))
    return FittedCircle(float(centres[best, 0]), float(centres[best, 1]), float(radii[best]))


def _fine_edges(picture: Picture, circle: FittedCircle, settings: CircleFitSettings) -> Floats:
    """Return the half-height points of the wall around a circle that is right to a few pixels."""
    fine = settings.fine_step_px
    reach = settings.fine_reach_over_radius * circle.radius
    reach = float(np.clip(reach, *settings.fine_reach_px))
    radii = circle.radius + np.arange(-reach, reach + 0.01, fine)
    angles = np.linspace(0, 2 * np.pi, settings.fine_rays, endpoint=False)
    profiles = radial_profiles(picture, circle, radii, angles)
    profiles = ndimage.gaussian_filter1d(
        profiles, settings.fine_smoothing_steps, axis=1, mode="nearest"
    )
    quarter = len(radii) // 5
    water = _plateau(profiles[:, :quarter], settings)
    wall = _plateau(profiles[:, -quarter:], settings)
    half = (water + wall) / 2
    with np.errstate(invalid="ignore"):
        above = profiles > half[:, None]
        ok = water - wall > settings.least_step_grey
        ok &= water - wall > settings.least_step_over_water * water
    ok &= water > settings.least_water_over_median * np.median(water)
    falls = above[:, :-1] & ~above[:, 1:]
    ok &= (falls.sum(1) == 1) & np.isfinite(profiles).all(1)
    row, k = np.flatnonzero(ok), np.argmax(falls[ok], axis=1)
    high, low = profiles[row, k], profiles[row, k + 1]
    r = radii[k] + fine * (high - half[row]) / (high - low)
    return np.stack(
        [circle.u + r * np.cos(angles[row]), circle.v - r * np.sin(angles[row])], axis=1
    )


def _plateau(part: Floats32, settings: CircleFitSettings) -> Floats32:
    """Return the plateau's brightness on each ray, steadied over neighbouring rays."""
    means = np.nan_to_num(part.mean(1))
    level = ndimage.median_filter(means, settings.plateau_rays, mode="wrap")
    return np.asarray(level, np.float32)


def _least_squares(
    points: Floats, guess: FittedCircle, settings: CircleFitSettings
) -> FittedCircle:
    """Fit a circle robustly; outliers are dropped at the end."""

    def residuals(p: Floats, use: Floats) -> Floats:
        return np.asarray(np.hypot(use[:, 0] - p[0], use[:, 1] - p[1]) - p[2])

    start = np.array([guess.u, guess.v, guess.radius])
    near = np.abs(residuals(start, points)) < settings.most_off_guess_px
    points = points[near] if near.sum() > settings.least_coverage * len(points) else points
    fit = optimize.least_squares(
        residuals, start, loss="soft_l1", f_scale=settings.soft_residual_px, args=(points,)
    )
    off = np.abs(residuals(fit.x, points))
    sd_px = max(SD_OF_MAD * float(np.median(off)), settings.least_sd_px)
    keep = points[off < settings.most_off_fit_sd * sd_px]
    fit = optimize.least_squares(residuals, fit.x, args=(keep,))
    rms = float(np.sqrt(np.mean(fit.fun**2)))
    jacobian = np.asarray(fit.jac)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * rms**2
    sd = np.sqrt(np.diag(covariance))
    return FittedCircle(
        float(fit.x[0]),
        float(fit.x[1]),
        float(fit.x[2]),
        residual=rms,
        centre_sd=float(np.hypot(sd[0], sd[1])),
        radius_sd=float(sd[2]),
        coverage=len(keep) / settings.fine_rays,
    )
