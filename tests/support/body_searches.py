"""Searches for a body in a picture, from where it lay in the one before."""

import numpy as np

from worm_tracker.midline.body_model import BodyModel, BodyModelSettings
from worm_tracker.midline.body_residual import BodyResidualSettings, ObjectMasks, Unexplained
from worm_tracker.midline.path import BodyPath, evenly
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


def candidate(path, left_over_widths2=0.0):
    nothing = np.zeros((9, 9), np.uint8)
    seen = ObjectMasks(nothing, None, 15.0, BodyResidualSettings())
    left_over = Unexplained(left_over_widths2, 0.0, 0.0, 0.95, nothing, nothing, seen)
    return Candidate(path, 0.95, left_over)
