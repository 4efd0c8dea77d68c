"""What a camera is asked to film like, and what of that it did not take."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from worm_msgs_py.limits import Limit
from worm_tracker.sources.cameras.camera_address import Kind
from worm_tracker.sources.cameras.waiting_frames import CapturedFrame

SIDE_PX = Limit(16, 100_000, "px", or_zero=True)
PLACE_IN_PICTURE_PX = Limit(0, 100_000, "px")
CAMERA_RATE = Limit(0.01, 10_000.0, "Hz", or_zero=True)
EXPOSURE_MS = Limit(0.001, 60_000.0, "ms", or_zero=True)
_MANUAL, _V4L2_EXPOSURES_PER_MS = 1, 10
"""Of Video4Linux: exposure is by hand, in units of 100 µs."""
_NEAR_PART = 0.02


@dataclass(frozen=True)
class CameraSettings:
    """What is asked of a camera; 0: as it films by itself.

    Attributes
    ----------
    width_px, height_px : int
        Size of its pictures.
    frames_per_s, exposure_ms : float
        Pictures a second, and how long each is exposed.
    """

    width_px: int = 0
    height_px: int = 0
    frames_per_s: float = 0.0
    exposure_ms: float = 0.0

    def apply(self, capture: Any, kind: Kind) -> list[str]:
        """Ask an opened `cv2.VideoCapture`; return a line for each thing that it did not take."""
        wishes = [
            ("width", self.width_px, cv2.CAP_PROP_FRAME_WIDTH, 1.0, "px"),
            ("height", self.height_px, cv2.CAP_PROP_FRAME_HEIGHT, 1.0, "px"),
            ("rate", self.frames_per_s, cv2.CAP_PROP_FPS, 1.0, "frames/s"),
            ("exposure", self.exposure_ms, cv2.CAP_PROP_EXPOSURE, _V4L2_EXPOSURES_PER_MS, "ms"),
        ]
        wishes = [wish for wish in wishes if wish[1]]
        if kind is not Kind.DEVICE:
            return [
                f"the {name} of a {kind.value} cannot be set: {asked:g} {unit} were asked for"
                for name, asked, _, _, unit in wishes
            ]
        if self.exposure_ms:
            capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, _MANUAL)
        for _, asked, number, scale, _ in wishes:
            capture.set(number, asked * scale)
        refused = []
        for name, asked, number, scale, unit in wishes:
            got = float(capture.get(number)) / scale
            if not abs(got - asked) <= _NEAR_PART * asked:
                refused.append(f"{asked:g} {unit} of {name} were asked for, {got:g} are given")
        return refused


@dataclass(frozen=True)
class Region:
    """The part of each picture that is used; all of it where it has no width.

    Attributes
    ----------
    u_px, v_px : int
        Its upper left corner, from that of the picture, to the right and down.
    width_px, height_px : int
        Its size.
    """

    u_px: int = 0
    v_px: int = 0
    width_px: int = 0
    height_px: int = 0

    def of(self, frame: CapturedFrame) -> CapturedFrame:
        """Return the frame of that part alone; a bad one where the picture does not hold it."""
        if not self.width_px or frame.why_bad:
            return frame
        height, width = frame.picture.shape
        u_end, v_end = self.u_px + self.width_px, self.v_px + self.height_px
        if u_end > width or v_end > height:
            why = (
                f"the region of {self.width_px} × {self.height_px} pixels at ({self.u_px}, "
                f"{self.v_px}) is not within the picture of {width} × {height}"
            )
            return CapturedFrame(np.empty((0, 0), np.uint8), frame.stamp_ns, why)
        part = frame.picture[self.v_px : v_end, self.u_px : u_end]
        return CapturedFrame(np.ascontiguousarray(part), frame.stamp_ns)
