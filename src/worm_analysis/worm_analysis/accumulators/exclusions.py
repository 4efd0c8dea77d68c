"""How many frames are excluded from every estimate, and why."""

import numpy as np

from worm_msgs_py.arrays import Floats

UNTRACKED = "untracked"
"""The tracker found no head."""
UNCERTAIN = "uncertain"
"""It is not sure enough which end is the head."""
STALE = "stale"
"""The stamp is not later than that of the frame before."""


class Exclusions:
    """Counts of frames.

    Attributes
    ----------
    frames : int
        All frames.
    by_reason : dict of str to int
        Those that are excluded, by reason.
    """

    def __init__(self) -> None:
        self.frames = 0
        self.by_reason = dict.fromkeys((UNTRACKED, UNCERTAIN, STALE), 0)

    def count(self, reason: str) -> None:
        """Take a frame; an empty reason is a frame that is used."""
        self.frames += 1
        if reason:
            self.by_reason[reason] += 1

    def sums(self) -> dict[str, Floats]:
        """Return the number of frames and of those that are excluded for a reason."""
        return {
            f"frames_{reason}": np.array([[self.frames, self.by_reason[reason]]], dtype=np.float64)
            for reason in (UNTRACKED, UNCERTAIN)
        }
