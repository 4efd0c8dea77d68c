"""The rig that the filament crawls in: two round chambers and a straight passage between them."""

from dataclasses import dataclass

from worm_msgs_py import paper


@dataclass(frozen=True, slots=True)
class FilamentRig:
    """The paper's rig, seen from above, in the frame of chamber A (docs/science.md).

    The origin is the centre of chamber A, x points towards the middle of its exit, y is up;
    chamber B has its centre at (2R + L, 0).

    Attributes
    ----------
    radius_mm, exit_width_mm, passage_length_mm : float
        R, W and L. The passage runs from circle to circle. W = 0 closes both chambers.

    Raises
    ------
    ValueError
        Where a length makes no sense.
    """

    radius_mm: float = paper.RADIUS_MM
    exit_width_mm: float = 2.0
    passage_length_mm: float = paper.PASSAGE_LENGTH_MM

    def __post_init__(self) -> None:
        if not self.radius_mm > 0.0:
            raise ValueError(f"radius_mm is {self.radius_mm}; it must be above 0")
        if not 0.0 <= self.exit_width_mm < 2.0 * self.radius_mm:
            raise ValueError(f"exit_width_mm is {self.exit_width_mm}; it must be 0 or up to 2R")
        if not self.passage_length_mm >= 0.0:
            raise ValueError(f"passage_length_mm is {self.passage_length_mm}; it must be 0 or more")

    @property
    def far_centre_mm(self) -> float:
        """X of the centre of chamber B."""
        return 2.0 * self.radius_mm + self.passage_length_mm
