"""Follows one worm from picture to picture: where it is, and its midline."""

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from worm_msgs_py.chamber import Geometry
from worm_msgs_py.status import Status
from worm_tracker.backward_propagation import carried_back
from worm_tracker.body_model import Known, length_of, mean_width, nearer_turned
from worm_tracker.detection.blobs import Blob, draw_blob, moved, thickness
from worm_tracker.detection.debris import views
from worm_tracker.detection.detector import Finder, Sight
from worm_tracker.detection.illumination import Picture
from worm_tracker.detection.object_mask import centroid_of, kept
from worm_tracker.detection.occluded_body import hidden_in, of_known_width
from worm_tracker.head_tail_appearance import marks_of
from worm_tracker.midline.contour_midline import Floats, Rough, rough_midline
from worm_tracker.midline.path import trail_of
from worm_tracker.midline.refine import Fine, refine
from worm_tracker.observation import Observation
from worm_tracker.propagation import EXPECTED, Carried, carry, observed

MOST_STRETCH = 0.15
"""Log of the length over the known one beyond which a midline after a leap is not believed."""
MOST_STRETCH_A_FRAME = 0.08
"""Log of the length over that of the frame before: this and `MOST_STRETCH` at once are an error,
because a worm does not stretch in a moment."""
LEAP_DOUBT = 0.5
"""What a leap leaves of the confidence."""
RELEARN_FRAMES, MORE = 15, 1.1
"""Frames in a row without a midline, and area over the known one, after which a slender outline of
another length is believed: the worm was seen in part at first."""
MIN_OVERLAP = 0.7
"""Least agreement of body and picture for a midline to be believed."""
SETTLED_FRAMES, SAME_LENGTH, SURE = 10, 0.035, 0.85
"""Midlines learned from, log of the length over the known one, and confidence from which all of the
worm is taken to have been seen."""
SHORTEST = 0.92
"""Length, over the known one, below which what was cut out is only a part of the worm: its stroke
shortens it by less."""
LOOP, ENTIRE = 20.0, 0.9
"""Hole, in squared widths, that may be that of a loop rather than of a bubble, and least agreement
for a midline of a part cut out of it, where nothing is known of the worm yet."""
SMALL, LARGE = 0.35, 2.2
"""Areas, relative to the worm's, that are not the worm."""


class Follower:
    """Follows the worm; one picture in, one `Observation` out.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first picture, dark worm on bright ground.
    geometry : Geometry
        The rig.
    """

    def __init__(self, picture: Picture, geometry: Geometry) -> None:
        self._finder = Finder(picture, geometry)
        self._shape = picture.shape
        self._known: Known | None = None
        self._last: Floats | None = None
        self._before: Floats | None = None
        self._carried: Carried | None = None
        self._sight: Sight | None = None
        self._lost = 0
        self._unresolved = 0

    @property
    def outline(self) -> Floats | None:
        """The worm's outline (u, v) in the last picture; None where it was not seen."""
        blob = self._finder.blob
        return None if blob is None else np.asarray(blob.contour, np.float64)

    def sight(self) -> Sight | None:
        """Return what must be kept of the last picture to look at its object later."""
        return None if self._sight is None else kept(self._sight)

    def marks(self, found: Observation) -> Floats | None:
        """Return how the ends of an open body differ in looks in the last picture, else None."""
        sight = self._sight
        if sight is None or self._carried is not None or found.status is not Status.TRACKED:
            return None
        first = sight.window[1].start, sight.window[0].start
        return marks_of(found.points, found.widths, sight.smooth, first)

    def settle(self, opened: Observation, sights: Sequence[Sight]) -> list[Observation]:
        """Return what the last picture's midline tells of those before it, the latest first.

        Parameters
        ----------
        opened : Observation
            What the last picture says; it has a midline.
        sights : sequence of Sight
            What was kept of the pictures before it, the latest first.
        """
        return [] if self._known is None else list(carried_back(self._known, opened, sights))

    def move(self, picture: Picture, geometry: Geometry, motion: Floats | None) -> None:
        """Take a new geometry, before the picture that it holds from is pushed.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        geometry : Geometry
        motion : ndarray, shape (2, 3), or None
            Affine map of old picture coordinates to new ones; None where nothing has moved.
        """
        self._finder.move(picture, geometry, motion)
        if motion is not None:
            self._last, self._before = (
                None if points is None else moved(points, motion)
                for points in (self._last, self._before)
            )
            self._carried = None

    def push(self, picture: Picture) -> Observation:
        """Look at the next picture."""
        gain = self._finder.gain(picture)
        if gain is None:
            self._sight = None
            self._lost += 1
            return Observation(Status.BAD_IMAGE)
        self._sight = sight = self._finder.find(picture, gain)
        carried, self._carried = self._carried, None
        if sight is None:
            self._lost += 1
            found = Observation(Status.AMBIGUOUS if self._finder.rivals else Status.NO_WORM)
        else:
            found = hidden_in(self._observe(sight, carried), sight)
            self._lost = 0
        resolved = len(found.points) > 0
        self._before, self._last = self._last, found.points if resolved else None
        self._unresolved = 0 if resolved or sight is None else self._unresolved + 1
        self._finder.learn(picture, gain, found.points, self._entire(found))
        return found

    def _observe(self, sight: Sight, carried: Carried | None) -> Observation:
        """Find the midline of the object, or say why there is none."""
        blob, known = sight.blob, self._known
        if blob.touches((slice(0, self._shape[0]), slice(0, self._shape[1]))):
            return Observation(Status.TOUCHES_BORDER, blob.u, blob.v)
        if known is not None and blob.area < SMALL * known.area:
            return Observation(Status.TOO_SMALL, blob.u, blob.v)
        if known is not None and blob.area > LARGE * known.area:
            if known.frames < SETTLED_FRAMES:  # what was seen at first was not the worm
                self._known = None
            return Observation(Status.TOO_LARGE, blob.u, blob.v)
        if known is None and sight.joined is not None and any(sight.joined.hidden):
            return Observation(Status.END_HIDDEN)
        fine = None
        for view in views(sight, known, self._finder.body):
            fine = self._outlined(view)
            if known is None and view is not sight and _is_loop(fine, sight, view):
                continue  # a loop that was cut open, rather than what hangs on to the worm
            if known is not None and view is not sight and _lacks(fine, known):
                continue  # a part of the worm was cut off, rather than what hangs on to it
            if fine is not None and self._continues(fine):
                if known is None or sight.joined is None:
                    self._learn(fine, view.blob)
                return _seen(fine, _agreement(fine, view.blob))
        return self._carry(sight if known is None else view, carried, fine)

    def _outlined(self, sight: Sight) -> Fine | None:
        """Return the midline that the object's outline gives; None where it is no simple body."""
        blob, known = sight.blob, self._known
        expected = known.width if known else _thickness(sight)
        rough = rough_midline(blob.contour, expected, self._last)
        if rough is None or not self._sound(rough, blob, expected):
            return None
        offset = (sight.window[1].start, sight.window[0].start)
        fine = refine(sight.signal, offset, rough.points, known.width if known else rough.width)
        if self._last is not None and nearer_turned(fine.points, self._last):
            fine = replace(fine, points=fine.points[::-1], widths=fine.widths[::-1])
        fine = of_known_width(fine, sight, known)
        return fine if _agreement(fine, blob) >= MIN_OVERLAP else None

    def _entire(self, found: Observation) -> bool:
        """Tell whether a midline is that of all of the worm: what is elsewhere is not worm."""
        known = self._known
        if known is None or not len(found.points) or known.frames < SETTLED_FRAMES:
            return False
        same = abs(log(length_of(found.points) / known.length)) < SAME_LENGTH
        return (
            same
            and found.status is Status.TRACKED
            and found.confidence > SURE
            and self._carried is None
        )

    def _continues(self, fine: Fine) -> bool:
        """Tell whether a midline can be that of the frame before, a frame later."""
        known, last = self._known, self._last
        if known is None or last is None:
            return True
        length = length_of(fine.points)
        odd = abs(log(length / known.length)) > MOST_STRETCH
        if odd and abs(log(length / length_of(last))) > MOST_STRETCH_A_FRAME:
            return False
        return not known.leaps(fine.points, last, 1 + self._lost)

    def _sound(self, rough: Rough, blob: Blob, width: float) -> bool:
        """Tell whether an outline is that of a body that does not touch itself."""
        length = length_of(rough.points)
        if blob.hole_area > 0.15 * width**2 or rough.unequal > 0.3:
            return False
        if self._known is None:
            off = abs(log(length * rough.width / blob.area))
            return length > 2.5 * rough.width and off < 0.35
        if rough.width > 1.35 * width:
            return False
        if self._was_in_part(blob):
            return length > 2.5 * rough.width
        return 0.75 < length / self._known.length < 1.35

    def _was_in_part(self, blob: Blob) -> bool:
        """Tell whether the worm has long been too large for what was seen of it at first."""
        known = self._known
        larger = known is not None and blob.area > MORE * known.area
        return larger and self._unresolved >= RELEARN_FRAMES

    def _learn(self, fine: Fine, blob: Blob) -> None:
        """Take a sound midline into what is known of the worm."""
        if self._known is None or self._was_in_part(blob):
            self._known = Known.of(fine, blob.area)
        else:
            self._known.learn(fine, fine.widths, blob.area)
        self._finder.expect(self._known)

    def _carry(self, sight: Sight, carried: Carried | None, fine: Fine | None) -> Observation:
        """Carry the last midline on; a leap that remains is said by a low confidence."""
        known, last = self._known, self._last
        if known is None or last is None:
            return _coiled(sight)
        frames = 1 + self._lost
        if carried is None:
            carried = Carried(trail_of(last, self._before, known.width), 1.0, EXPECTED)
        found = carry(sight, known, carried, self._before, frames, fine)
        if found.worth < MIN_OVERLAP:
            return _coiled(sight)
        self._carried = found
        doubt = LEAP_DOUBT if known.leaps(found.points, last, frames) else 1.0
        return observed(sight, found.points, known, doubt * found.worth)


def _seen(fine: Fine, confidence: float) -> Observation:
    """Return the observation of a refined midline."""
    width = mean_width(fine.widths)
    return Observation(Status.TRACKED, fine.u, fine.v, fine.points, fine.widths, confidence, width)


def _coiled(sight: Sight) -> Observation:
    """Return the observation of an object without a midline."""
    return Observation(Status.COILED, *centroid_of(sight))


def _is_loop(fine: Fine | None, sight: Sight, view: Sight) -> bool:
    """Tell whether what was cut out is a part of a loop: of a wide one, and not well explained."""
    if fine is None:
        return False
    wide = sight.blob.hole_area > LOOP * mean_width(fine.widths) ** 2
    return wide and _agreement(fine, view.blob) < ENTIRE


def _lacks(fine: Fine | None, known: Known) -> bool:
    """Tell whether a midline is too short to be that of all of the worm."""
    return fine is not None and length_of(fine.points) < SHORTEST * known.length


def _agreement(fine: Fine, blob: Blob) -> float:
    """Return how well a refined body explains the object: areas and edges found."""
    return min(fine.area, blob.area) / max(fine.area, blob.area) * fine.seen


def _thickness(sight: Sight) -> float:
    """Return a first guess of the body's width, from the distance to the outline."""
    return thickness(draw_blob(sight.blob, sight.window))
