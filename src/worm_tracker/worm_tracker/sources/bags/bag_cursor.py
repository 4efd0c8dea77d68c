"""Where in a bag a player is: the next picture, and what was lost on the way to it."""

from collections import deque
from collections.abc import Iterable

from worm_msgs_py import SourceEvent
from worm_tracker.sources.bags.bag_reader import BagLoss, BagPicture


class BagCursor:
    """Goes through a bag's pictures, one ahead of what was played.

    Parameters
    ----------
    pictures : iterable of BagPicture
        From the first one on.
    losses : deque of BagLoss
        Filled as the pictures are read, and emptied here.

    Attributes
    ----------
    picture : BagPicture or None
        The next one; None at the end.
    last_ns : int
        Stamp of the one before it.
    losses_told : int
        How many losses were taken.
    """

    def __init__(self, pictures: Iterable[BagPicture], losses: deque[BagLoss]) -> None:
        self._pictures = iter(pictures)
        self._losses = losses
        self.picture = next(self._pictures, None)
        self.last_ns = self.losses_told = 0

    def advance(self) -> None:
        """Go on to the picture after the next one."""
        if self.picture is not None:
            self.last_ns = self.picture.stamp_ns
        self.picture = next(self._pictures, None)

    def take_losses(self, frame: int) -> list[SourceEvent]:
        """Return what was lost before the next picture, which is to be frame number `frame`."""
        stamp_ns = self.last_ns if self.picture is None else self.picture.stamp_ns
        events = [
            SourceEvent(loss.kind, frame, stamp_ns, loss.why, count=loss.count)
            for loss in self._losses
        ]
        self.losses_told += len(events)
        self._losses.clear()
        return events

    def go_on_after(self, frames: int) -> None:
        """Pass over the first pictures, which were played, and the losses that were told."""
        for _ in range(frames):
            self.picture = next(self._pictures, None)
        for _ in range(self.losses_told):
            self._losses.popleft()

    def end(self) -> None:
        """Let the picture before the next one be the last."""
        self._pictures = iter(())
        self.picture = None
