"""What has been learned of this worm's body: its length, widths, area and darkness."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_tracker.midline.body_shade import BodyShade, marks_of
from worm_tracker.midline.curve import length_of, median_of
from worm_tracker.midline.order_by_widths import OrderSettings, score_of_widths
from worm_tracker.midline.refine import RefinedMidline


@dataclass(frozen=True, slots=True)
class BodyModelSettings:
    """How fast the body model follows, and how far a body's ends get in a frame."""

    least_weight_of_new_frame: float = 0.02
    """Weight of a frame in the running means after the first ones: a memory of 50 frames."""
    weight_of_new_darkening: float = 0.2
    """Weight of a frame in the running mean of how dark overlaps are."""
    least_weight_of_new_overlap: float = 0.1
    overlap_frames: int = 3
    """The same for overlaps of a body that was followed, and frames from which on that is known."""
    well_known_overlap_frames: int = 30
    most_overlaps_left_out: int = 7
    """Frames from which on it is known so well that it is measured seldom, and pictures in a row in
    which it is not: one takes 2 to 5 ms."""
    learned_frames: int = 30
    """Midlines from which on widths and length are known well enough to go back through a fold."""
    order_frames: int = 3
    """Midlines from which on its widths tell which end is which: the ends differ by more than any
    picture does."""
    shade_frames: int = 30
    """Midlines from which on the signal of each of its places is."""
    young_frames: int = 150
    """Midlines until which the first ones may have been of a body laid double, or seen in part."""
    order: OrderSettings = field(default_factory=OrderSettings)
    most_log_growth: float = 0.15
    """Log of a length over the first one that shows it: a stroke makes up less."""
    changing_frames: int = 60
    most_profile_scatter: float = 0.04
    most_looking_doubled: float = 0.45
    """Midlines from which on it is known whether they are of one open body; mean difference of its
    profile from picture to picture, relative, and part of the pictures in which it looks doubled,
    beyond both of which they are not: a fold travels along the body."""
    varying_frames: int = 300
    most_profile_scatter_of_wide: float = 0.03
    wide_px: float = 12.0
    """Midlines until which a body as wide as this stays young while its profile scatters by more:
    it may be laid double, and look like a shorter open one. Narrower ones differ as much by their
    noise. One that has not grown for so long is believed: of 74 films the last one that was laid
    double was found to be by 232, the one before by 169; real worms scatter as much for good."""
    profile_end_part: float = 0.125
    profile_nodes: int = 5
    """How much of either end its profile leaves out, and over how many nodes it is taken."""
    pale_end_over_body: float = 0.58
    pale_end_width_over_body: float = 0.6
    pale_end_widths: tuple[float, float] = (2.0, 5.0)
    """Median signal of an end over the body's below which it is pale, the width over the body's
    from which on it is so by itself, and from where to where from its tip both are taken: any tip
    is blurred, a pale one may be dark."""
    least_marks: float = 0.06
    """How far a skin's signal differs along it, over itself, from which on it has marks: they hide
    where two strands lie on each other."""
    least_missing_widths: float = 1.5
    hairpin_width_over_length: float = 0.3
    """How much shorter than known a body must be to lack a part of itself, and least area of that
    part where it lies on itself, squared widths for each width of its length."""
    most_end_step_lengths: float = 0.12
    most_end_step_widths: float = 1.5
    """An end that moves farther than both in a frame has been mistaken for another."""

    def most_end_step_px(self, width: float, length: float) -> float:
        """Return how far an end of a body gets in a frame, pixels."""
        return max(self.most_end_step_widths * width, self.most_end_step_lengths * length)


@dataclass(frozen=True, eq=False)
class BodyModel:
    """Running means over frames with a sound midline.

    Attributes
    ----------
    length, width, area, level : float
        Pixels, pixels (of the outline), square pixels, grey levels of the signal on the midline.
    half_height_width : float
        Mean distance of the half-height edges over the middle half, pixels.
    widths, levels : ndarray, shape (TRACKED_POINTS,)
        Width, and signal on the midline, along the body, in the order of the last midline.
    gain : float
        Brightness of the pictures, over the background's.
    first_length : float
        That of the first one, pixels.
    darkening : float
        How much darker two parts are that lie on each other than one, relatively.
    overlaps : tuple of int and float
        Bodies that were followed into an overlap, and how dark it was in the mean.
    overlaps_left_out : int
        Pictures since then in which that was not measured.
    length_scatter : float
        Mean deviation of the log of its length: a worm that strokes has more.
    profile_scatter : float
        Mean difference of what it darkens along it, relative: of one open body it stays the same.
    looking_doubled : float
        Part of the last midlines that looked like a body laid double.
    is_settled : bool
        Whether it has been the same for so many frames that it is no other one.
    settings : BodyModelSettings
    shade : BodyShade or None
        Signal of one layer of it, place by place; None before it was seen.
    frames : int
        How many there were.
    began_in_fold : bool
        Whether the worm had been seen folded for long when the first one was.
    """

    length: float
    width: float
    area: float
    level: float
    half_height_width: float
    widths: Floats
    levels: Floats
    gain: float
    settings: BodyModelSettings
    first_length: float
    darkening: float = 0.0
    overlaps: tuple[int, float] = (0, 0.0)
    overlaps_left_out: int = 0
    length_scatter: float = 0.02
    profile_scatter: float = 0.0
    looking_doubled: float = 0.0
    is_settled: bool = False
    shade: BodyShade | None = None
    frames: int = 1
    began_in_fold: bool = False

    @classmethod
    def of(
        cls, midline: RefinedMidline, area: float, gain: float, settings: BodyModelSettings
    ) -> "BodyModel":
        """Return what a first midline tells."""
        length, width = length_of(midline.points), mean_width(midline.widths)
        return cls(
            length,
            width,
            area,
            midline.level,
            midline.width,
            midline.widths,
            midline.levels,
            gain,
            settings,
            length,
        )

    def updated(
        self, midline: RefinedMidline, area: float, gain: float, doubled: bool
    ) -> "BodyModel":
        """Return the model with one midline more, whose widths are in the order of the others."""
        rate = max(1 / (self.frames + 1), self.settings.least_weight_of_new_frame)
        off = abs(log(length_of(midline.points) / self.length))
        model = BodyModel(
            length=self.length + rate * (length_of(midline.points) - self.length),
            width=self.width + rate * (mean_width(midline.widths) - self.width),
            area=self.area + rate * (area - self.area),
            level=self.level + rate * (midline.level - self.level),
            half_height_width=self.half_height_width
            + rate * (midline.width - self.half_height_width),
            widths=self.widths + rate * (midline.widths - self.widths),
            levels=self.levels + rate * (midline.levels - self.levels),
            gain=self.gain + rate * (gain - self.gain),
            settings=self.settings,
            darkening=self.darkening,
            overlaps=self.overlaps,
            overlaps_left_out=self.overlaps_left_out,
            length_scatter=self.length_scatter + rate * (off - self.length_scatter),
            profile_scatter=self.profile_scatter
            + rate * (self.profile_difference(midline) - self.profile_scatter),
            looking_doubled=self.looking_doubled + rate * (doubled - self.looking_doubled),
            first_length=self.first_length,
            is_settled=self.is_settled,
            shade=self.shade,
            frames=self.frames + 1,
            began_in_fold=self.began_in_fold,
        )
        return model if model.is_young else replace(model, is_settled=True)

    def profile_difference(self, midline: RefinedMidline) -> float:
        """Return how far what a midline's body darkens, from place to place, is not this one's.

        The standard deviation along the body of the log of width times signal, over this one's.
        """
        cut = round(self.settings.profile_end_part * len(self.widths))
        inner = slice(cut, len(self.widths) - cut)
        seen = np.maximum(midline.widths * midline.levels, 1.0)[inner]
        known = np.maximum(self.widths * self.levels, 1.0)[inner]
        nodes = self.settings.profile_nodes
        off = np.convolve(np.log(seen / known), np.full(nodes, 1 / nodes), "valid")
        return float(off.std())

    @property
    def is_changing(self) -> bool:
        """Whether what was learned is no open body: it looks doubled, and not always alike."""
        settings = self.settings
        if self.frames < settings.changing_frames:
            return False
        differs = self.profile_scatter > settings.most_profile_scatter
        return differs and self.looking_doubled > settings.most_looking_doubled

    def end_width(self, last_end: bool, part_widths: float) -> float:
        """Return the mean width of an end, pixels: of its last so many widths."""
        widths = self.widths[::-1] if last_end else self.widths
        per_point = self.length / (len(widths) - 1)
        return float(widths[: max(3, round(part_widths * self.width / per_point))].mean())

    @property
    def is_learned(self) -> bool:
        """Whether widths and length are means of many frames."""
        return self.frames >= self.settings.learned_frames

    @property
    def tells_order(self) -> bool:
        """Whether its widths are known well enough to tell which end of a midline is which."""
        return self.frames >= self.settings.order_frames

    def order_told(self, widths: Floats) -> int:
        """Return 1 where the measured widths of an open body are in this order, -1, or 0."""
        settings = self.settings.order
        score = score_of_widths(widths, self.widths, settings) if self.tells_order else 0.0
        return int(np.sign(score)) if abs(score) > settings.least_score else 0

    @property
    def is_young(self) -> bool:
        """Whether the body may yet turn out to be another one."""
        return self.frames < self.settings.young_frames or self.varies

    @property
    def varies(self) -> bool:
        """Whether its profile differs from picture to picture by more than an open body's does."""
        settings = self.settings
        differs = self.profile_scatter > settings.most_profile_scatter_of_wide
        new = not self.is_settled and self.frames < settings.varying_frames
        return self.is_changing or (new and differs and self.width > settings.wide_px)

    @property
    def may_be_doubled(self) -> bool:
        """Whether it may be that of a worm laid double: it varies, or is new and looks like one."""
        new = self.frames < self.settings.changing_frames
        return self.varies or (new and self.looking_doubled > self.settings.most_looking_doubled)

    def is_outgrown_by(self, length: float) -> bool:
        """Tell whether a length shows that the first midlines were of a body laid double."""
        growth = log(length / self.first_length)
        return self.is_young and growth > self.settings.most_log_growth

    def with_shade(self, seen: Floats, gain: float) -> "BodyModel":
        """Return the model with the signal of one picture more, along the body and across it."""
        seen = seen * (self.gain / gain)
        if self.shade is None:
            return replace(self, shade=BodyShade.of(seen))
        return replace(
            self, shade=self.shade.updated(seen, self.settings.least_weight_of_new_frame)
        )

    def shade_at(self, gain: float) -> BodyShade | None:
        """Return the signal of one layer in a picture of some brightness; None if not yet known."""
        shade, brighter = self.shade, gain / self.gain
        if shade is None or shade.frames < self.settings.shade_frames:
            return None
        return replace(shade, mean=shade.mean * brighter, variance=shade.variance * brighter**2)

    def levels_at(self, gain: float) -> Floats:
        """Return the signal on the midline in a picture of some brightness."""
        return self.levels * (gain / self.gain)

    def with_darkening(self, darkening: float) -> "BodyModel":
        """Return the model with one measurement more of how dark its overlaps are."""
        rate = self.settings.weight_of_new_darkening if self.darkening > 0 else 1.0
        return replace(self, darkening=self.darkening + rate * (darkening - self.darkening))

    def with_overlap(self, darkening: float) -> "BodyModel":
        """Return the model with one body more that was followed into an overlap so dark."""
        frames, mean = self.overlaps
        frames, rate = frames + 1, max(1 / (frames + 1), self.settings.least_weight_of_new_overlap)
        mean += rate * (darkening - mean)
        model = replace(self, overlaps=(frames, mean))
        return replace(model, darkening=max(mean, 0.0)) if model.knows_overlaps else model

    def with_overlaps_of(self, other: "BodyModel") -> "BodyModel":
        """Return the model with what another one of the same worm saw more of its overlaps."""
        if not other.knows_overlaps or other.overlaps[0] <= self.overlaps[0]:
            return self
        return replace(self, overlaps=other.overlaps, darkening=other.darkening)

    @property
    def overlap_is_due(self) -> bool:
        """Whether how dark its overlaps are is measured in the next picture."""
        settings = self.settings
        well_known = self.overlaps[0] >= settings.well_known_overlap_frames
        return not well_known or self.overlaps_left_out >= settings.most_overlaps_left_out

    @property
    def knows_overlaps(self) -> bool:
        """Whether it was followed into enough overlaps to know how dark they are."""
        return self.overlaps[0] >= self.settings.overlap_frames

    @cached_property
    def marks(self) -> float:
        """How far its signal differs along it, its ends left out, over its median."""
        return marks_of(self.levels)

    @property
    def is_marked(self) -> bool:
        """Whether its skin has marks, which are no overlaps however dark they are."""
        return self.marks > self.settings.least_marks

    @cached_property
    def pale_ends(self) -> tuple[bool, bool]:
        """Of each end whether it is pale by itself: a thin one is pale by the lens."""
        settings = self.settings
        per_point = self.length / (len(self.levels) - 1)
        inner, outer = (round(k * self.width / per_point) for k in settings.pale_end_widths)
        level = settings.pale_end_over_body * self.level
        width = settings.pale_end_width_over_body * self.width
        first, last = (
            median_of(levels[inner : outer + 1]) < level
            and median_of(widths[inner : outer + 1]) > width
            for levels, widths in (
                (self.levels, self.widths),
                (self.levels[::-1], self.widths[::-1]),
            )
        )
        return first, last

    def lacks(self, length: float, left_over: float) -> bool:
        """Tell whether what a body leaves over may be what it lacks: a hairpin, cut off.

        Parameters
        ----------
        length : float
            Of the body, pixels.
        left_over : float
            Largest piece of the object that it leaves over, squared widths.
        """
        missing, settings = (self.length - length) / self.width, self.settings
        hairpin = settings.hairpin_width_over_length * missing
        return missing > settings.least_missing_widths and left_over > hairpin

    def leaps(self, points: Floats, last: Floats, frames: int) -> bool:
        """Tell whether an end is farther from where it was than it can have got in some frames."""
        far = self.settings.most_end_step_px(self.width, self.length)
        return end_displacement(points, last) > far * frames


def mean_width(widths: Floats) -> float:
    """Return the mean over the middle four fifths of the body."""
    cut = len(widths) // 10
    return float(widths[cut : len(widths) - cut].mean())


def end_displacement(points: Floats, last: Floats) -> float:
    """Return how far the end that moved more has moved, the ends paired the likelier way."""
    a, b, c, d = (complex(*point) for line in (points, last) for point in (line[0], line[-1]))
    return min(max(abs(a - c), abs(b - d)), max(abs(a - d), abs(b - c)))


def is_nearer_reversed(points: Floats, last: Floats) -> bool:
    """Tell whether a midline lies nearer to another one when it is turned round."""
    straight = abs(points - last).sum()
    return bool(abs(points[::-1] - last).sum() < straight)


def ends_changed_places(points: Floats, last: Floats, least_px: float) -> bool:
    """Tell whether each end of a midline lies where the other one was, not where it was itself."""
    ends, were = points[[0, -1]], last[[0, -1]]
    kept, changed = np.hypot(*(ends - were).T), np.hypot(*(ends - were[::-1]).T)
    return bool(kept.max() > least_px and 2 * changed.sum() < kept.sum())
