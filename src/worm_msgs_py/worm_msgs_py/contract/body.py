"""One frame's worm: three keypoints, a midline, and how far to trust them."""

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from worm_msgs_py.contract.chamber import Geometry
from worm_msgs_py.contract.frames import CAMERA, Where
from worm_msgs_py.contract.status import Status

KEYPOINTS = ("head", "centroid", "tail")
SURE_HEAD_CERTAINTY = 0.9
"""A head that is less certain is shown as doubtful, and left out of numbers by default."""


@dataclass(frozen=True, slots=True)
class Keypoint:
    """A point of the body, in the picture and in the chamber.

    Attributes
    ----------
    u_px, v_px : float
        Picture coordinates, u right and v down, whole numbers at pixel centres.
    x_m, y_m : float
        Coordinates in the state's `frame_id`, metres; NaN where no scale is known.
    yaw_rad : float
        Heading, counter-clockwise from the x axis of `frame_id`. Head: along the midline's first
        tenth, outward. Centroid: from the centroid to the head. Tail: along the midline's last
        tenth, towards the head. With ``frame_id == "camera_optical_frame"`` (y down) a growing yaw
        turns clockwise as seen in the picture.
    """

    u_px: float = nan
    v_px: float = nan
    x_m: float = nan
    y_m: float = nan
    yaw_rad: float = nan


@dataclass(frozen=True, slots=True)
class BodyState:
    """Everything of one frame at once: the one input of the analysis.

    Attributes
    ----------
    frame : int
        Number of the frame, 0 for the first one that the tracker was given.
    stamp_ns : int
        Time of capture, nanoseconds since the epoch of the source.
    frame_id : str
        Frame of all metric coordinates: a chamber's, or the camera's where there is no chamber.
    where : Where
        The part of the rig that holds the head.
    status : Status
        The outcome; keypoints are NaN where it says that they could not be had.
    geometry : int
        Version of the `Geometry` that the metric coordinates rest on; 0 where there is none.
    confidence : float
        0 to 1: how well the body explains the picture.
    head_certainty : float
        0.5 (a coin's toss) to 1: how sure it is that head and tail are not exchanged.
    head, centroid, tail : Keypoint
        Head tip, area centroid, tail tip.
    length_px, width_px : float
        Length along the midline from tip to tip; mean width over the body's middle part.
    length_m, width_m : float
        The same in metres; NaN where no scale is known.
    head_sd_m : float
        How far the head's tip may be, along the body, from where it is given: a standard deviation.
        0 where its outline shows it, or where nothing is said of it; a head that lies on the body
        is known less well.
    """

    frame: int
    stamp_ns: int
    frame_id: str = CAMERA
    where: Where = Where.UNKNOWN
    status: Status = Status.NO_WORM
    geometry: int = 0
    confidence: float = 0.0
    head_certainty: float = 0.5
    head: Keypoint = Keypoint()
    centroid: Keypoint = Keypoint()
    tail: Keypoint = Keypoint()
    length_px: float = nan
    width_px: float = nan
    length_m: float = nan
    width_m: float = nan
    head_sd_m: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Midline:
    """The body's centre line, head first.

    Attributes
    ----------
    u_px, v_px : ndarray, shape (n,)
        Picture coordinates; the first point is the head tip, the last one the tail tip.
    x_m, y_m : ndarray, shape (n,)
        The same in the state's `frame_id`; NaN where no scale is known.
    s_px : ndarray, shape (n,)
        Arc length from the head tip.
    width_px : ndarray, shape (n,)
        The body's width across the midline.
    """

    u_px: NDArray[np.float64]
    v_px: NDArray[np.float64]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    s_px: NDArray[np.float64]
    width_px: NDArray[np.float64]

    @classmethod
    def empty(cls) -> "Midline":
        """Return the midline of a frame without one."""
        none = np.empty(0)
        return cls(none, none, none, none, none, none)


@dataclass(frozen=True, eq=False, slots=True)
class TrackedFrame:
    """What the tracker says of one frame, and all that the analysis asks of it.

    Attributes
    ----------
    state : BodyState
    midline : Midline
    geometry : Geometry or None
        The rig that the state's metres rest on; None where it has not been found.
    """

    state: BodyState
    midline: Midline
    geometry: Geometry | None = None
