"""Bodies that may be the worm's in an object that touches itself, and how well each explains it.

A body is slid along itself; its bends and ends are laid anew where something is left over; and a
deformable one is fitted where that does not do.
"""

from dataclasses import dataclass, replace
from math import log, sqrt

import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.detection.detection import Detection
from worm_tracker.midline.body_model import (
    BodyModel,
    end_displacement,
    ends_changed_places,
    is_nearer_reversed,
)
from worm_tracker.midline.body_residual import (
    ObjectMasks,
    ends_and_bends,
    unexplained,
)
from worm_tracker.midline.curve import as_points, length_of
from worm_tracker.midline.deformable_fit import fit_body
from worm_tracker.midline.expected_body import ExpectedBody
from worm_tracker.midline.hidden_slack import without_slack
from worm_tracker.midline.path import BodyPath, path_of, sharpest_turn
from worm_tracker.midline.path_following import slide_along_path
from worm_tracker.midline.refine import RefinedMidline
from worm_tracker.midline.self_cover import ends_on_body, lies_near_itself
from worm_tracker.midline.strand_exchange import DoubtfulLoop, part_of
from worm_tracker.midline.way_by_marks import MarkedLoop, MarksOnPath, marked_loops
from worm_tracker.propagation.beside_ends import broad_ends, end_over_limits_at, ends_lack
from worm_tracker.propagation.candidate import Candidate
from worm_tracker.propagation.end_sureness import (
    end_sd_px_of,
    half_widths_along,
    most_end_sd_px,
    outline_sd_px,
    s_at_end,
    whole_ends,
)
from worm_tracker.propagation.explained_again import explained_again
from worm_tracker.propagation.loops_in_doubt import loops_in_doubt
from worm_tracker.propagation.object_seen import object_in
from worm_tracker.propagation.only_explanation import is_only_explanation
from worm_tracker.propagation.order_of_ends import score_by_marks_or_widths, score_by_widths
from worm_tracker.propagation.overlaps import marked_ends
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody


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
        seen, last = object_in(detection, model, settings), body.path.shifted(-origin)
        levels = model.levels_at(detection.gain)
        return cls(detection.view.signal, seen, levels, origin, model, body, last, frames, settings)

    @property
    def is_followed(self) -> bool:
        """Whether the body was seen so lately that it has kept its ends and loops."""
        return self.frames <= self.settings.most_frames_followed

    @property
    def frames_between(self) -> int:
        """How many pictures lie between this one and the last that the body explained."""
        return self.body.frames_unexplained + self.frames - 1

    @property
    def is_lost(self) -> bool:
        """Whether too many pictures lie between to take what explains this one for the body."""
        return self.frames_between > self.settings.most_frames_unexplained

    @property
    def length_scatter_px(self) -> float:
        """How far a folded body's length may be from the known one."""
        settings, model = self.settings, self.model
        relative = settings.length_sd_over_scatter * model.length_scatter
        return model.length * max(settings.least_length_scatter, relative)

    def keeps_ends(self, slid: Candidate) -> bool:
        """Tell whether a body slid along itself has its ends in the order of the last one's.

        Where both ends were laid anew, each may have come to lie where the other one was.
        """
        if slid.turned_round or not self.is_followed:
            return False
        least_px = self.settings.least_way_of_changed_ends_widths * self.model.width
        return not ends_changed_places(slid.path.points, self.last.points, least_px)

    def in_picture(self, found: Candidate) -> PropagatedBody:
        """Return a body in the picture's coordinates, and with what is expected of the next one."""
        lost = self.settings.expected_agreement_lost_per_frame
        expected = max(found.agreement, self.body.expected_agreement - lost)
        path = found.path.shifted(self.origin)
        first, last = found.end_sd_px
        model, width = self.model, self.model.width
        lacks_first, lacks_last = self.ends_lack(found)
        differs_first, differs_last = (over > 1 for over in self.ends_over_limits(found))
        in_doubt = self.loops_in_doubt(found)
        marked = self.told_by_marks(found.path) if in_doubt else []
        untold = part_of([loop for loop in in_doubt if loop not in marked])
        body = PropagatedBody(
            path,
            found.agreement,
            expected,
            self.origin + found.unexplained.centroid(is_marked=model.is_marked),
            (
                max(first, (lacks_first or differs_first) * width),
                max(last, (lacks_last or differs_last) * width),
            ),
            self.over_limits(found),
            found.straighter,
            untold,
            part_of(in_doubt),
            self.frames_unexplained(found),
            was_turned=self.stays_turned(found, bool(in_doubt)),
            order_known=self.order_known(found, untold),
            broad_ends=broad_ends(found, self.signal, self.levels, width, self.settings),
            hides_slack=self.hides_slack(found),
            is_s_at_end=s_at_end(found.path, width, self.settings),
            whole_ends=whole_ends(self.signal, found.path, model, self.levels, self.settings),
            outline_sd_px=outline_sd_px(self.seen.mask, found, model, self.settings),
        )
        return explained_again(body, self.body, self.frames, model, self.settings)

    def hides_slack(self, found: Candidate) -> bool:
        """Tell whether a shorter body, which leaves out a way there and back, explains as much."""
        if self.seen.dark is not None or self.over_limits(found) > 1:
            return False
        model, slack = self.model, self.settings.slack
        return any(
            way.length > slack.least_length_over_known * model.length
            and self.over_limits(self.scored(way, model.widths)) <= 1
            for way in without_slack(found.path, model.width, self.settings.doubt, slack)
        )

    def order_known(self, found: Candidate, untold: tuple[float, float] | None) -> bool:
        """Tell whether a body that explains the picture shows which of its ends is which.

        By what lies in no loop in doubt; those lie in a part of its length, from where to where.
        """
        if self.over_limits(found) > 1:
            return False
        order = self.model.settings.order
        if untold is not None:
            return self.order_score(found, untold) > order.least_score_of_part
        score = self.order_score(found) if found.order_score is None else found.order_score
        return score > order.least_score

    def order_score(self, found: Candidate, untold: tuple[float, float] | None = None) -> float:
        """Return how well a body, or all but a part of it, tells its ends' order, -1 to 1."""
        path, mask, model = found.path, self.seen.mask, self.model
        if untold is not None:
            return score_by_widths(path, mask, model, untold)
        marks = self.marks_on(path)
        return score_by_marks_or_widths(path, mask, model, marks, self.settings.marks)

    def ends_lack(self, found: Candidate) -> tuple[bool, bool]:
        """Tell of each end whether it lies on the body and something is missing beside it."""
        return ends_lack(found, self.seen, self.model.width, self.settings)

    def ends_over_limits(self, found: Candidate) -> tuple[float, float]:
        """Return how much the picture differs from the body beside each end that lies on it.

        Over what it may; 0 for an end in clear water.
        """
        curve, near_px = found.path.curve, self.settings.near_end_widths * self.model.width
        on_body = ends_on_body(curve, near_px, found.path.step)
        first, last = (
            self.end_over_limits_at(found, complex(end)) if on else 0.0
            for on, end in zip(on_body, curve[[0, -1]], strict=True)
        )
        return first, last

    def end_over_limits_at(self, found: Candidate, place: complex) -> float:
        """Return how much the picture differs from the body near a place, over what it may."""
        return end_over_limits_at(
            self.signal, found.path, place, self.seen, self.model, self.levels, self.settings
        )

    def frames_unexplained(self, found: Candidate) -> int:
        """Return `frames_between`, 0 where a body is known to be the one that was followed.

        Strands that lie side by side are alike. After too long without an explanation either may
        be the other: that its contour shows it, or nothing else explains the picture, tells.
        """
        over, told = self.over_limits(found), self.seen.dark is not None
        if over > 1:
            return self.frames_between + 1
        if not self.is_lost:
            return 0
        marked = self.told_by_marks(found.path)
        alone = is_only_explanation(found, over, told, self.model.width, marked, self.settings)
        return 0 if alone else self.frames_between

    def loops_in_doubt(self, found: Candidate) -> list[DoubtfulLoop]:
        """Return the loops of a body which may be passed either way round, by its bends."""
        body, settings, turned = self.body, self.settings, self.was_turned(found)
        may_be_known = self.is_followed and not turned
        lost_rad2 = settings.bend_lost_of_turned_rad2 if turned else settings.bend_lost_rad2
        sd_px, width = end_sd_px_of(body, self.model, settings), self.model.width
        return loops_in_doubt(found.path, body, may_be_known, lost_rad2, sd_px, width, settings)

    def told_by_marks(self, path: BodyPath) -> list[DoubtfulLoop]:
        """Return the loops of a path that marks say are passed as it has them."""
        least = self.settings.marks.least_log_odds
        return [each.loop for each in self.marked_loops(path) if each.log_odds > least]

    def marked_loops(self, path: BodyPath) -> list[MarkedLoop]:
        """Return the loops of a path, and what marks say of each; none where none are known."""
        marks, settings = self.marks_on(path), self.settings
        if marks is None:
            return []
        least = settings.least_breadth_widths
        return marked_loops(marks, path, self.model.width, settings.doubt, least)

    def marks_on(self, path: BodyPath) -> MarksOnPath | None:
        """Return what is seen of a skin's marks along a path; None where none are known."""
        if self.seen.shaded is None:
            return None
        model = self.model
        widths = 2 * half_widths_along(path, model)
        return MarksOnPath.on(self.seen.shaded, path, widths, model.width, self.settings.marks)

    def was_turned(self, found: Candidate) -> bool:
        """Tell whether loops in doubt were passed the other way round since they were known."""
        return found.was_exchanged or self.body.was_turned

    def stays_turned(self, found: Candidate, is_in_doubt: bool) -> bool:
        """Tell whether loops passed the other way round are not known yet.

        While the body leaves something over it may lie so that none is to be seen.
        """
        return self.was_turned(found) and (is_in_doubt or self.over_limits(found) > 1)

    def over_limits(self, found: Candidate) -> float:
        """Return how many times what may be left over is."""
        return found.unexplained.over_limits(self.model.width, self.settings.residual)

    def slid(self, path: BodyPath) -> Candidate | None:
        """Return a body slid along itself."""
        model, settings = self.model, self.settings
        length = path.length + (path.ways[0] - path.ways[1]) * self.frames
        sd = settings.length_sd_relative * model.length * sqrt(self.frames)
        scatter = self.length_scatter_px
        weight = sd**2 / (sd**2 + scatter**2)
        length, sd = length + weight * (model.length - length), sd * sqrt(1 - weight)
        marked, pale = model.is_marked, marked_ends(model, settings)
        expected = ExpectedBody(
            model.widths, self.levels, length, sd, model.darkening, marked, pale
        )
        slid = slide_along_path(
            self.signal, path, self.body.end_sd_px, expected, self.frames, settings.path_following
        )
        if slid is None:
            return None
        found = self.scored(slid.path, model.widths)
        return replace(found, end_sd_px=(slid.ends[0].sd, slid.ends[1].sd))

    def turned_round(self, found: Candidate) -> Candidate:
        """Return a body the other way round where its marks or widths tell so, else itself.

        In a fold an end may have been taken for the other one: what is slid on from there lies
        right, and is drawn with its tail as wide as a head.
        """
        score = self.order_score(found)
        if score > -self.model.settings.order.least_score:
            return replace(found, order_score=score)
        turned = self.scored(found.path.turned_round(), self.model.widths)
        was_wrong = is_nearer_reversed(turned.path.points, self.last.points)
        return replace(
            turned,
            end_sd_px=found.end_sd_px[::-1],
            flanks_sd_px=found.flanks_sd_px[::-1],
            order_score=-score,
            turned_round=was_wrong,
            was_exchanged=True,  # its ends have been exchanged on the way, and what is between
        )

    def best(
        self, slid: Candidate | None, starts: list[Floats], contour_body: RefinedMidline | None
    ) -> Candidate:
        """Return the best of all that can be tried, fits from some starts among them."""
        others = [] if slid is None else [slid]
        if slid is None or self.over_limits(slid) < self.settings.most_over_limits_of_fitted:
            starts = [*starts, *(each.path.points for each in others)]
            others.append(self.reslid(max(map(self.fitted, starts), key=self.score)))
        if contour_body is not None and not self.hides_a_part(contour_body):
            others.append(self.by_contour(contour_body))
        return max(others, key=self.score)

    def hides_a_part(self, contour_body: RefinedMidline) -> bool:
        """Tell whether a part of the body that the contour gives may lie on itself.

        It lay near itself a picture before, and was longer than it can have shortened.
        """
        shortened = log(self.last.length / length_of(contour_body.points))
        if shortened < self.settings.most_log_shortening_per_frame * self.frames:
            return False
        return lies_near_itself(self.last.curve, self.model.width, self.last.step)

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

    def reslid(self, found: Candidate) -> Candidate:
        """Return a body slid from where it was found, if it agrees about as well there."""
        slid = self.slid(found.path)
        least = found.agreement - self.settings.most_agreement_lost_resliding
        return found if slid is None or slid.agreement < least else slid

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
            width, residual = self.model.width, self.settings.residual
            ends = ends_and_bends(path.points, width, residual)
            lacks = self.model.lacks(path.length, differs.left_over)
            if not lacks and not differs.wants_near(ends, residual.end_widths * width):
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
        """Tell whether an end is farther from where it was than it can have got.

        An end that was hidden may have been elsewhere.
        """
        points, last = found.path.points, self.last.points
        most_px = most_end_sd_px(self.body, self.model, self.settings)
        seen = [sd < most_px for sd in end_sd_px_of(self.body, self.model, self.settings)]
        if all(seen):
            return self.model.leaps(points, last, self.frames)
        far = self.model.settings.most_end_step_px(self.model.width, self.model.length)
        moved = np.hypot(*(points[[0, -1]] - last[[0, -1]]).T)
        return bool((moved[seen] > far * self.frames).any())
