"""What has been learned of this worm's body: its length, widths, area and darkness."""

from dataclasses import dataclass

from worm_msgs_py.arrays import Floats
from worm_tracker.midline.curve import length_of
from worm_tracker.midline.refine import RefinedMidline


@dataclass(frozen=True, slots=True)
class BodyModelSettings:
    """How fast the body model follows, and how far a body's ends get in a frame."""

    least_weight_of_new_frame: float = 0.02
    """Weight of a frame in the running means after the first ones: a memory of 50 frames."""
    most_end_step_lengths: float = 0.12
    most_end_step_widths: float = 1.5
    """An end that moves farther than both in a frame has been mistaken for another."""

    def most_end_step_px(self, width: float, length: float) -> float:
        """Return how far an end of a body gets in a frame, pixels."""
        return max(self.most_end_step_widths * width, self.most_end_step_lengths * length)


@dataclass(frozen=True, eq=False, slots=True)
class BodyModel:
    """Running means over frames with a sound midline.

    Attributes
    ----------
    length, width, area, level : float
        Pixels, pixels, square pixels, grey levels of the signal on the midline.
    widths : ndarray, shape (TRACKED_POINTS,)
        Along the body, in the order of the last midline.
    settings : BodyModelSettings
    frames : int
        How many there were.
    """

    length: float
    width: float
    area: float
    level: float
    widths: Floats
    settings: BodyModelSettings
    frames: int = 1

    @classmethod
    def of(cls, midline: RefinedMidline, area: float, settings: BodyModelSettings) -> "BodyModel":
        """Return what a first midline tells."""
        length, width = length_of(midline.points), mean_width(midline.widths)
        return cls(length, width, area, midline.level, midline.widths, settings)

    def updated(self, midline: RefinedMidline, area: float) -> "BodyModel":
        """Return the model with one midline more, whose widths are in the order of the others."""
        rate = max(1 / (self.frames + 1), self.settings.least_weight_of_new_frame)
        return BodyModel(
            length=self.length + rate * (length_of(midline.points) - self.length),
            width=self.width + rate * (mean_width(midline.widths) - self.width),
            area=self.area + rate * (area - self.area),
            level=self.level + rate * (midline.level - self.level),
            widths=self.widths + rate * (midline.widths - self.widths),
            settings=self.settings,
            frames=self.frames + 1,
        )

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
