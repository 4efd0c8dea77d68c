"""What a body that slides along its path is expected to be in the next picture."""

from dataclasses import dataclass
from functools import cached_property

from worm_msgs_py.arrays import Floats
from worm_tracker.midline.body_shade import marks_of
from worm_tracker.midline.curve import median_of


@dataclass(frozen=True, eq=False)
class ExpectedBody:
    """What a body that slides along its path is expected to be.

    Attributes
    ----------
    widths, levels : ndarray, shape (TRACKED_POINTS,)
        Width, and signal on the midline in grey levels, along the body in the path's order.
    length, length_sd : float
        Pixels.
    darkening : float
        How much darker two parts are that lie on each other than one, relatively.
    is_marked : bool
        Whether its marks tell where its ends are on other parts of it, rather than its darkness.
    pale_ends : tuple of bool
        Of each end whether they do so of all of it, in clear water, too.
    """

    widths: Floats
    levels: Floats
    length: float
    length_sd: float
    darkening: float
    is_marked: bool = False
    pale_ends: tuple[bool, bool] = (False, False)

    @cached_property
    def width(self) -> float:
        """The width of most of the body."""
        return median_of(self.widths)

    @cached_property
    def level(self) -> float:
        """The signal of most of the body, grey levels."""
        return median_of(self.levels)

    @cached_property
    def level_sd(self) -> float:
        """How far the signal of its parts differs from that: a skin has marks."""
        return self.level * marks_of(self.levels)
