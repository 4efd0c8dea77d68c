"""What has been learned of this worm: its length, widths, area and darkness."""

from dataclasses import dataclass

from worm_tracker.midline.contour_midline import Floats, as_complex
from worm_tracker.midline.refine import Fine

LEAP_LENGTHS = 0.12
LEAP_WIDTHS = 1.5
"""An end that moves farther than both from one frame to the next has been mistaken for another."""
SLOWEST = 0.02
"""Least weight of a new frame in the running means."""


@dataclass(eq=False, slots=True)
class Known:
    """Running means over frames with a sound midline.

    Attributes
    ----------
    length, width, area, level : float
        Pixels, pixels, square pixels, grey levels of the signal on the midline.
    widths : ndarray, shape (POINTS,)
        Along the body, in the order of the last midline.
    frames : int
        How many there were.
    """

    length: float
    width: float
    area: float
    level: float
    widths: Floats
    frames: int = 1

    @classmethod
    def of(cls, fine: Fine, area: float) -> "Known":
        """Return what a first midline tells."""
        return cls(length_of(fine.points), mean_width(fine.widths), area, fine.level, fine.widths)

    def learn(self, fine: Fine, widths: Floats, area: float) -> None:
        """Take the next midline in, its widths turned to the order of those before."""
        self.frames += 1
        rate = max(1 / self.frames, SLOWEST)
        self.length += rate * (length_of(fine.points) - self.length)
        self.width += rate * (mean_width(widths) - self.width)
        self.area += rate * (area - self.area)
        self.level += rate * (fine.level - self.level)
        self.widths = self.widths + rate * (widths - self.widths)

    def leaps(self, points: Floats, last: Floats, frames: int) -> bool:
        """Tell whether an end is farther from where it was than it can have got in some frames."""
        far = max(LEAP_WIDTHS * self.width, LEAP_LENGTHS * self.length)
        return end_displacement(points, last) > far * frames


def length_of(points: Floats) -> float:
    """Return the length of a midline."""
    line = as_complex(points)
    return float(abs(line[1:] - line[:-1]).sum())


def mean_width(widths: Floats) -> float:
    """Return the mean over the middle four fifths of the body."""
    cut = len(widths) // 10
    return float(widths[cut : len(widths) - cut].mean())


def end_displacement(points: Floats, last: Floats) -> float:
    """Return how far the end that moved more has moved, the ends paired the likelier way."""
    a, b, c, d = (complex(*point) for line in (points, last) for point in (line[0], line[-1]))
    return min(max(abs(a - c), abs(b - d)), max(abs(a - d), abs(b - c)))


def nearer_turned(points: Floats, last: Floats) -> bool:
    """Tell whether a midline lies nearer to another one when it is turned round."""
    straight = abs(points - last).sum()
    return bool(abs(points[::-1] - last).sum() < straight)
