"""Holds on to the last body that explained its picture, while those followed from it do not.

A fold is hardest to see in a picture or two. A body followed through these may come out of them on
another strand; the one before them still lies about where the worm does.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import HeldBody, PropagatedBody

_Body = TypeVar("_Body", PropagatedBody, PropagatedBody | None)


def found_from_held(
    find: Callable[[PropagatedBody, int], _Body],
    last: PropagatedBody,
    frames: int,
    settings: PropagationSettings,
) -> _Body:
    """Find a body in a picture from the last one, or from the one that is held.

    The latter where only it leads to one that explains the picture.

    Parameters
    ----------
    find : callable
        Finds the body in the picture, from where another one was so many frames ago.
    last : PropagatedBody
        Where it was in the last picture, and the one held where that is not explained.
    frames : int
        How many frames ago that was, 1 for the next.
    settings : PropagationSettings

    Returns
    -------
    PropagatedBody or None
        What `find` gives. Where it does not explain its picture it holds the last one that did.
    """
    found, held = find(last, frames), last.held
    if held is not None and not _explains(found):
        other = find(held.body, last.frames_unexplained + frames)
        if other is not None and _explains(other):
            found = replace(other, was_slid=other.was_slid and held.was_slid)
    if found is None or not 0 < found.frames_unexplained <= settings.most_frames_unexplained:
        return found
    held = HeldBody(last) if last.frames_unexplained == 0 else held
    if held is not None:
        held = HeldBody(held.body, held.was_slid and found.was_slid)
    return replace(found, held=held)


def _explains(found: PropagatedBody | None) -> bool:
    return found is not None and found.over_limits <= 1
