"""Keeps a rig that vibrates in its place: its pictures are shifted back by what its walls moved.

A bump is followed by a new geometry. Where one follows upon the other, to and fro, that would make
all that waits to be told lie elsewhere, several times a second.
"""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.calibration.motion_detector import MotionDetector


@dataclass(frozen=True, slots=True)
class VibrationSettings:
    """When a rig vibrates, and when it has come to rest."""

    moves: int = 3
    within_s: float = 30.0
    most_net_over_path: float = 0.5
    """It vibrates where so many moves, within so long, lead back: they come to less than this part
    of their sum. A drift goes on."""
    most_shift_px: float = 3.0
    """A larger move is a bump."""
    rest_s: float = 2.0
    most_scatter_at_rest_px: float = 0.05
    """How long the walls stay in one place, to within so much, where it has come to rest."""
    least_shift_px: float = 0.05
    """Below which a picture is left as it is: its walls tell no better."""


class Vibration:
    """Remembers how a rig moved, and shifts its pictures back while it vibrates.

    Parameters
    ----------
    settings : VibrationSettings

    Attributes
    ----------
    is_on : bool
        Whether it vibrates.
    """

    def __init__(self, settings: VibrationSettings) -> None:
        self._settings = settings
        self._moves: deque[tuple[int, Floats]] = deque(maxlen=settings.moves)
        self._shifts: deque[tuple[int, Floats]] = deque()
        self.is_on = False

    def note_move(self, stamp_ns: int, move_px: Floats) -> None:
        """Take note of a new place of the rig, (u, v) from the last one."""
        settings, moves = self._settings, self._moves
        if np.hypot(*move_px) > settings.most_shift_px:
            moves.clear()
            return
        moves.append((stamp_ns, move_px))
        if len(moves) < settings.moves or stamp_ns - moves[0][0] > 1e9 * settings.within_s:
            return
        steps = np.array([move for _, move in moves])
        net, path = np.hypot(*steps.sum(axis=0)), np.hypot(*steps.T).sum()
        if net < settings.most_net_over_path * path:
            self.is_on = True
            moves.clear()
            self._shifts.clear()

    def stabilised(self, picture: Picture, stamp_ns: int, walls: MotionDetector) -> Picture:
        """Return a picture with the walls where they were, while the rig vibrates.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        stamp_ns : int
        walls : MotionDetector
            Which knows where they were.
        """
        shift = walls.shift(picture) if self.is_on else None
        if shift is None or np.hypot(*shift) > self._settings.most_shift_px:
            return picture
        self._note_shift(stamp_ns, shift)
        if np.hypot(*shift) < self._settings.least_shift_px:
            return picture
        return shifted(picture, -shift)

    def _note_shift(self, stamp_ns: int, shift: Floats) -> None:
        """Take note of where the walls are; the rig may have come to rest."""
        settings, shifts = self._settings, self._shifts
        shifts.append((stamp_ns, shift))
        rest_ns = 1e9 * settings.rest_s
        if stamp_ns - shifts[0][0] < rest_ns:
            return
        while stamp_ns - shifts[1][0] >= rest_ns:
            shifts.popleft()
        scatter = np.array([each for _, each in shifts]).std(axis=0)
        self.is_on = bool(scatter.max() > settings.most_scatter_at_rest_px)


def shifted(picture: Picture, by_px: Floats) -> Picture:
    """Return a picture shifted by (u, v) pixels; what comes into view is as its border was."""
    motion = np.array([[1.0, 0.0, by_px[0]], [0.0, 1.0, by_px[1]]])
    size = picture.shape[1], picture.shape[0]
    moved = cv2.warpAffine(
        picture, motion, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(moved, np.uint8)
