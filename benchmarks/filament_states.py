"""What the tracker would say of a simulated filament, without a picture: the truth as states."""

from collections.abc import Iterator
from math import pi

import numpy as np
from numpy.typing import NDArray

from worm_model.filament.trial import FilamentTrial
from worm_model.simulator.rig import Rig
from worm_msgs_py import BodyState, Geometry, Keypoint, Status, Where
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.units import MM_PER_M, NS_PER_S

Floats = NDArray[np.float64]
PX_PER_MM = 40.0
TENTH = 10
"""Part of the body over which the directions of head and tail are taken."""


def geometry_of(trial: FilamentTrial) -> Geometry:
    """Return the rig's true calibration."""
    rig = trial.rig
    return Rig(
        px_per_mm=PX_PER_MM,
        radius_mm=rig.radius_mm,
        exit_width_mm=rig.exit_width_mm,
        passage_length_mm=rig.passage_length_mm,
        chamber_b=True,
    ).geometry()


def centroids(midline_mm: Floats) -> Floats:
    """Return the centroid of the body at each frame, mm: every part counts by its length."""
    length = np.hypot(*np.diff(midline_mm, axis=1).transpose(2, 0, 1))[..., None]
    middle = 0.5 * (midline_mm[:, 1:] + midline_mm[:, :-1])
    return np.asarray((middle * length).sum(axis=1) / length.sum(axis=1), dtype=np.float64)


def lengths_mm(midline_mm: Floats) -> Floats:
    """Return the body's length at each frame."""
    return np.asarray(np.hypot(*np.diff(midline_mm, axis=1).transpose(2, 0, 1)).sum(axis=1))


def states_of_filament(trial: FilamentTrial) -> Iterator[BodyState]:
    """Yield the truth of every frame as the tracker would give it, in the nearer chamber."""
    midline, far_mm = trial.midline_mm, trial.rig.far_centre_mm
    chamber = geometry_of(trial).chambers[0]
    tenth = midline.shape[1] // TENTH
    head, tail, middle = midline[:, 0], midline[:, -1], centroids(midline)
    ways = (head - midline[:, tenth], head - middle, midline[:, -1 - tenth] - tail)
    in_b = head[:, 0] > 0.5 * far_mm
    columns = []
    for point, way in zip((head, middle, tail), ways, strict=True):
        u, v = chamber.to_pixels(point[:, 0] / MM_PER_M, point[:, 1] / MM_PER_M)
        own = np.where(in_b[:, None], [far_mm, 0.0] - point, point) / MM_PER_M
        yaw = np.arctan2(way[:, 1], way[:, 0]) + np.where(in_b, pi, 0.0)
        yaw = np.arctan2(np.sin(yaw), np.cos(yaw))
        columns.append(np.stack([u, v, own[:, 0], own[:, 1], yaw], axis=1).tolist())
    inside = np.hypot(*np.where(in_b[:, None], [far_mm, 0.0] - head, head).T) <= trial.rig.radius_mm
    length_mm, width_mm = lengths_mm(midline), trial.parameters.width_mm
    stamps_ns = np.rint(trial.t_s * NS_PER_S).astype(np.int64).tolist()
    for frame, stamp_ns in enumerate(stamps_ns):
        far = bool(in_b[frame])
        where = Where.CHAMBER_B if far else Where.CHAMBER_A
        yield BodyState(
            frame,
            stamp_ns,
            CHAMBER_B if far else CHAMBER_A,
            where if inside[frame] else Where.PASSAGE,
            Status.TRACKED,
            1,
            1.0,
            1.0,
            *(Keypoint(*column[frame]) for column in columns),
            length_mm[frame] * PX_PER_MM,
            width_mm * PX_PER_MM,
            length_mm[frame] / MM_PER_M,
            width_mm / MM_PER_M,
        )
