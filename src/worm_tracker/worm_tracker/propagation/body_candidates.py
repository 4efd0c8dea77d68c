"""Bodies that may be the worm's in an object that touches itself, and how well each explains it.

A body is slid along itself; its bends and ends are laid anew where something is left over; and a
deformable one is fitted where that does not do.
"""

from dataclasses import dataclass, field, replace
from math import log, sqrt

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.detection.detection import Detection
from worm_tracker.midline.body_model import BodyModel, end_displacement
from worm_tracker.midline.body_residual import (
    BodyResidualSettings,
    ObjectMasks,
    Unexplained,
    dark_places,
    unexplained,
)
from worm_tracker.midline.curve import as_points
from worm_tracker.midline.deformable_fit import BodyFitSettings, fit_body
from worm_tracker.midline.path import BodyPath, path_of, sharpest_turn
from worm_tracker.midline.path_following import (
    ExpectedBody,
    PathFollowingSettings,
    slide_along_path,
)
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.midline.regrown_ends import RegrownEndsSettings, regrown
from worm_tracker.midline.self_cover import lies_near_itself
from worm_tracker.midline.strand_exchange import (
    StrandExchangeSettings,
    doubtful_loops,
    exchanged_strands,
)
from worm_tracker.midline.strand_shift import StrandShiftSettings, shifted_strands
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
    most_agreement_lost_unsure: float = 0.06
    """The same where a slid body does not explain all: it is followed, but not told."""
    most_agreement_lost_resliding: float = 0.02
    """How much less than the fitted body the one slid from it, below a pixel, may have."""
    end_displacement_cost_per_length: float = 0.3
    """What moving an end by a length takes off a body's score."""
    log_stretch_cost: float = 1.0
    """What a unit of log length takes off it."""
    free_log_stretch: float = 0.05
    """Log of the length over the known one that costs nothing: a worm's own stroke."""
    unexplained_cost_per_width2: float = 0.15
    """What a squared width that is not explained takes off it."""
    end_part_widths: float = 2.0
    """How much of the body an end is that may taper."""
    most_stretches: int = 3
    """How often a bend is laid anew."""
    most_end_sd_widths: float = 0.35
    """Standard deviation of an end's place from which on it is told as hidden."""
    near_end_widths: float = 1.1
    """How near another part of the body an end lies on it or against it."""
    lost_over_limits: float = 6.0
    """How many times what may be left over is left where a body is lost, and others are tried: each
    takes long."""
    most_turn_rad_per_width: float = 2.0
    """Turn over a width beyond which a midline has a kink: half a turn is a body laid double."""
    kink_cost_per_rad: float = 0.05
    """What a radian more takes off its agreement."""
    length_sd_over_scatter: float = 2.0
    least_length_scatter: float = 0.03
    """How far a folded body's length may be from the known one: that many mean deviations of the
    open body's."""
    length_sd_relative: float = 0.04
    """How far the length of a body that strokes gets from what is expected, in a frame."""
    open_loop_widths: float = 2.0
    """Breadth of a loop from which on it is open: the strands of a narrower one touch, and may
    cross each other unseen."""
    most_frames_unexplained: int = 5
    """Most pictures in a row that a body may leave unexplained and still be the one followed."""
    least_agreement_backwards: float = 0.75
    """What a body that is propagated backwards must have: nothing else supports it."""
    most_agreement_lost_backwards: float = 0.04
    """How much less than expected it may have."""
    most_fits_backwards: int = 12
    """Pictures in which a body may be fitted that does not slide there: many would take long."""
    regrow: RegrownEndsSettings = field(default_factory=RegrownEndsSettings)
    exchange: StrandExchangeSettings = field(default_factory=StrandExchangeSettings)
    shift: StrandShiftSettings = field(default_factory=StrandShiftSettings)
    residual: BodyResidualSettings = field(default_factory=BodyResidualSettings)
    path_following: PathFollowingSettings = field(default_factory=PathFollowingSettings)
    fit: BodyFitSettings = field(default_factory=BodyFitSettings)


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """A body in the window, and how well it agrees with the object.

    Attributes
    ----------
    path : BodyPath
        Where it lies, in the window's coordinates.
    agreement : float
        Intersection over union of body and object, less what its kinks cost.
    unexplained : Unexplained
        What of the two does not agree.
    end_sd_px : tuple of float
        How surely its ends are where they are said to be.
    straighter : float
        As in `PropagatedBody`: how much straighter it would be with two of its strands exchanged.
    """

    path: BodyPath
    agreement: float
    unexplained: Unexplained
    end_sd_px: tuple[float, float] = (0.0, 0.0)
    straighter: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class CandidateSearch:
    """An object in its window, and the worm that is to explain it."""

    signal: Picture
    seen: ObjectMasks
    levels: Floats
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
    ) -> "CandidateSearch":
        """Return the search for a body in a detection."""
        origin = complex(*detection.view.origin)
        mask, last = detection.object_pixels(), body.path.shifted(-origin)
        dark = None
        if model.darkening > settings.residual.least_darkening:
            level = model.level * detection.gain / model.gain
            dark = dark_places(detection.view.smooth, level, model.darkening, settings.residual)
        seen = ObjectMasks(mask, dark, model.width, settings.residual)
        levels = model.levels_at(detection.gain)
        return cls(detection.view.signal, seen, levels, origin, model, body, last, frames, settings)

    def in_picture(self, found: Candidate) -> PropagatedBody:
        """Return a body in the picture's coordinates, and with what is expected of the next one."""
        lost = self.settings.expected_agreement_lost_per_frame
        expected = max(found.agreement, self.body.expected_agreement - lost)
        path = found.path.shifted(self.origin)
        return PropagatedBody(
            path,
            found.agreement,
            expected,
            self.origin + found.unexplained.centroid(),
            found.end_sd_px,
            self.over_limits(found),
            found.straighter,
            self.loops_known(found.path),
            self.frames_unexplained(found),
        )

    def frames_unexplained(self, found: Candidate) -> int:
        """Return how many pictures lie between this one and the last that the body explained.

        Strands that lie side by side are alike. After too long without an explanation either may
        be the other, and what explains the picture again is not known to be the body that was
        followed, until its contour shows it and goes on where that was.
        """
        between = self.body.frames_unexplained + self.frames - 1
        if self.over_limits(found) > 1:
            return between + 1
        return 0 if between <= self.settings.most_frames_unexplained else between

    def loops_known(self, path: BodyPath) -> bool:
        """Tell whether it is known which way round the loops of a path are passed.

        One in doubt that has been followed, and open, since it was known is passed as it was.
        """
        breadths = doubtful_loops(path, self.model.width, self.settings.exchange)
        open_px = self.settings.open_loop_widths * self.model.width
        was_known = self.body.loops_known and self.frames == 1
        return not breadths or (was_known and min(breadths) > open_px)

    def over_limits(self, found: Candidate) -> float:
        """Return how many times what may be left over is."""
        return found.unexplained.over_limits(self.model.width, self.settings.residual)

    def slid(self, path: BodyPath) -> Candidate | None:
        """Return a body slid along itself."""
        model, settings = self.model, self.settings
        length = path.length + (path.ways[0] - path.ways[1]) * self.frames
        sd = settings.length_sd_relative * model.length * sqrt(self.frames)
        scatter = model.length * max(
            settings.least_length_scatter, settings.length_sd_over_scatter * model.length_scatter
        )
        weight = sd**2 / (sd**2 + scatter**2)
        length, sd = length + weight * (model.length - length), sd * sqrt(1 - weight)
        expected = ExpectedBody(model.widths, self.levels, length, sd, model.darkening)
        slid = slide_along_path(
            self.signal, path, self.body.end_sd_px, expected, self.frames, settings.path_following
        )
        if slid is None:
            return None
        found = self.scored(slid.path, model.widths)
        return replace(found, end_sd_px=(slid.ends[0].sd, slid.ends[1].sd))

    def followed(self) -> Candidate | None:
        """Return the last body slid along itself, its strands, bends and ends laid anew."""
        found = self.slid(self.last)
        if found is None:
            return None
        if self.over_limits(found) > 1:
            found = self.regrown(found)
        return self.exchanged(found)

    def exchanged(self, found: Candidate) -> Candidate:
        """Return a body with two strands exchanged where it is straighter and explains as much."""
        width, settings = self.model.width, self.settings.exchange
        path, gain = exchanged_strands(found.path, width, settings)
        gain += settings.kept_gain * self.body.straighter
        found = replace(found, straighter=gain)
        if path is None or gain < settings.least_gain_in_all_rad2:
            return found
        again = self.slid(path)
        if again is None:
            return found
        again = again if self.over_limits(again) <= 1 else self.regrown(again)
        if self.over_limits(again) > max(self.over_limits(found), 1.0):
            return found
        if exchanged_strands(again.path, width, settings)[0] is not None:
            return found  # neither is straighter
        if end_displacement(again.path.points, found.path.points) > width:
            return found  # what lies between the strands is turned round, the ends stay
        return replace(again, path=replace(again.path, ways=found.path.ways))

    def regrown(self, found: Candidate) -> Candidate:
        """Return a body with bends or ends laid anew where that explains more of the object."""
        for _ in range(self.settings.most_stretches):
            wanted = found.unexplained.wanted
            paths = shifted_strands(found.path, wanted, self.model.width, self.settings.shift)
            tried = [self.scored(path, self.model.widths) for path in paths]
            best = min([found, *tried], key=lambda one: one.unexplained.total)
            if best is found:
                break
            found = replace(best, end_sd_px=found.end_sd_px)
        near = self.settings.residual.end_widths * self.model.width
        if not found.unexplained.wants_near(found.path.points[[0, -1]], 2 * near):
            return found
        for last_end in (False, True):
            path = regrown(
                found.path,
                self.seen.mask,
                found.unexplained.wanted,
                self.model.width,
                self.end_width(last_end),
                last_end,
                self.settings.regrow,
            )
            if path is None:
                continue
            slid = self.slid(path)
            if slid is not None and slid.unexplained.total < found.unexplained.total:
                found = slid
        return found

    def end_width(self, last_end: bool) -> float:
        """Return the mean width of the body's last few widths, in pixels."""
        widths = self.model.widths[::-1] if last_end else self.model.widths
        per_point = self.model.length / (len(widths) - 1)
        count = max(3, round(self.settings.end_part_widths * self.model.width / per_point))
        return float(widths[:count].mean())

    def best(
        self, slid: Candidate | None, starts: list[Floats], contour_body: RefinedMidline | None
    ) -> Candidate:
        """Return the best of all that can be tried, fits from some starts among them."""
        starts = starts if slid is None else [*starts, slid.path.points]
        fitted = [self.fitted(start) for start in starts]
        best = max(fitted, key=self.score)
        sharper = self.slid(best.path)
        least = best.agreement - self.settings.most_agreement_lost_resliding
        if sharper is not None and sharper.agreement >= least:
            best = sharper
        others = [best] if slid is None else [slid, best]
        if contour_body is not None:
            others.append(self.by_contour(contour_body))
        return max(others, key=self.score)

    def by_contour(self, found: RefinedMidline) -> Candidate:
        """Return the body that the contour gives."""
        path = path_of(found.points, None, self.model.width).shifted(-self.origin)
        return self.scored(path, found.widths)

    def contracted(self, contour_body: RefinedMidline | None) -> Candidate | None:
        """Return an open body of another length than before; None where an end may be hidden.

        An end hides on the body alone: where the body lay apart from itself and does so now, what
        the contour shows is all of it, and no other body need be tried.
        """
        if contour_body is None:
            return None
        found = self.by_contour(contour_body)
        for path in (self.last, found.path):
            if lies_near_itself(path.curve, self.model.width, path.step):
                return None
        return None if self.over_limits(found) > 1 or self.leaps(found) else found

    def fitted(self, start: Floats) -> Candidate:
        """Return a deformable body fitted from a start."""
        model = self.model
        points = fit_body(self.seen.mask, start, model.widths, model.length, self.settings.fit)
        return self.scored(path_of(points, None, model.width), model.widths)

    def scored(self, path: BodyPath, widths: Floats) -> Candidate:
        """Return a body with its agreement."""
        turn = sharpest_turn(path, self.model.width)
        kink = max(turn - self.settings.most_turn_rad_per_width, 0.0)
        at = np.linspace(0, len(widths) - 1, len(path.curve))
        differs = unexplained(
            self.seen,
            as_points(path.curve),  # finer than the midline's points: those cut hairpins short
            np.interp(at, np.arange(len(widths)), widths),
        )
        if differs.left_over and not lies_near_itself(path.curve, self.model.width, path.step):
            near = self.settings.residual.end_widths * self.model.width
            if not differs.wants_near(path.points[[0, -1]], near):
                differs = replace(differs, left_over=0.0)  # debris that hangs on to an open body
        agreement = differs.agreement - self.settings.kink_cost_per_rad * kink
        return Candidate(path, agreement, differs)

    def score(self, found: Candidate) -> float:
        """Return the agreement, less what the ends' displacement and the length cost."""
        model, settings = self.model, self.settings
        way = end_displacement(found.path.points, self.last.points) / model.length / self.frames
        stretch = max(abs(log(found.path.length / model.length)) - settings.free_log_stretch, 0.0)
        cost = settings.end_displacement_cost_per_length * way
        cost += settings.unexplained_cost_per_width2 * found.unexplained.total
        return found.agreement - cost - settings.log_stretch_cost * stretch

    def leaps(self, found: Candidate) -> bool:
        """Tell whether an end is farther from where it was than it can have got."""
        return self.model.leaps(found.path.points, self.last.points, self.frames)
