"""What a quantity is: its name, unit and symbols, the sums it rests on, and when it is refused."""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, inf, isfinite, nan

from worm_analysis.summary.direction_persistence import NotEnoughData
from worm_analysis.summary.resolution import (
    hidden_part,
    largest_radius_m,
    noise_in_thresholds,
    radius_noise_m,
)
from worm_analysis.summary.sums import Sums
from worm_analysis.wording import not_enough
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import Interval
from worm_msgs_py.paper import paper_value
from worm_msgs_py.units import MM_PER_M

NO_CHAMBER = "no chamber in the picture"
NO_EXIT = "no exit in view"
UNDETERMINED = "the data do not determine it"


def first(total: Floats) -> float:
    """Return the first sum: most often the number of items."""
    return float(total[0])


@dataclass(frozen=True, slots=True)
class Definition:
    """One quantity.

    Attributes
    ----------
    name, unit : str
        As in the summary.
    html, plain : str
        Its symbol for a page and for a figure (matplotlib's markup).
    meaning : str
        What it is, HTML.
    sums : str
        The sums that it rests on and that are resampled.
    estimate : callable
        From all sums to value, low and high, in SI.
    items : str
        What n counts.
    count : callable
        From the total of the sums to n; the first of them unless said.
    shown : callable or None
        Where another number than `count` is printed as n.
    scale : float
        From SI to the unit.
    bounds : (float, float)
        Values, in the unit, that the interval cannot go beyond.
    within_radius : bool
        Whether R is a bound, too.
    needs : str
        The setting that says how many items are needed at least; empty: none.
    undetermined, missing : str
        Why there is no value where the estimate is NaN, and where the sums are missing.
    most_noise : str
        The setting that says how noisy the radius may be, in thresholds of contact: where it may be
        more the number is refused. Empty: it does not rest on contact.
    refused_if_hidden : bool
        Whether it is refused, too, where more than `most_hidden` of the excursions hide in noise
        and pixels: `hidden_part`.
    """

    name: str
    unit: str
    html: str
    plain: str
    meaning: str
    sums: str
    estimate: Callable[[Sums], Interval]
    items: str
    count: Callable[[Floats], float] = first
    shown: Callable[[Floats], float] | None = None
    scale: float = 1.0
    bounds: tuple[float, float] = (-inf, inf)
    within_radius: bool = False
    needs: str = "minimum_n"
    undetermined: str = UNDETERMINED
    missing: str = NO_CHAMBER
    most_noise: str = ""
    refused_if_hidden: bool = False

    def of(self, sums: Sums) -> Quantity:
        """Return the number with its interval and n, or why there is none."""
        paper = paper_value(self.name, sums.exit_width_mm)
        if not sums.has(self.sums):
            alone = self.missing if sums.has("pixel") else NO_CHAMBER
            why = alone if len(sums.trials) == 1 else "no trial has it"
            return Quantity(self.name, None, unit=self.unit, paper=paper, why=why)
        total = sums.total(self.sums)
        n = int(self.count(total))
        shown = n if self.shown is None else int(self.shown(total))
        settings = sums.settings
        needed = max(settings.minimum_n, getattr(settings, self.needs)) if self.needs else 0
        why, estimate = "", (nan, nan, nan)
        most_noise = getattr(settings, self.most_noise) if self.most_noise else inf
        if self.most_noise and noise_in_thresholds(sums)[1] > most_noise:
            why = _too_noisy(sums, most_noise)
        elif n < needed:
            why = not_enough(n, self.items, needed)
        elif self.refused_if_hidden and hidden_part(sums) > settings.most_hidden:
            why = (
                f"noise and pixels hide about {100 * hidden_part(sums):.0f} % of the excursions, "
                f"more than {100 * settings.most_hidden:.0f} %: they are too shallow to be counted"
            )
        else:
            try:
                estimate = self.estimate(sums)
            except NotEnoughData as error:
                why = str(error)
        value, low, high = map(float, estimate)
        if not isfinite(value):
            why = why or self.undetermined
            return Quantity(self.name, None, n=shown, unit=self.unit, paper=paper, why=why)
        low, high = self._with_model_error(sums, low, high)
        least, most = self.bounds
        if self.within_radius and sums.has("chamber_radius"):
            most = min(most, self.scale * largest_radius_m(sums))
        return Quantity(
            self.name,
            value * self.scale,
            max(least, low * self.scale) if isfinite(low) else None,
            min(most, high * self.scale) if isfinite(high) else None,
            shown,
            self.unit,
            paper,
        )

    def _with_model_error(self, sums: Sums, low: float, high: float) -> tuple[float, float]:
        """Widen the interval of a number that rests on contact by how far noise can put it off."""
        if not self.most_noise:
            return low, high
        factor = exp(sums.settings.off_by_noise * noise_in_thresholds(sums)[0])
        return low / factor, high * factor


def _too_noisy(sums: Sums, most: float) -> str:
    (noise_m, _, most_m), threshold_m = radius_noise_m(sums)
    return (
        f"the head's radius is too noisy: {MM_PER_M * noise_m:.3f} mm, or up to "
        f"{MM_PER_M * most_m:.3f} mm, more than {most:g} of the {MM_PER_M * threshold_m:.3f} mm "
        "within which the head touches the wall"
    )
