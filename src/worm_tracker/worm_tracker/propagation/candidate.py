"""A body that may be the worm's in an object, and how well it explains it."""

from dataclasses import dataclass
from math import inf

from worm_tracker.midline.body_residual import Unexplained
from worm_tracker.midline.path import BodyPath


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
    flanks_sd_px : tuple of float
        How surely the flanks beside each end on the body tell where it is; inf where they do not.
    straighter : float
        As in `PropagatedBody`: how much straighter it would be with two of its strands exchanged.
    order_score : float or None
        How well its widths or its marks tell that its ends are in the right order; None where that
        has not been asked yet.
    turned_round : bool
        Whether it was followed the wrong way round until now.
    was_exchanged : bool
        Whether two of its strands are exchanged, against the picture before.
    """

    path: BodyPath
    agreement: float
    unexplained: Unexplained
    end_sd_px: tuple[float, float] = (0.0, 0.0)
    flanks_sd_px: tuple[float, float] = (inf, inf)
    straighter: float = 0.0
    order_score: float | None = None
    turned_round: bool = False
    was_exchanged: bool = False
