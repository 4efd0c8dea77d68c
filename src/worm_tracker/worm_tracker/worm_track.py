"""All that is remembered of the worm from frame to frame: where it lay, and its learned body."""

from dataclasses import dataclass, replace
from math import inf, nextafter

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_tracker.detection.blobs import Blob
from worm_tracker.detection.detection import DetectionPrior
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.curve import transformed_points
from worm_tracker.midline.path import BodyPath, path_of

MOST_FRAMES_SKIPPED = 15
"""Frames without a view of the rig, a second, from which on more make no difference."""


LONG_UNRESOLVED = 15
"""Frames without a midline, a second, from which on what is learned first may not be the worm."""


@dataclass(frozen=True, eq=False, slots=True)
class PropagatedBody:
    """A body that was propagated from the frame before, rather than found by its contour.

    Attributes
    ----------
    path : BodyPath
        Where it lies, in the picture's coordinates and in the order of the last one.
    agreement : float
        Intersection over union of body and object, less what its kinks cost.
    expected_agreement : float
        What the next one should have: it falls slowly where this one had more.
    centroid : complex
        Of what is seen of it, u + iv.
    end_sd_px : tuple of float
        How surely its ends are where they are said to be.
    over_limits : float
        What of body and object does not agree, over what may not.
    straighter : float
        How much straighter it would have been in the last frames with two of its strands exchanged
        where they meet, rad².
    loop_in_doubt : tuple of float, or None
        The part of its length, from where to where, that lies in loops of which it is not known
        which way round they are passed; None where it is.
    doubt_by_bends : tuple of float, or None
        The same without what marks tell: they do so of one picture, and not of the next.
    frames_unexplained : int
        How many pictures lie between it and the last one that it explained; 0 where it explains
        this one. It stays, whatever is explained later, where its strands may have changed places
        meanwhile.
    frames_explained : int
        How many pictures in a row it has explained since it was lost, with both ends told; 0 where
        it was not lost.
    was_turned : bool
        Whether a loop that is in doubt, or that is not to be seen while the body leaves something
        over, was passed the other way round since it was known.
    order_known : bool
        Whether its widths or its marks tell that its ends are in the order of the body model.
    whole_ends : tuple of bool
        Of each end whether its marks tell that the picture lacks nothing of it.
    outline_sd_px : tuple of float
        How surely the outline tells where each end on or beside the body is, where nothing else
        does; inf where it was not asked.
    broad_ends : tuple of bool
        Of each end whether the object is broader there than the body: the end may be bent back.
    hides_slack : bool
        Whether a shorter body, without a way there and back, would explain its object as well.
    is_s_at_end : bool
        Whether it makes a sharp S near an end, as no worm does.
    was_slid : bool
        Whether it was slid along itself from the picture before, so that its ends are those there.
    held : HeldBody or None
        The last body that explained its picture, where this one does not.
    """

    path: BodyPath
    agreement: float
    expected_agreement: float
    centroid: complex = complex("nan")
    end_sd_px: tuple[float, float] = (0.0, 0.0)
    over_limits: float = 0.0
    straighter: float = 0.0
    loop_in_doubt: tuple[float, float] | None = None
    doubt_by_bends: tuple[float, float] | None = None
    frames_unexplained: int = 0
    frames_explained: int = 0
    was_turned: bool = False
    order_known: bool = False
    whole_ends: tuple[bool, bool] = (False, False)
    outline_sd_px: tuple[float, float] = (inf, inf)
    broad_ends: tuple[bool, bool] = (False, False)
    hides_slack: bool = False
    is_s_at_end: bool = False
    was_slid: bool = False
    held: "HeldBody | None" = None

    @property
    def points(self) -> Floats:
        """The midline, shape (TRACKED_POINTS, 2)."""
        return self.path.points

    @property
    def loops_known(self) -> bool:
        """Whether it is known which way round its loops are passed."""
        return self.loop_in_doubt is None

    @property
    def is_explained(self) -> bool:
        """Whether it explains its object as a worm may lie, and no other body does known to."""
        odd = self.frames_unexplained or self.hides_slack or self.is_s_at_end
        return self.over_limits <= 1 and not odd

    def not_explaining(self, frames_unexplained: int) -> "PropagatedBody":
        """Return the body as one that does not explain its picture, whatever it leaves over."""
        over = max(self.over_limits, nextafter(1.0, 2.0))
        return replace(self, over_limits=over, frames_unexplained=frames_unexplained)

    def transformed(self, motion: Floats) -> "PropagatedBody":
        """Return the body where an affine map (2, 3) of the picture takes it."""
        held = self.held
        if held is not None:
            held = replace(held, body=held.body.transformed(motion))
        return replace(self, path=self.path.transformed(motion), held=held)


@dataclass(frozen=True, eq=False, slots=True)
class HeldBody:
    """The last body that explained its picture.

    Attributes
    ----------
    body : PropagatedBody
    was_slid : bool
        Whether each of those that were followed from it was slid along the one before: their ends
        are its own.
    """

    body: PropagatedBody
    was_slid: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class LastBodies:
    """The worm's midline in the last two pictures; both in the same order of the ends.

    Attributes
    ----------
    last, before : ndarray, shape (TRACKED_POINTS, 2), or None
        In the last picture and in that before it; None where the body could not be followed.
    propagated : PropagatedBody or None
        The last one, where it was propagated.
    path_number : int
        How often a body was found otherwise than by sliding the last one along itself.
    """

    last: Floats | None = None
    before: Floats | None = None
    propagated: PropagatedBody | None = None
    path_number: int = 0

    @property
    def is_unexplained(self) -> bool:
        """Whether the last one was followed, but is not known to be where the worm lay."""
        return self.propagated is not None and self.propagated.frames_unexplained > 0

    def then(self, points: Floats | None, propagated: PropagatedBody | None) -> "LastBodies":
        """Return the last two pictures' midlines, one picture later."""
        goes_on = propagated is not None and propagated.was_slid
        number = self.path_number + (not goes_on)
        return LastBodies(points, self.last, propagated, number)

    def to_propagate(self, last: Floats, width: float, expected_agreement: float) -> PropagatedBody:
        """Return the last body as one that can be propagated.

        Parameters
        ----------
        last : ndarray, shape (TRACKED_POINTS, 2)
            Its midline.
        width : float
            The worm's, pixels.
        expected_agreement : float
            What the next one should have where this one was found by its contour.
        """
        if self.propagated is not None:
            return self.propagated
        return PropagatedBody(path_of(last, self.before, width), 1.0, expected_agreement)

    def transformed(self, motion: Floats) -> "LastBodies":
        """Return the bodies where an affine map (2, 3) of the picture takes them."""
        last, before = (
            None if points is None else transformed_points(points, motion)
            for points in (self.last, self.before)
        )
        propagated = self.propagated
        if propagated is not None:
            propagated = propagated.transformed(motion)
        return LastBodies(last, before, propagated, self.path_number)


class WormTrack:
    """Remembers the worm: where it lay in the last pictures, and what its body is like.

    No other part of the tracker remembers a place in the picture that the worm was at; so that
    `transform` is all that a bump of camera or chamber needs.

    Attributes
    ----------
    model : BodyModel or None
        What has been learned of its body.
    blob : Blob or None
        The object that it was in the last picture; None where it was not seen.
    body : ndarray, shape (TRACKED_POINTS, 2), or None
        Its last midline, as long as it has not been out of view.
    bodies : LastBodies
        Its midlines in the last two pictures.
    linked : ndarray, shape (TRACKED_POINTS, 2), or None
        The last midline that has been put in the order of the ends of those before.
    bodies_begun : int
        How often a body was learned from nothing: what was held to be the worm before was not, or
        not all of it.
    frames_unresolved : int
        Frames without a midline although the worm was seen.
    """

    def __init__(self) -> None:
        self.model: BodyModel | None = None
        self.blob: Blob | None = None
        self.body: Floats | None = None
        self.bodies = LastBodies()
        self.linked: Floats | None = None
        self.bodies_begun = 0
        self.frames_unresolved = 0
        self._lost_and_over = 0, 1.0

    @property
    def frames_lost(self) -> int:
        """Frames of 15 a second since the worm was last seen."""
        return self._lost_and_over[0]

    @property
    def elapsed_frames(self) -> float:
        """How many frames of 15 a second it is from the last picture with the worm to this one."""
        lost, over_steps = self._lost_and_over
        return (1 + lost) * over_steps

    @property
    def prior(self) -> DetectionPrior:
        """What is known of the worm before a picture is looked at."""
        return DetectionPrior(self.model, self.blob, self.body, self.may_be_in_part)

    @property
    def may_be_in_part(self) -> bool:
        """Whether what is known of the worm may be a part of it, or the worm laid double.

        It began in a fold, and has not been seen for long since.
        """
        if self.model is None:
            return self.was_folded_for_long
        return self.model.is_young and (self.model.began_in_fold or self.was_folded_for_long)

    @property
    def was_folded_for_long(self) -> bool:
        """Whether it has been seen without a midline for a second or more."""
        return self.frames_unresolved >= LONG_UNRESOLVED

    @property
    def contour(self) -> Floats | None:
        """The worm's contour (u, v) in the last picture; None where it was not seen."""
        return None if self.blob is None else np.asarray(self.blob.contour, np.float64)

    def learn(self, model: BodyModel | None) -> None:
        """Take what has been learned of the body; None where it was that of something else."""
        self.model = model
        if model is None:
            self.body = None

    def begin_anew(self) -> None:
        """Take note that the next body to learn is another one than before."""
        self.bodies_begun += 1

    def see(self, blob: Blob, points: Floats | None, propagated: PropagatedBody | None) -> None:
        """Take a picture in which the worm was seen, and its midline if that was resolved."""
        self.blob = blob
        followed = points if propagated is None else propagated.points
        self.bodies = self.bodies.then(followed, propagated)
        self._lost_and_over = 0, 1.0
        self.frames_unresolved = 0 if points is not None else self.frames_unresolved + 1
        if points is not None:
            self.body = points

    def miss(self) -> None:
        """Take a picture of the rig in which the worm was not seen."""
        self.blob = self.body = None
        self.bodies = self.bodies.then(None, None)
        self._lost_and_over = self.frames_lost + 1, 1.0
        self.frames_unresolved = 0

    def skip(self, frames: int = 1, over_steps: float = 1.0) -> None:
        """Take so many frames in which the rig is not seen: the worm moves on meanwhile.

        A way that is foretold for longer than a second leads nowhere, however long it is.

        Parameters
        ----------
        frames : int
        over_steps : float
            How much longer than that and a frame it is to the next picture.
        """
        self._lost_and_over = min(self.frames_lost + frames, MOST_FRAMES_SKIPPED), over_steps

    def link(self, points: Floats) -> None:
        """Take a midline, in the order of its ends that links it to those before."""
        self.linked = points

    def transform(self, motion: Floats) -> None:
        """Take all of the worm along with a rig that has moved in the picture.

        Parameters
        ----------
        motion : ndarray, shape (2, 3)
            Affine map of old picture coordinates (u, v) to new ones.
        """
        self.blob = None if self.blob is None else self.blob.transformed(motion)
        self.bodies = self.bodies.transformed(motion)
        self.body, self.linked = (
            None if points is None else transformed_points(points, motion)
            for points in (self.body, self.linked)
        )
