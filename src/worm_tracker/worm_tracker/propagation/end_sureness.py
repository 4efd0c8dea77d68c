"""How surely the ends of a body that lies on itself are where they are said to be."""

from math import inf, log

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Picture
from worm_tracker.midline.body_model import BodyModel, mean_width
from worm_tracker.midline.curve import length_of, unit_grid
from worm_tracker.midline.end_marks import log_odds_of_whole_end
from worm_tracker.midline.other_ends import other_ends, sd_by_outline
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.s_turns import s_turn_at_ends
from worm_tracker.midline.self_cover import (
    ends_on_body,
    lies_near_itself,
    strands_at_ends,
)
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.overlaps import marked_ends, overlaps_tell
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


def end_sd_px_of(
    body: PropagatedBody, model: BodyModel, settings: PropagationSettings
) -> tuple[float, float]:
    """Return how surely the ends are where they are said to be.

    The picture does not tell an end that lies on the body where overlaps are no darker, but by its
    outline, nor one so pale that it adds little, unless its marks do: edges of what it lies on are
    taken for its own.
    Nor does it where two other strands cross: three layers are not told from two.
    It is no surer than the length agrees with the known one, and than the worm keeps its length.
    Nor are two that coincide, either of which may be the other, nor is a pale one of a folded body
    shorter than a stroke makes it: the object may have been seen without it, unless its marks tell
    that it is whole. Of one shade an end on a body shorter than any stroke makes it lies elsewhere,
    whatever the outline says; nor does that tell much with a loop in doubt, as strands that are
    taken for each other have one outline.
    """
    folded = lies_near_itself(body.path.curve, mean_width(model.widths), body.path.step)
    near_px = settings.near_end_widths * model.width
    on_body = ends_on_body(body.path.curve, near_px, body.path.step)
    shortening = log(model.length / body.path.length) if folded else 0.0
    dark = overlaps_tell(model, settings)
    too_short = not dark and shortening > settings.most_log_shortening_of_one_shade
    apart_px = float(np.hypot(*(body.points[0] - body.points[-1])))
    coincide = folded and apart_px < settings.coinciding_ends_widths * model.width
    if coincide and max(body.end_sd_px) > settings.most_end_sd_of_coinciding_widths * model.width:
        return model.width, model.width
    by_marks = _told_by_marks(body, model, settings)
    most_px = (
        inf if body.doubt_by_bends is None else settings.most_end_sd_in_doubt_widths * model.width
    )
    by_outline = [sd if sd < most_px and not too_short else inf for sd in body.outline_sd_px]
    by_length = _sd_px_by_length(body, model, shortening, settings)
    sd_px = [
        sd if on and marks and not too_short else max(sd, min(length, outline))
        for sd, on, marks, length, outline in zip(
            body.end_sd_px, on_body, by_marks, by_length, by_outline, strict=True
        )
    ]
    crossing_px = settings.near_crossing_widths * model.width
    others = strands_at_ends(body.path.curve, crossing_px, model.width, body.path.step)
    first, last = (
        max(sd, model.width) if strands > 1 else sd
        for sd, strands in zip(sd_px, others, strict=True)
    )
    return first, last


def _sd_px_by_length(
    body: PropagatedBody,
    model: BodyModel,
    shortening: float,
    settings: PropagationSettings,
) -> list[float]:
    """Return how surely the length alone tells each end that the picture does not; else 0, pixels.

    That does not tell one on a strand where overlaps are no darker, nor a pale one there, or of a
    body that is short.
    """
    near_px = settings.on_strand_widths * model.width
    on_strand = ends_on_body(body.path.curve, near_px, body.path.step)
    short = shortening > settings.most_log_shortening_of_pale
    dark = overlaps_tell(model, settings)
    off_px = max(abs(body.path.length - model.length), model.length_scatter * model.length)
    return [
        off_px * ((on and (pale or not dark)) or (pale and short and not whole))
        for on, pale, whole in zip(on_strand, model.pale_ends, body.whole_ends, strict=True)
    ]


def _told_by_marks(
    body: PropagatedBody, model: BodyModel, settings: PropagationSettings
) -> tuple[bool, bool]:
    """Tell of each pale end whether its marks tell where it lies on the body."""
    little = body.over_limits <= settings.most_over_limits_by_marks
    if not (overlaps_tell(model, settings) and little):
        return False, False
    most_px = settings.most_end_sd_by_marks_widths * model.width
    first, last = (
        marks and sd < most_px
        for marks, sd in zip(marked_ends(model, settings), body.end_sd_px, strict=True)
    )
    return first, last


def whole_ends(
    signal: Picture,
    path: BodyPath,
    model: BodyModel,
    levels: Floats,
    settings: PropagationSettings,
) -> tuple[bool, bool]:
    """Tell of each end of a body whether its marks tell that the picture lacks nothing of it.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture in a window.
    path : BodyPath
        The body in the window's coordinates.
    model : BodyModel
    levels : ndarray, shape (TRACKED_POINTS,)
        Its signal in a picture of this brightness.
    settings : PropagationSettings
    """
    first, last = (
        tells
        and log_odds_of_whole_end(
            signal, curve, known, model.length, model.width, settings.end_marks
        )
        > settings.least_log_odds_of_whole_end
        for tells, curve, known in zip(
            marked_ends(model, settings),
            (path.curve, path.curve[::-1]),
            (levels, levels[::-1]),
            strict=True,
        )
    )
    return first, last


def outline_sd_px(
    mask: Picture, found: Candidate, model: BodyModel, settings: PropagationSettings
) -> tuple[float, float]:
    """Return of each end on or beside the body how surely the outline tells where it lies.

    A standard deviation in pixels, asked where overlaps are no darker, so that nothing else tells;
    inf where it is not asked. By the flanks beside it, where they fit; else by what ends elsewhere
    leave unexplained.

    Parameters
    ----------
    mask : ndarray of uint8, shape (h, w)
        The object.
    found : Candidate
        The body, in the mask's coordinates.
    model : BodyModel
    settings : PropagationSettings
    """
    if overlaps_tell(model, settings):
        return inf, inf
    path, most_px = found.path, settings.most_end_sd_widths * model.width
    on_body = ends_on_body(path.curve, settings.near_end_widths * model.width, path.step)
    half = half_widths_along(path, model)
    first, last = (
        _first_end_sd_px(mask, curve, widths, model.width, settings)
        if on and sd < most_px and flanks == inf
        else flanks
        for on, sd, flanks, curve, widths in zip(
            on_body,
            found.end_sd_px,
            found.flanks_sd_px,
            (path.curve, path.curve[::-1]),
            (half, half[::-1]),
            strict=True,
        )
    )
    return first, last


def _first_end_sd_px(
    mask: Picture, curve: Complex, half: Floats, width: float, settings: PropagationSettings
) -> float:
    """Return how surely the outline tells where a path's first end is."""
    others = other_ends(mask, curve, half, width, settings.residual.drawing, settings.other_ends)
    return settings.sd_of_misfit * sd_by_outline(others, settings.other_ends)


def half_widths_along(path: BodyPath, model: BodyModel) -> Floats:
    """Return half the width that a body is known to have at each node of its path, pixels."""
    part, known = unit_grid(len(path.curve)), unit_grid(len(model.widths))
    return np.interp(part, known, model.widths / 2)


def most_end_sd_px(body: PropagatedBody, model: BodyModel, settings: PropagationSettings) -> float:
    """Return how unsure an end may be and still be told, pixels.

    What a body with a loop in doubt leaves over, or a marked one, though it is little enough to be
    believed, may be an unsure end that lies elsewhere.
    """
    most = settings.most_end_sd_widths
    if overlaps_tell(model, settings):
        most = settings.most_end_sd_in_darker_overlap_widths
    over = 1.0 if body.doubt_by_bends is None else settings.most_over_limits_of_unsure_end
    if model.is_marked:
        over = min(over, settings.most_over_limits_of_marked)
    if body.over_limits > over:
        most = min(most, settings.most_end_sd_beside_left_over_widths)
    return most * mean_width(model.widths)


def is_too_short(points: Floats, model: BodyModel, settings: PropagationSettings) -> bool:
    """Tell whether an open midline is shorter than a stroke makes it: an end may lie on the rest.

    Where overlaps are darker that is seen, and not asked.
    """
    most = settings.most_log_shortening_of_open
    return not overlaps_tell(model, settings) and log(model.length / length_of(points)) > most


def s_at_end(path: BodyPath, width: float, settings: PropagationSettings) -> bool:
    """Tell whether a body makes a sharp S near an end: that bend is not where it was laid."""
    sharpest = s_turn_at_ends(path.points, width, settings.s_near_end_widths)
    return sharpest > settings.most_s_turn_at_end_rad
