"""How much data a figure needs, and what of a trial it shows."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FigureSettings:
    """Settings of all figures.

    Attributes
    ----------
    fewest_frames : int
        A density of frames is drawn from so many on; they are not independent.
    fewest_items : int
        A density of episodes, visits or findings is drawn from so many on.
    fewest_points : int
        A scatter plot of frames or contacts is drawn from so many on.
    fewest_windows : int
        One of windows of time is drawn from so many on.
    most_points : int
        Points of a scatter plot at most: more are one blot.
    fewest_pairs, smallest_part_of_pairs : int, float
        A lag of C_θ is drawn where it has so many pairs, and such a part of those at lag 0.
    fewest_in_bin, smallest_part_in_bin : int, float
        A mean over a bin of frames is drawn where it has so many, and such a part of all.
    whole_s : float
        A trial that is not longer is shown whole.
    example_s : float
        Length of an example of a longer one.
    fewest_known : float
        Part of an example's frames that must have θ_h.
    shortest_stay_s : float
        Stays in a chamber that are examples where no example of full length is to be had.
    direction_s : float
        Step over which an example's direction is told, to count its reversals.
    """

    fewest_frames: int = 100
    fewest_items: int = 10
    fewest_points: int = 30
    fewest_windows: int = 10
    most_points: int = 1500
    fewest_pairs: int = 100
    smallest_part_of_pairs: float = 0.25
    fewest_in_bin: int = 20
    smallest_part_in_bin: float = 0.005
    whole_s: float = 90.0
    example_s: float = 60.0
    fewest_known: float = 0.9
    shortest_stay_s: float = 20.0
    direction_s: float = 5.0


FIGURES = FigureSettings()
