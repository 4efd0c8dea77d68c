"""From an estimate to a `Quantity`: the number with its interval and n, or why there is none."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite, nan

from worm_analysis.accumulators.body_size import BodySums
from worm_analysis.accumulators.exclusions import LeftOut
from worm_analysis.accumulators.passage_sums import PassageSums
from worm_analysis.accumulators.wall_search import WallSearch
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.statistics.estimators import Estimate, finite_or_none
from worm_analysis.summary.paper_values import paper_value
from worm_msgs_py import Quantity


@dataclass(frozen=True, slots=True)
class Evidence:
    """All that the numbers rest on.

    Attributes
    ----------
    parameters : AnalysisParameters
        Settings.
    search : WallSearch
        The search along the wall.
    passages : PassageSums
        Visits and attempts.
    skips : int
        Skips of the whole trial.
    body : BodySums
        Length and width in every frame.
    left_out : LeftOut
        Frames that count for no estimate.
    has_chamber : bool
        Whether there is a chamber at all.
    radius_m, exit_width_m, depth_m, px_per_m : float
        R, W, h and the picture's scale; NaN where they are not known.
    """

    parameters: AnalysisParameters
    search: WallSearch
    passages: PassageSums
    skips: int
    body: BodySums
    left_out: LeftOut
    has_chamber: bool = False
    radius_m: float = nan
    exit_width_m: float = nan
    depth_m: float = nan
    px_per_m: float = nan

    @property
    def pixel_m(self) -> float:
        """Size of a pixel; 0 where it is not known."""
        return 1 / self.px_per_m if self.px_per_m > 0 else 0.0


def tell(
    evidence: Evidence,
    name: str,
    unit: str,
    n: int,
    estimate: Callable[[], Estimate | tuple[float, float | None]],
    *,
    items: str,
    scale: float = 1.0,
    bounds: tuple[float, float] = (-inf, inf),
    why: str = "the data do not determine it",
    n_shown: int | None = None,
    fewest: int = 0,
) -> Quantity:
    """Return a quantity, or why there is none.

    Parameters
    ----------
    evidence : Evidence
        For the smallest n that is enough, and for the paper's value.
    name, unit : str
        As in the summary.
    n : int
        Items that there are; `estimate` is called only where they are enough.
    estimate : callable
        Gives value, low and high, or value and half width.
    items : str
        What n counts.
    scale : float
        From the estimate's unit to the summary's.
    bounds : (float, float)
        Values, in the summary's unit, that the interval cannot go beyond.
    why : str
        What a NaN means.
    n_shown : int or None
        Where another number than n says what the estimate rests on.
    fewest : int
        Where an estimate needs more items than `minimum_n`.
    """
    minimum = max(evidence.parameters.minimum_n, fewest)
    paper = paper_value(name, evidence.exit_width_m)
    shown = n if n_shown is None else n_shown
    if n < minimum:
        reason = f"not enough data: {n} {items}, {minimum} are needed"
        return Quantity(name, None, n=shown, unit=unit, paper=paper, why=reason)
    result = estimate()
    value = result[0]
    if len(result) == 2:
        half = nan if result[1] is None else result[1]
        low, high = value - half, value + half
    else:
        low, high = result[1], result[2]
    if not isfinite(value):
        return Quantity(name, None, n=shown, unit=unit, paper=paper, why=why)
    least, most = bounds
    return Quantity(
        name,
        value * scale,
        finite_or_none(max(least, low * scale) if isfinite(low) else nan),
        finite_or_none(min(most, high * scale) if isfinite(high) else nan),
        shown,
        unit,
        paper,
    )


def none(name: str, unit: str, why: str) -> Quantity:
    """Return a quantity that cannot be had, whatever the data."""
    return Quantity(name, None, unit=unit, paper=paper_value(name), why=why)
