"""Propagates a midline where the contour gives none: forwards, and backwards out of a coil.

A body is slid along itself into the next picture; where that does not explain the object, a
deformable body is fitted. Where a body cannot be followed into a coil, or the film begins with one,
the midline is propagated backwards in time from the first frame that has one again: a worm that
opens tells how it lay.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import log

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.detection import Detection
from worm_tracker.midline.body_model import BodyModel, end_displacement, mean_width
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.deformable_fit import BodyFitSettings, fit_body, mask_overlap
from worm_tracker.midline.path import BodyPath, path_of, sharpest_turn
from worm_tracker.midline.path_following import (
    ExpectedBody,
    PathFollowingSettings,
    slide_along_path,
)
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.observation import Observation
from worm_tracker.worm_track import PropagatedBody


@dataclass(frozen=True, slots=True)
class PropagationSettings:
    """What a propagated body must explain of the picture, and what it may change."""

    first_expected_agreement: float = 0.95
    """What a body is expected to agree with the picture that touches itself for the first time."""
    expected_agreement_lost_per_frame: float = 0.005
    """What that expectation loses in a frame: a tighter coil is drawn less well."""
    most_agreement_lost_sliding: float = 0.02
    """How much less than expected a slid body may have before others are tried."""
    most_agreement_lost_resliding: float = 0.02
    """How much less than the fitted body the one slid from it, below a pixel, may have."""
    end_displacement_cost_per_length: float = 0.3
    """What moving an end by a length takes off a body's score."""
    log_stretch_cost: float = 1.0
    """What a unit of log length takes off it."""
    free_log_stretch: float = 0.05
    """Log of the length over the known one that costs nothing: a worm's own stroke."""
    most_turn_rad_per_width: float = 2.0
    """Turn over a width beyond which a midline has a kink: half a turn is a body laid double."""
    kink_cost_per_rad: float = 0.15
    """What a radian more takes off its agreement."""
    length_return_per_frame: float = 0.05
    """How fast an unseen tip lets the length return to the known one."""
    least_agreement_backwards: float = 0.75
    """What a body that is propagated backwards must have: nothing else supports it."""
    most_agreement_lost_backwards: float = 0.04
    """How much less than expected it may have."""
    most_fits_backwards: int = 12
    """Pictures in which a body may be fitted that does not slide there: many would take long."""
    path_following: PathFollowingSettings = field(default_factory=PathFollowingSettings)
    fit: BodyFitSettings = field(default_factory=BodyFitSettings)


def propagate(
    detection: Detection,
    model: BodyModel,
    last: PropagatedBody,
    before: Floats | None,
    frames: int,
    contour_body: RefinedMidline | None,
    settings: PropagationSettings,
) -> PropagatedBody:
    """Propagate the worm's body to an object that touches itself, from where the body was.

    Parameters
    ----------
    detection : Detection
        The object.
    model : BodyModel
        The worm.
    last : PropagatedBody
        Where it was in the last picture that gave a midline.
    before : ndarray, shape (TRACKED_POINTS, 2), or None
        Its midline in the one before, in the same order.
    frames : int
        How many frames ago that was, 1 for the next.
    contour_body : RefinedMidline or None
        A midline that the contour gave, and that cannot continue the last one: the better of both
        is taken.
    settings : PropagationSettings

    Notes
    -----
    Where the body, slid along itself, explains the object about as well as it did before, nothing
    else is tried. Else a deformable body is fitted from there, and slid once more where it was
    found, which brings it below a pixel.
    """
    scene = _Scene.of(detection, model, last, frames, settings)
    slid = scene.slid(scene.last)
    enough = last.expected_agreement - settings.most_agreement_lost_sliding
    if slid is not None and slid.agreement >= enough and not scene.leaps(slid):
        return scene.in_picture(slid)
    starts = [scene.last.points]
    if before is not None:
        starts.append(2 * last.points - before - as_points(np.array([scene.origin])))
    return scene.in_picture(scene.best(slid, starts, contour_body))


def observation_of(
    detection: Detection, body: PropagatedBody, model: BodyModel, confidence: float
) -> Observation:
    """Return the observation of a propagated body; the centroid is that of what is seen."""
    u, v = detection.centroid()
    width = mean_width(model.widths)
    return Observation(Status.TRACKED, u, v, body.points, model.widths, confidence, width)


def propagate_back(
    model: BodyModel,
    opened: Observation,
    detections: Sequence[Detection],
    settings: PropagationSettings,
) -> Iterator[Observation]:
    """Propagate a midline back through the pictures before it.

    Parameters
    ----------
    model : BodyModel
        The worm.
    opened : Observation
        The frame that has a midline, in the order of the body model's widths.
    detections : sequence of Detection
        The object in the pictures before, the latest first.
    settings : PropagationSettings

    Yields
    ------
    Observation
        For each of these pictures, until the body no longer explains the object.
    """
    path = path_of(opened.points, None, model.width)
    last = PropagatedBody(path, opened.confidence, opened.confidence)
    before: Floats | None = None
    fits = 0
    for detection in detections:
        least = last.expected_agreement - settings.most_agreement_lost_backwards
        found = _slid_only(detection, model, last, settings)
        poor = found is None or found.agreement < least
        if poor and fits < settings.most_fits_backwards:
            fits += 1
            found = propagate(detection, model, last, before, 1, None, settings)
        if found is None or found.agreement < max(settings.least_agreement_backwards, least):
            return
        yield observation_of(detection, found, model, found.agreement)
        before, last = last.points, found


def _slid_only(
    detection: Detection, model: BodyModel, last: PropagatedBody, settings: PropagationSettings
) -> PropagatedBody | None:
    """Slide the worm's body along itself, and try nothing else; None where that leads nowhere."""
    scene = _Scene.of(detection, model, last, 1, settings)
    slid = scene.slid(scene.last)
    return None if slid is None or scene.leaps(slid) else scene.in_picture(slid)


@dataclass(frozen=True, eq=False, slots=True)
class _Scored:
    """A body in the window, and how well it agrees with the object."""

    path: BodyPath
    agreement: float


@dataclass(frozen=True, eq=False, slots=True)
class _Scene:
    """An object in its window, and the worm that is to explain it."""

    signal: Picture
    mask: Picture
    origin: complex
    model: BodyModel
    body: PropagatedBody
    last: BodyPath
    frames: int
    settings: PropagationSettings

    @classmethod
    def of(
        cls,
        detection: Detection,
        model: BodyModel,
        body: PropagatedBody,
        frames: int,
        settings: PropagationSettings,
    ) -> "_Scene":
        origin = complex(*detection.view.origin)
        mask, last = detection.object_pixels(), body.path.shifted(-origin)
        return cls(detection.view.signal, mask, origin, model, body, last, frames, settings)

    def in_picture(self, found: _Scored) -> PropagatedBody:
        """Return a body in the picture's coordinates, and with what is expected of the next one."""
        lost = self.settings.expected_agreement_lost_per_frame
        expected = max(found.agreement, self.body.expected_agreement - lost)
        return PropagatedBody(found.path.shifted(self.origin), found.agreement, expected)

    def slid(self, path: BodyPath) -> _Scored | None:
        """Return a body slid along itself."""
        model, settings = self.model, self.settings
        length = path.length * (model.length / path.length) ** settings.length_return_per_frame
        expected = ExpectedBody(model.widths, model.level, length)
        slid = slide_along_path(self.signal, path, expected, self.frames, settings.path_following)
        return None if slid is None else self.scored(slid, model.widths)

    def best(
        self, slid: _Scored | None, starts: list[Floats], contour_body: RefinedMidline | None
    ) -> _Scored:
        """Return the best of all that can be tried, fits from some starts among them."""
        model = self.model
        starts = starts if slid is None else [*starts, slid.path.points]
        fitted = [self.fitted(start) for start in starts]
        best = max(fitted, key=self.score)
        sharper = self.slid(best.path)
        least = best.agreement - self.settings.most_agreement_lost_resliding
        if sharper is not None and sharper.agreement >= least:
            best = sharper
        others = [best] if slid is None else [slid, best]
        if contour_body is not None:
            path = path_of(contour_body.points, None, model.width).shifted(-self.origin)
            others.append(self.scored(path, contour_body.widths))
        return max(others, key=self.score)

    def fitted(self, start: Floats) -> _Scored:
        """Return a deformable body fitted from a start."""
        model = self.model
        points = fit_body(self.mask, start, model.widths, model.length, self.settings.fit)
        return self.scored(path_of(points, None, model.width), model.widths)

    def scored(self, path: BodyPath, widths: Floats) -> _Scored:
        """Return a body with its agreement."""
        turn = sharpest_turn(path, self.model.width)
        kink = max(turn - self.settings.most_turn_rad_per_width, 0.0)
        overlap = mask_overlap(self.mask, path.points, widths)
        return _Scored(path, overlap - self.settings.kink_cost_per_rad * kink)

    def score(self, found: _Scored) -> float:
        """Return the agreement, less what the ends' displacement and the length cost."""
        model, settings = self.model, self.settings
        way = end_displacement(found.path.points, self.last.points) / model.length / self.frames
        stretch = max(abs(log(found.path.length / model.length)) - settings.free_log_stretch, 0.0)
        cost = settings.end_displacement_cost_per_length * way
        return found.agreement - cost - settings.log_stretch_cost * stretch

    def leaps(self, found: _Scored) -> bool:
        """Tell whether an end is farther from where it was than it can have got."""
        return self.model.leaps(found.path.points, self.last.points, self.frames)
