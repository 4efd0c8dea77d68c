"""Follows one worm from detection to detection: its midline, and what its body is like."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import count
from math import log

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.blobs import Blob, holds_wormlike_piece, whole_picture
from worm_tracker.detection.debris import without_debris
from worm_tracker.detection.detection import Detection, Missed, Occlusion
from worm_tracker.detection.occluded_body import occluded_points, with_known_width
from worm_tracker.detection.pale_ends import kept_for_later, with_followed_ends
from worm_tracker.following.follower_settings import FollowerSettings
from worm_tracker.following.open_body import open_body
from worm_tracker.midline.body_model import BodyModel, is_nearer_reversed, mean_width
from worm_tracker.midline.body_shade import shade_along
from worm_tracker.midline.contour_body import broad_contour_ends, explains_object, may_hide_end
from worm_tracker.midline.contour_midline import (
    ContourMidline,
    contour_midline,
    first_contour_midline,
)
from worm_tracker.midline.curve import as_complex, length_of
from worm_tracker.midline.doubled_body import looks_doubled
from worm_tracker.midline.refine import RefinedMidline, refine
from worm_tracker.midline.s_turns import s_turn_at_ends
from worm_tracker.midline.self_cover import lies_near_itself
from worm_tracker.observation import Observation
from worm_tracker.propagation.backwards import BackwardPropagation, PastDetection
from worm_tracker.propagation.end_sureness import is_too_short
from worm_tracker.propagation.held_body import found_from_held
from worm_tracker.propagation.overlaps import as_dark_as, as_dark_as_followed, darkening_of
from worm_tracker.propagation.propagation import coiled, observation_of, propagate
from worm_tracker.worm_track import LastBodies, PropagatedBody, WormTrack


class Follower:
    """Follows the worm; one detection in, one `Observation` out.

    Parameters
    ----------
    track : WormTrack
        What is remembered of the worm; each detection adds to it.
    shape : tuple of int
        Of the pictures.
    settings : FollowerSettings
    """

    def __init__(
        self, track: WormTrack, shape: tuple[int, ...], settings: FollowerSettings
    ) -> None:
        self._track = track
        self._shape = shape
        self._settings = settings
        self._path_numbers_back = count(-1, -1)
        self._way_back: BackwardPropagation | None = None

    def push(self, detection: Detection | Missed) -> Observation:
        """Find the midline of the worm in the next picture, or say why there is none."""
        if isinstance(detection, Missed):
            if detection.status is Status.BAD_IMAGE:
                self._track.skip()
            else:
                self._track.miss()
            return Observation(detection.status)
        self._learn_from_way_back()
        observation, propagated = self._observe(detection)
        points = observation.points if observation.has_midline else None
        self._track.see(detection.blob, points, propagated)
        observation = observation.on_path(self._track.bodies.path_number)
        if points is not None and detection.occlusion is not None:
            if observation.loops_known:
                return self._with_occlusion(observation, detection.occlusion)
            observation = coiled(detection, observation)  # one status says one thing
        opens_folds = observation.shows_all and not observation.by_marks
        if observation.status is Status.COILED or not opens_folds:
            return replace(observation, unresolved=self._kept(detection))
        model = self._track.model
        if model is not None and model.is_young:  # it may be looked at again with another body
            return replace(observation, kept=self._kept(detection))
        return observation

    def resolve_back(
        self, opened: Observation, detections: Sequence[PastDetection]
    ) -> Iterator[Observation]:
        """Return what a midline tells of the pictures before it, the latest first, one by one.

        Or of those after it, the earliest first.

        Parameters
        ----------
        opened : Observation
            What the last picture says; it has a midline.
        detections : sequence of PastDetection
            What was kept of these pictures, in that order.
        """
        self._learn_from_way_back()
        model, settings = self._track.model, self._settings.propagation
        if model is None:
            return iter(())
        if is_nearer_reversed(opened.widths[:, None], model.widths[:, None]):
            opened = opened.reversed()  # the body was lost since, and found the other way round
        looks = self._contour_body, self._may_hide_end
        self._way_back = BackwardPropagation(
            model, opened, detections, *looks, self._path_numbers_back, settings
        )
        return self._way_back

    def all_of_worm(self, observation: Observation) -> Floats | None:
        """Return a midline that is that of all of the worm: what is elsewhere is not worm."""
        model, settings = self._track.model, self._settings
        if model is None or not observation.has_midline or self._track.may_be_in_part:
            return None
        if model.frames < settings.learned_frames:
            return None
        off = abs(log(length_of(observation.points) / model.length))
        sure = (
            off < settings.whole_log_length_over_known
            and observation.status is Status.TRACKED
            and observation.confidence > settings.whole_confidence
            and self._track.bodies.propagated is None
        )
        return observation.points if sure else None

    def _learn_from_way_back(self) -> None:
        """Take what a way back has seen of the worm's overlaps, unless it was of another body."""
        model, way = self._track.model, self._way_back
        if model is None or way is None:
            return
        if abs(log(way.model.length / model.length)) < self._settings.most_log_length_in_fold:
            self._track.learn(model.with_overlaps_of(way.model))
        else:
            self._way_back = None

    def _kept(self, detection: Detection) -> Detection:
        settings = self._settings
        return kept_for_later(detection, settings.coil_margin_px, settings.propagation.pale_ends)

    def _observe(self, detection: Detection) -> tuple[Observation, PropagatedBody | None]:
        """Find the midline of the object, or say why there is none."""
        why = self._refused(detection)
        if why is not None:
            return why, None
        model, contour_body = self._track.model, None
        body, frames = self._track.body, 1 + self._track.frames_lost
        for view in without_debris(detection, model, body, frames, self._settings.cutting):
            found = self._contour_body(view)
            if view is detection:
                contour_body = found
            elif found is not None and self._is_part(found, detection, view):
                continue
            if found is not None and self._continues(found, detection):
                if model is None or detection.occlusion is None:
                    self._learn(found, view)
                model = self._track.model
                if model is not None and model.is_changing:
                    return coiled(detection), None
                agreement, residual = _agreement(found, view.blob), self._settings.residual
                return open_body(found, agreement, detection.view, model, residual), None
        return self._propagate(detection, contour_body)

    def _refused(self, detection: Detection) -> Observation | None:
        """Return why an object gives no midline, by what it is alone; None where it may."""
        blob, model, settings = detection.blob, self._track.model, self._settings
        if blob.touches(whole_picture(self._shape)):
            return Observation(Status.TOUCHES_BORDER, blob.u, blob.v)
        if model is not None and blob.area < settings.least_area_over_known * model.area:
            return Observation(Status.TOO_SMALL, blob.u, blob.v)
        if model is not None and blob.area > settings.most_area_over_known * model.area:
            if model.frames < settings.learned_frames:  # what was seen at first was not the worm
                self._track.learn(None)
            return Observation(Status.TOO_LARGE, blob.u, blob.v)
        occlusion = detection.occlusion
        if model is None and occlusion is not None and any(occlusion.occluded_ends):
            return Observation(Status.END_HIDDEN)
        return None

    def _is_part(self, found: RefinedMidline, whole: Detection, view: Detection) -> bool:
        """Tell whether what was cut out of an object is a part of the worm, not all of it."""
        model, last, settings = self._track.model, self._track.bodies.last, self._settings
        width = mean_width(found.widths) if model is None else model.width
        cut_off = np.asarray(whole.object_pixels() & ~view.object_pixels())
        if holds_wormlike_piece(cut_off, width, settings.blobs):
            return True
        is_cut = np.count_nonzero(cut_off) > settings.least_cut_end_widths2 * width**2
        goes_on = whole.goes_on_at_ends(found.points, width, cut_off)
        if is_cut and any(goes_on):
            return True  # a thin tail, say, or both ends' taper
        after_fold = self._track.frames_unresolved > 0 and not (model is None or model.is_young)
        most = settings.most_cut_after_fold_widths2 * width**2
        if after_fold and np.count_nonzero(cut_off) > most:
            return True
        hole = whole.blob.hole_area / width**2
        touching = hole > settings.most_hole_widths2 and whole.goes_on_at(found.points, width)
        if touching or hole > settings.loop_hole_widths2:
            return True  # a loop that was cut open, rather than what hangs on to the worm
        last_length = 0.0 if last is None else settings.cut_length_over_last * length_of(last)
        known_length = 0.0 if model is None else settings.cut_length_over_known * model.length
        return length_of(found.points) < max(last_length, known_length)

    def _open_midline(self, detection: Detection) -> RefinedMidline | None:
        """Return the midline of an object with the contour of an open body; None of another."""
        blob, view, settings = detection.blob, detection.view, self._settings
        model, last = self._track.model, self._track.bodies.last
        expected = model.width if model else detection.thickness()
        find = contour_midline if model else first_contour_midline
        first = find(blob.contour, expected, last, settings.contour)
        if first is None or not self._is_open_body(first, blob, expected):
            return None
        width = model.width if model else first.width
        found = refine(view.signal, view.origin, first.points, width, settings.refine)
        if model is None and looks_doubled(found, settings.doubled):
            return None
        if self._comes_reversed(found):
            found = found.reversed()
        return with_known_width(found, detection, model)

    def _contour_body(self, detection: Detection) -> RefinedMidline | None:
        """Return the midline that the object's contour gives; None where it is no simple body."""
        blob, view, settings = detection.blob, detection.view, self._settings
        model, residual = self._track.model, settings.residual
        least_dark, open_over_folded = residual.least_dark_widths2, residual.dark_open_over_folded
        if model and self._is_dark(detection, model, open_over_folded * least_dark):
            return None  # before a midline is looked for, which takes longer
        found = self._open_midline(detection)
        if found is None:
            return None
        width = model.width if model else found.width
        agreement = _agreement(found, blob)
        sharpest_s = s_turn_at_ends(
            found.points, found.width, settings.propagation.s_near_end_widths
        )
        if sharpest_s > settings.most_s_turn_of_open_rad or agreement < settings.least_agreement:
            return None
        step = length_of(found.points) / (len(found.points) - 1)
        folded = lies_near_itself(as_complex(found.points), width, step)
        if model and folded and self._is_dark(detection, model, least_dark):
            return None
        seen = found
        if model and may_hide_end(found, model, settings.most_log_shortening, residual):
            folded = True  # an end that lies on the body leaves a bend, blunter than an end
            seen = replace(found, widths=np.minimum(found.widths, model.widths))
        checked = folded or agreement < settings.agreement_of_all
        points = view.in_window(seen.points)
        explains = not checked or explains_object(
            replace(seen, points=points),
            view.found_in,
            detection.object_pixels(),
            folded,
            model,
            residual,
        )
        return found if explains else None

    def _is_dark(self, detection: Detection, model: BodyModel, least_widths2: float) -> bool:
        """Tell whether so much of an object is as dark as two strands on each other."""
        return darkening_of(detection, model, least_widths2, self._settings.residual) is not None

    def _comes_reversed(self, found: RefinedMidline) -> bool:
        """Tell whether an open body's ends are in the other order than those of the body known.

        By its widths where it was not seen as an open one a frame before; else by where it was.
        """
        model, bodies = self._track.model, self._track.bodies
        if model is not None and (bodies.last is None or bodies.propagated is not None):
            told = model.order_told(found.widths)
            if told:
                return told < 0
        return bodies.last is not None and is_nearer_reversed(found.points, bodies.last)

    def _continues(self, found: RefinedMidline, detection: Detection) -> bool:
        """Tell whether a midline can be that of the frame before, a frame later."""
        model, last, settings = self._track.model, self._track.bodies.last, self._settings
        if model is None:
            return True
        length = length_of(found.points)
        if self._was_in_part(detection.blob, length):
            return True
        known = abs(log(length / model.length)) < settings.most_log_length_over_known
        if last is None or (self._track.bodies.is_unexplained and not known):
            return known  # a body that did not explain its object tells nothing of its length
        stretch = abs(log(length / length_of(last)))
        most = settings.most_log_stretch_per_frame * self._track.elapsed_frames
        if stretch > most and detection.occluder is None:
            return False
        if not known and stretch > settings.most_log_length_over_last:
            return False
        return not model.leaps(found.points, last, 1 + self._track.frames_lost)

    def _is_open_body(self, found: ContourMidline, blob: Blob, width: float) -> bool:
        """Tell whether a contour is that of a body that does not touch itself."""
        model, settings = self._track.model, self._settings
        length = length_of(found.points)
        if blob.hole_area > settings.most_hole_widths2 * width**2:
            return False
        if found.side_difference > settings.most_side_difference:
            return False
        slim = length > settings.least_length_over_width * found.width
        if model is None:
            off = abs(log(length * found.width / blob.area))
            return slim and off < settings.most_log_area_over_midline
        if found.width > settings.most_width_over_known * width:
            return False
        if self._was_in_part(blob, length):
            return slim
        over_known = length / model.length
        return settings.least_length_over_known < over_known < settings.most_length_over_known

    def _was_in_part(self, blob: Blob, length: float) -> bool:
        """Tell whether what was seen at first was a part of the worm, or the worm laid double."""
        model, settings = self._track.model, self._settings
        if model is None or not self._track.was_folded_for_long:
            return False
        longer = log(length / model.length) > settings.most_log_length_over_known
        return longer or blob.area > settings.relearn_area_over_known * model.area

    def _learn(self, found: RefinedMidline, seen: Detection) -> None:
        """Take a sound midline into what is known of the worm."""
        model, settings = self._track.model, self._settings
        length = length_of(found.points)
        if model is None or model.is_outgrown_by(length) or self._was_in_part(seen.blob, length):
            self._track.begin_anew()
            in_fold = self._track.may_be_in_part or self._track.was_folded_for_long
            model = BodyModel.of(found, seen.blob.area, seen.gain, settings.body_model)
            model = replace(model, began_in_fold=in_fold)
        else:
            doubled = looks_doubled(found, settings.doubled)
            model = model.updated(found, seen.blob.area, seen.gain, doubled)
        line = as_complex(seen.view.in_window(found.points))
        shade = shade_along(seen.view.smooth, line, found.widths)
        self._track.learn(model.with_shade(shade, seen.gain))

    def _propagate(
        self, detection: Detection, contour_body: RefinedMidline | None
    ) -> tuple[Observation, PropagatedBody | None]:
        """Propagate the last midline; a leap that remains is said by a low confidence."""
        track, model, settings = self._track, self._track.model, self._settings
        bodies, frames = track.bodies, 1 + track.frames_lost
        if bodies.last is None and track.frames_unresolved % settings.sought_again_frames == 0:
            bodies, frames = LastBodies(track.body), 1 + track.frames_unresolved
        last = bodies.last
        if model is None or last is None:
            return coiled(detection), None
        propagation = settings.propagation
        detection = with_followed_ends(detection, model.width, last, propagation.pale_ends)
        model = as_dark_as(detection, model, propagation)
        start = bodies.to_propagate(last, model.width, propagation.first_expected_agreement)

        def find(body: PropagatedBody, ago: int) -> PropagatedBody:
            before = bodies.before if body is start else None
            return propagate(detection, model, body, before, ago, contour_body, propagation)

        found = found_from_held(find, start, frames, propagation)
        if found.agreement < settings.least_agreement:
            return coiled(detection), None
        track.learn(as_dark_as_followed(detection, model, found, propagation))
        leaps = model.leaps(found.points, last, frames)
        confidence = (settings.leap_confidence if leaps else 1.0) * found.agreement
        observation = observation_of(found, model, confidence, propagation)
        off = abs(log(found.path.length / model.length))
        lost = found.over_limits > propagation.lost_over_limits
        if lost or off > settings.most_log_length_in_fold:
            return coiled(detection), None
        if observation.status is Status.TRACKED and self._may_hide_end(detection, found.points):
            found = found.not_explaining(start.frames_unexplained + frames)
            observation = replace(observation, over_limits=found.over_limits)
        if not found.is_explained or model.is_changing or observation.is_mostly_hidden:
            return coiled(detection, observation), found
        return observation, found

    def _may_hide_end(self, detection: Detection, followed: Floats) -> bool:
        """Tell whether the open body in an object may have an end that is bent onto itself."""
        model, found = self._track.model, self._open_midline(detection)
        if model is not None and is_too_short(followed, model, self._settings.propagation):
            return True
        if model is None or found is None or not model.is_learned:
            return False
        if is_nearer_reversed(found.points, followed):
            found = found.reversed()
        return any(broad_contour_ends(found, model, self._settings.residual))

    def _with_occlusion(self, observation: Observation, occlusion: Occlusion) -> Observation:
        """Return an observation that says which part of its midline was not seen."""
        confidence = self._settings.occlusion_confidence * observation.confidence
        if not any(occlusion.occluded_ends):
            status, occluded = Status.BRIDGED, (0, 0)
        else:
            status, occluded = Status.END_HIDDEN, occluded_points(observation.points, occlusion)
        return replace(
            observation, status=status, confidence=confidence, occluded=occluded, appearance=None
        )


def _agreement(found: RefinedMidline, blob: Blob) -> float:
    """Return how well a refined body explains the object: areas and edges found."""
    return min(found.area, blob.area) / max(found.area, blob.area) * found.edges_found
