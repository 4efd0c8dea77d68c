"""A worm that slides along a known path in the drawn rig: films for the tracker, with truth."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from worm_model.simulator.rig import Body, Optics, Rig, draw, truth_of
from worm_msgs_py import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

NOISY = Optics(noise=3.0, blur_px=1.0)
SMALL_RIG = Rig(
    width_px=512,
    height_px=512,
    px_per_mm=20.0,
    centre_px=(248.3, 259.6),
    exit_rad=np.radians(27.0),
    optics=NOISY,
)
LARGE_RIG = Rig(centre_px=(498.3, 517.6), exit_rad=np.radians(27.0), optics=NOISY)
TWO_CHAMBERS = Rig(
    width_px=1009,
    height_px=290,
    px_per_mm=13.0,
    centre_px=(147.3, 142.6),
    exit_width_mm=1.0,
    chamber_b=True,
    optics=NOISY,
)
FRAME_NS = 62_500_000


def wall_path(rig, width_px, *, excursions=5, depth=0.15):
    """Return a path that touches the wall and leaves it again and again, counter-clockwise."""
    phi = np.linspace(0, 3.2 * np.pi, 20000)
    touch = rig.radius_px - width_px / 2
    r = touch - depth * rig.radius_px * np.clip(np.sin(excursions * phi / 1.6), 0, None) ** 2
    return around(rig, phi, r)


def wavy_path(rig):
    """Return a path through the interior with bends much tighter than the wall."""
    phi = np.linspace(0, 4 * np.pi, 40000)
    r = rig.radius_px * (0.55 + 0.15 * np.sin(phi / 2) + 0.06 * np.sin(7 * phi))
    return around(rig, phi, r)


def radial_path(rig):
    """Return a straight path from deep inside the chamber out through its exit."""
    chamber = rig.chambers[0]
    x = np.linspace(-0.9, 1.6, 2000) * chamber.radius_m
    return np.stack(chamber.to_pixels(x, 0.02 * chamber.radius_m * np.sin(500 * x)), axis=1)


def around(rig, phi, r):
    u, v = rig.centre_px
    return np.stack([u + r * np.cos(phi), v - r * np.sin(phi)], axis=1)


def arc(curve):
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])


def crawl(path, length_px, width_px, heads_px):
    """Return a body whose head is at each of these arc lengths of the path."""
    s = arc(path)
    bodies = []
    for head in heads_px:
        grid = np.linspace(head, head - length_px, max(12, int(length_px / 4)))
        points = np.stack([np.interp(grid, s, path[:, k]) for k in (0, 1)], axis=1)
        bodies.append(Body.along(points, width_px))
    return bodies


def film(rig, bodies):
    """Return the picture of each body."""
    return [draw(rig, body, frame) for frame, body in enumerate(bodies)]


def track(pictures, **parameters):
    """Return the tracker and its frames, one per picture and in order."""
    tracker = Tracker(TrackerParameters(**parameters))
    given = []
    for frame, picture in enumerate(pictures):
        given += tracker.push(picture, frame * FRAME_NS)
    given += tracker.finish()
    assert [tracked.state.frame for tracked in given] == list(range(len(pictures)))
    assert [tracked.state.stamp_ns for tracked in given] == [
        frame * FRAME_NS for frame in range(len(pictures))
    ]
    return tracker, given


@dataclass
class Errors:
    """Distances from the truth, pixels, of the frames with a midline."""

    head: np.ndarray
    tail: np.ndarray
    centroid: np.ndarray
    midline: np.ndarray
    right_head: np.ndarray
    tracked: float


def errors(rig, bodies, given):
    """Compare with the truth; tips are compared with the nearer true end."""
    rows = []
    for body, tracked in zip(bodies, given, strict=True):
        state = tracked.state
        if state.status is not Status.TRACKED:
            continue
        truth = truth_of(rig, body, state.frame, state.stamp_ns)
        ends = np.array([[truth.head_u_px, truth.head_v_px], [truth.tail_u_px, truth.tail_v_px]])
        found = np.array([[p.u_px, p.v_px] for p in (state.head, state.tail)])
        straight, turned = (np.hypot(*(found[::way] - ends).T) for way in (1, -1))
        right = straight.sum() < turned.sum()
        head, tail = straight if right else turned
        off_u = state.centroid.u_px - truth.centroid_u_px
        off_v = state.centroid.v_px - truth.centroid_v_px
        points = np.stack([tracked.midline.u_px, tracked.midline.v_px], axis=1)
        away, _ = cKDTree(body.points_px).query(points)
        rows.append((head, tail, np.hypot(off_u, off_v), np.sqrt(np.mean(away**2)), right))
    table = np.array(rows, dtype=float)
    return Errors(*table[:, :4].T, table[:, 4].astype(bool), len(rows) / len(bodies))
