"""Searches for a body in a picture, from where it lay in the one before."""

from dataclasses import replace

import numpy as np

from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.body_residual import (
    BodyResidualSettings,
    ObjectMasks,
    Unexplained,
    dark_places,
)
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


def kinked_loop(radius_widths, width):
    """Return a body that turns back by two kinks where to cross itself were straight."""
    r = radius_widths * width
    angle = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 80)
    leg = 6 * width * np.linspace(1.0, 0.05, 40)
    into, out = (-leg * np.exp(1j * sign * np.pi / 4) for sign in (1, -1))
    return BodyPath(evenly(np.r_[into, np.sqrt(2) * r + r * np.exp(1j * angle), out[::-1]], 240))


def search_after(path, width, frames, loops_known, end_sd_px=(0.0, 0.0)):
    """Return the search for a body in a picture so many frames after one, at the same place."""
    in_doubt = None if loops_known else (0.2, 0.8)
    last = PropagatedBody(path, 0.95, 0.95, end_sd_px=end_sd_px, doubt_by_bends=in_doubt)
    nothing, settings = np.zeros((9, 9), np.uint8), PropagationSettings()
    model = BodyModel(
        length=path.length,
        width=width,
        area=200.0,
        level=100.0,
        half_height_width=width,
        widths=np.full(65, width),
        levels=np.full(65, 100.0),
        gain=1.0,
        settings=BodyModelSettings(),
        first_length=path.length,
    )
    seen = ObjectMasks(nothing, None, width, settings.residual)
    return CandidateSearch(nothing, seen, model.levels, 0j, model, last, path, frames, settings)


def path_along(curve, width):
    """Return the path of a body of some width along a curve, as a search has it."""
    return BodyPath(evenly(curve, nodes_for(float(abs(np.diff(curve)).sum()), width)))


def search_in(signal, true, last, widths, level, darkening, darker=True):
    """Return the search for a body in its picture, from where it was said to lie.

    Its overlaps are known to be darker, or not to be.
    """
    width = max(widths)
    search = search_after(path_along(true, width), width, 1, loops_known=True)
    residual = search.settings.residual
    dark = dark_places(signal, level, darkening, residual) if darker else None
    known = np.interp(np.linspace(0, 1, 65), np.linspace(0, 1, len(widths)), widths)
    mask = (signal > level / 2).astype(np.uint8) * 255
    return replace(
        search,
        signal=signal,
        seen=ObjectMasks(mask, dark, width, residual),
        levels=np.full(65, level),
        model=replace(search.model, widths=known, level=level, darkening=darkening),
        last=last,
    )


def candidate(path, left_over_widths2=0.0):
    nothing = np.zeros((9, 9), np.uint8)
    seen = ObjectMasks(nothing, None, 15.0, BodyResidualSettings())
    left_over = Unexplained(left_over_widths2, 0.0, 0.0, 0.95, nothing, nothing, seen)
    return Candidate(path, 0.95, left_over)
