"""Which bodies that were lost are known after all: by where the other way through a fold is known.

A body that left too many pictures unexplained may be another one from then on, though it explains
those that come. Where it lies as the other way through the fold has it, which was not lost, it is
the worm's, and so it is for as long as it has been followed.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from worm_tracker.observation import Observation
from worm_tracker.propagation.opening import AgreementSettings, body_of


def known_stretches(
    frames: Sequence[int],
    there: Mapping[int, Observation],
    back: Mapping[int, Observation],
    settings: AgreementSettings,
) -> tuple[frozenset[int], frozenset[int]]:
    """Return the frames in which either way through a fold is known.

    Where a way tells a midline it is known. Where it was lost it is, if the other way is known
    in a frame of the same stretch and lies there.

    Parameters
    ----------
    frames : sequence of int
        Numbers of the fold's frames, in their order.
    there, back : mapping of int to Observation
        What either way says of them.
    settings : AgreementSettings

    Returns
    -------
    there, back : frozenset of int
    """
    ways = [_followed(frames, said) for said in (there, back)]
    stretches = [_stretches(frames, way, settings) for way in ways]
    known = [{k for k in frames if k in said and said[k].has_midline} for said in (there, back)]
    grown = True
    while grown:
        before = [len(each) for each in known]
        for one, other in ((0, 1), (1, 0)):
            for stretch in stretches[one]:
                met = (set(stretch) & known[other]) - known[one]
                if any(_lies_as(ways[one][k], ways[other].get(k), settings) for k in met):
                    known[one].update(stretch)
        grown = before != [len(each) for each in known]
    return frozenset(known[0]), frozenset(known[1])


def _followed(frames: Sequence[int], said: Mapping[int, Observation]) -> dict[int, Observation]:
    """Return the bodies of a way that explain their pictures, told or only followed."""
    bodies = {k: body_of(said[k]) for k in frames if k in said}
    return {k: body for k, body in bodies.items() if body is not None and body.explains}


def _stretches(
    frames: Sequence[int], bodies: Mapping[int, Observation], settings: AgreementSettings
) -> list[list[int]]:
    """Return the frames between which a body was never lost, its midline explaining each."""
    found = list[list[int]]()
    unexplained = 0
    for k in frames:
        if k not in bodies:
            unexplained += 1
            continue
        if not found or unexplained > settings.most_frames_unexplained:
            found.append([])
        found[-1].append(k)
        unexplained = 0
    return found


def _lies_as(lost: Observation, known: Observation | None, settings: AgreementSettings) -> bool:
    """Tell whether a body that was lost lies as one that is known, where both are seen."""
    if known is None or not known.loops_known:
        return False
    count = len(known.points)
    for way in (lost, lost.reversed()):
        first, last = np.maximum(way.occluded, known.occluded)
        seen = slice(first, count - last)
        if count - first - last < settings.least_seen * count:
            continue
        apart = np.hypot(*(way.points[seen] - known.points[seen]).T)
        if apart.max() < settings.most_apart_widths * known.width:
            return True
    return False
