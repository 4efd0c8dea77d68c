"""Lays an end of a body anew where a picture's grey levels tell more of it, or otherwise.

Of an end that is not sure all of the picture about it is asked. One told too short leaves the
strand that it lies on to take its flank for an edge, and the picture is darker beside it than the
body makes it; one told too long lies beside that strand where nothing is, and it is paler. Moved on
or back along its way and slid again, both lie where they are seen.
"""

from dataclasses import replace

import numpy as np

from worm_tracker.midline.end_by_signal import end_by_signal
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.propagation.beside_ends import body_signal
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_laid import has_other_end_beside, known_end, with_end_told


def with_ends_by_signal(scene: CandidateSearch, found: Candidate) -> Candidate:
    """Return a body whose ends lie where the picture's grey levels say so, and how surely.

    An end stays where no other place explains the picture. Where overlaps are no darker that is not
    asked, nor of a skin with marks, which look like what is darker or paler beside an end: once
    they are known they are asked themselves (`laid_by_skin.py`).
    """
    if scene.seen.dark is None or scene.model.is_marked:
        return found
    for last_end in (False, True):
        found = _with_likeliest_end(scene, found, last_end)
    over = scene.ends_over_limits(found)
    for last_end in (False, True):
        if over[last_end] > 1:
            found = _with_end_moved(scene, found, last_end)
    return found


def _with_likeliest_end(scene: CandidateSearch, found: Candidate, last_end: bool) -> Candidate:
    """Return a body with an unsure end where all of the picture about it says that it lies.

    As it is where that tells no more. A pale end is not drawn as pale as it is.
    """
    model, settings, back = scene.model, scene.settings, -1 if last_end else 1
    known = known_end(scene, found, last_end)
    least_px = settings.least_end_sd_by_signal_widths * model.width
    if known is None or known.sd_px < least_px or model.pale_ends[last_end]:
        return found
    if has_other_end_beside(scene, found):
        return found
    path = found.path.turned_round() if last_end else found.path
    body = body_signal(path, model, scene.levels[::back])
    end = end_by_signal(scene.signal, body, model.widths[::back], known, settings.by_signal)
    return found if end.sd_px > known.sd_px else with_end_told(scene, found, end, last_end)


def _with_end_moved(scene: CandidateSearch, found: Candidate, last_end: bool) -> Candidate:
    """Return a body with one end moved to where the picture differs least, if little enough."""
    model, best, least = scene.model, found, 1.0
    was = complex(found.path.curve[-1 if last_end else 0])
    for widths in scene.settings.moved_end_widths:
        slid = scene.slid(_with_end_at(found.path, last_end, widths * model.width, model.width))
        if slid is None or scene.over_limits(slid) > max(scene.over_limits(found), 1.0):
            continue
        over = max(scene.ends_over_limits(slid)[last_end], scene.end_over_limits_at(slid, was))
        if over < least:
            best, least = slid, over
    if best is found:
        return found
    return replace(
        best,
        path=replace(best.path, ways=found.path.ways),
        straighter=found.straighter,
        was_exchanged=found.was_exchanged,
    )


def _with_end_at(path: BodyPath, last_end: bool, way: float, width: float) -> BodyPath:
    """Return a path with an end moved straight on by a way, or back by it, pixels."""
    curve = path.curve[::-1] if last_end else path.curve
    count = round(abs(way) / path.step)
    if way > 0:
        behind = min(max(1, round(width / path.step)), len(curve) - 1)
        heading = curve[0] - curve[behind]
        heading /= max(abs(heading), 1e-9)
        on = curve[0] + heading * path.step * np.arange(count, 0, -1)
        line = np.concatenate([on, curve])
    else:
        line = curve[min(count, len(curve) // 2) :]
    line = evenly(line, nodes_for(path.length + way, width))
    return BodyPath(line[::-1] if last_end else line)
