"""How many frames count for no estimate, and why."""

UNTRACKED = "untracked"
"""The tracker found no head."""
UNCERTAIN = "uncertain"
"""It is not sure enough which end is the head."""
STALE = "stale"
"""The stamp is not later than that of the frame before."""


class LeftOut:
    """Counts of frames.

    Attributes
    ----------
    frames : int
        All frames.
    by_reason : dict of str to int
        Those that were left out, by reason.
    """

    def __init__(self) -> None:
        self.frames = 0
        self.by_reason = dict.fromkeys((UNTRACKED, UNCERTAIN, STALE), 0)

    def count(self, reason: str) -> None:
        """Take a frame; an empty reason is a frame that counts."""
        self.frames += 1
        if reason:
            self.by_reason[reason] += 1
