"""Tells whether corrections are of the recording that they are to be applied to."""

from collections.abc import Collection, Iterable

from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import Correction, why_beyond, why_not_of
from worm_tracker.sources.bags.bag_reader import BagPicture


def check_corrections(corrections: Collection[Correction], pictures: Iterable[BagPicture]) -> None:
    """Refuse corrections of another recording, before anything is done with them.

    Parameters
    ----------
    corrections : collection of Correction
    pictures : iterable of BagPicture
        As they will be played; read as far as the last frame that a correction names.

    Raises
    ------
    BadInput
        A frame was taken at another time than a correction says, or is not there.
    """
    last = max((max(told.first_frame, told.last_frame or 0) for told in corrections), default=-1)
    frames = 0
    for frame, picture in enumerate(pictures if last >= 0 else ()):
        wrong = why_not_of(corrections, frame, picture.stamp_ns)
        if wrong:
            raise BadInput(wrong)
        frames = frame + 1
        if frame == last:
            return
    wrong = why_beyond(corrections, frames)
    if wrong:
        raise BadInput(wrong)
