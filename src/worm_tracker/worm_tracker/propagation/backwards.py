"""Propagates a midline back through the pictures before it, out of a coil.

Where a body cannot be followed into a coil, or the film begins with one, the midline is propagated
backwards in time from the first frame that has one again: a worm that opens tells how it lay.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.detection import Detection
from worm_tracker.detection.pale_ends import with_followed_ends
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.path import path_of
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.midline.strand_exchange import doubtful_loops, part_of
from worm_tracker.observation import Observation
from worm_tracker.propagation.body_candidates import CandidateSearch
from worm_tracker.propagation.held_body import found_from_held
from worm_tracker.propagation.lies_otherwise import followed_or_otherwise
from worm_tracker.propagation.overlaps import as_dark_as, as_dark_as_followed
from worm_tracker.propagation.propagation import coiled, observation_of, propagate
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


@dataclass(frozen=True, eq=False, slots=True)
class PastDetection:
    """The object in a picture that waits.

    Attributes
    ----------
    detection : Detection
    frames : int
        How many frames it is from the one that is gone through before it, 1 for the next.
    """

    detection: Detection
    frames: int


class BackwardPropagation:
    """What a midline tells of the pictures before it: an iterator, a picture a step.

    Those after it, the nearest first, are gone through alike: nothing here hangs on the direction.
    It ends where the body no longer explains the object. A step takes as long as a picture of a
    fold does, so that a caller may spread them.

    Parameters
    ----------
    model : BodyModel
        The worm.
    opened : Observation
        The frame that has a midline, in the order of the body model's widths.
    detections : sequence of PastDetection
        The object in the pictures before (or after), the nearest first.
    contour_body : callable
        Gives the midline of a simple body by its contour, which may be turned round, else None: a
        picture may have been taken for a coil because the body was not known.
    may_hide_end : callable
        Whether the open body in an object, followed to some points, may have an end that is bent
        onto itself.
    path_numbers : iterator of int
        Numbers for the paths that the body is slid along; no two of one worm are the same.
    settings : PropagationSettings
    """

    def __init__(
        self,
        model: BodyModel,
        opened: Observation,
        detections: Sequence[PastDetection],
        contour_body: Callable[[Detection], RefinedMidline | None],
        may_hide_end: Callable[[Detection, Floats], bool],
        path_numbers: Iterator[int],
        settings: PropagationSettings,
    ) -> None:
        path = path_of(opened.points, None, model.width)
        self._model, self._settings, self._contour_body = model, settings, contour_body
        self._may_hide_end = may_hide_end
        doubt = part_of(doubtful_loops(path, model.width, settings.exchange))
        self._last = PropagatedBody(
            path, opened.confidence, opened.confidence, loop_in_doubt=doubt, doubt_by_bends=doubt
        )
        self._before: Floats | None = None
        self._path_numbers, self._path_number = path_numbers, next(path_numbers)
        self._fits = 0
        self._frames_lost = 0
        self._left = list(reversed(detections))

    @property
    def model(self) -> BodyModel:
        """The worm, with what has been seen of its overlaps on the way."""
        return self._model

    def __iter__(self) -> "BackwardPropagation":
        return self

    def __next__(self) -> Observation:
        """Return what the next picture back shows.

        Where the body is followed but does not explain all of the object, that is a coil.
        """
        if not self._left:
            raise StopIteration
        past, settings = self._left.pop(), self._settings
        detection = past.detection
        detection = with_followed_ends(
            detection, self._model.width, self._last.points, settings.pale_ends
        )
        self._model = model = as_dark_as(detection, self._model, settings)
        frames = past.frames + self._frames_lost
        found = found_from_held(partial(self._find, detection), self._last, frames, settings)
        if found is None or found.over_limits > settings.lost_over_limits:
            return self._lose(detection, past.frames)
        self._frames_lost = 0
        if not found.was_slid:
            self._path_number = next(self._path_numbers)
        self._model = as_dark_as_followed(detection, model, found, settings)
        observation = observation_of(found, model, found.agreement, settings)
        observation = observation.on_path(self._path_number)
        if observation.status is Status.TRACKED and self._may_hide_end(detection, found.points):
            found = found.not_explaining(self._last.frames_unexplained + past.frames)
            observation = replace(observation, over_limits=found.over_limits)
        sure = found.agreement >= settings.least_agreement_backwards and found.is_explained
        sure = sure and not observation.is_mostly_hidden
        self._before, self._last = self._last.points, found
        return observation if sure else coiled(detection, observation)

    def _lose(self, detection: Detection, frames: int) -> Observation:
        """Take a picture in which the body is not found: from where it was the next may show it."""
        self._frames_lost += frames
        if self._frames_lost > self._settings.most_frames_lost_backwards:
            self._left = []
            raise StopIteration
        return coiled(detection)

    def _find(
        self, detection: Detection, last: PropagatedBody, frames: int
    ) -> PropagatedBody | None:
        """Find the body in a picture, from where it was so many frames after it."""
        model, settings = self._model, self._settings
        least = last.expected_agreement - settings.most_agreement_lost_backwards
        scene = CandidateSearch.of(detection, model, last, frames, settings)
        found = _slid_only(scene)
        if found is None or found.over_limits > 1:
            found = _open_again(scene, self._contour_body(detection)) or found
        poor = found is None or found.agreement < least
        if poor and self._fits < settings.most_fits_backwards:
            self._fits += 1
            before = self._before if last is self._last else None
            found = propagate(detection, model, last, before, frames, None, settings)
        return found


def _open_again(scene: CandidateSearch, found: RefinedMidline | None) -> PropagatedBody | None:
    """Return a body found by its contour as one that is propagated; None where it is another."""
    model, last, frames = scene.model, scene.body, scene.frames
    if found is None or scene.hides_a_part(found):
        return None
    if model.leaps(found.points, last.points, frames):
        found = found.reversed()
    if model.leaps(found.points, last.points, frames):
        return None
    path = path_of(found.points, None, model.width)
    agreement = found.edges_found
    return PropagatedBody(path, agreement, agreement, complex(found.u, found.v))


def _slid_only(scene: CandidateSearch) -> PropagatedBody | None:
    """Slide the worm's body along itself, and fit none anew; None where that leads nowhere."""
    slid = followed_or_otherwise(scene)
    if slid is None or scene.leaps(slid):
        return None
    return replace(scene.in_picture(slid), was_slid=scene.keeps_ends(slid))
