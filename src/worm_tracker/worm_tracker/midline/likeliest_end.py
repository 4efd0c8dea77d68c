"""In which of many places an end of a body lies, and how surely, by what each costs.

It is as sure as those places lie near to each other that cost about as little.
"""

from dataclasses import dataclass
from math import hypot, inf, sqrt

import numpy as np

from worm_msgs_py.arrays import Complex


@dataclass(frozen=True, slots=True)
class LikeliestEndSettings:
    """How likely a place is by what it costs, and from when on an end is moved there.

    Costs are in the units of whoever measures them.
    """

    likelihood: float
    """What a place costs more that is less likely by a factor of e."""
    likelihood_over_cost: float
    """The same at least, over what the best place costs: where the picture fits less well anywhere
    it tells less well where an end is, and counts less than where it was followed."""
    most_cost: float
    most_cost_moved: float
    """What fits less well tells nothing of the end; and the same for an end to be moved."""
    sd_over_spread: float
    """How surely an end lies somewhere, over how far likely places lie from there, root mean
    square."""
    same_place_widths: float = 0.15
    """Of places as near to each other the likeliest counts."""
    place_sd_over_end_sd: float = 2.0
    least_place_sd_widths: float = 0.5
    told_place_sd_widths: float = 1.0
    """How far from where it was followed an end may lie: for it to be moved there, over how surely
    it was followed, and at least; and where it is asked how surely it lies there."""
    least_gain_over_likelihood: float = 1.5
    least_moved_widths: float = 0.25
    """How much likelier another place must be, and how far away, for the end to be moved there."""


@dataclass(frozen=True, slots=True)
class KnownEnd:
    """What is known of an end and its body before the picture is asked.

    Attributes
    ----------
    place : complex
        Where the end was followed, u + iv.
    sd_px : float
        How surely it lies there.
    width : float
        The body's, pixels.
    length_px, length_sd_px : float
        How long the body is, and how far from that it may be.
    """

    place: complex
    sd_px: float
    width: float
    length_px: float
    length_sd_px: float


@dataclass(frozen=True, eq=False, slots=True)
class PlacedEnd:
    """A body with its first end in some place.

    Attributes
    ----------
    line : ndarray of complex, shape (n,)
        From that end on, u + iv.
    length_px : float
        How long it is so.
    cost : float
        How badly it fits the picture.
    """

    line: Complex
    length_px: float
    cost: float


@dataclass(frozen=True, eq=False, slots=True)
class LikeliestEnd:
    """Where an end lies best.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,), or None
        The body from that end on; None where the end stays where it is.
    sd_px : float
        How surely it lies there, by the picture alone; inf where that tells nothing.
    """

    curve: Complex | None
    sd_px: float


def likeliest_end(
    places: list[PlacedEnd], known: KnownEnd, settings: LikeliestEndSettings
) -> LikeliestEnd:
    """Return where an end lies best, and how surely.

    Parameters
    ----------
    places : list of PlacedEnd
        Those tried; first of all where it was followed.
    known : KnownEnd
    settings : LikeliestEndSettings
    """
    width, sd = known.width, _place_sd_px(known, settings)
    least = min(each.cost for each in places)
    likelihood = max(settings.likelihood, settings.likelihood_over_cost * least)
    cost = [_cost_of_place(each, known, sd, likelihood) for each in places]
    stays, best = places[0], places[int(np.argmin(cost))]
    likelier = cost[0] - min(cost) > settings.least_gain_over_likelihood * likelihood
    likelier &= best.cost < settings.most_cost_moved
    away = float(abs(best.line[0] - known.place))
    moves = likelier and away > settings.least_moved_widths * width
    told, off, sd_px = best if likelier else stays, away if likelier and not moves else 0.0, inf
    if told.cost < settings.most_cost:
        spread = _spread_about(told, places, known, likelihood, settings)
        sd_px = hypot(settings.sd_over_spread * spread, off)
    return LikeliestEnd(told.line if moves else None, sd_px)


def cost_at_first(placed: PlacedEnd, known: KnownEnd, settings: LikeliestEndSettings) -> float:
    """Return what a place costs before it is known how well any fits.

    By the picture, by how far off it is and by how long the body is so: the few that cost least are
    worth to be tried finer.
    """
    return _cost_of_place(placed, known, _place_sd_px(known, settings), settings.likelihood)


def _place_sd_px(known: KnownEnd, settings: LikeliestEndSettings) -> float:
    """Return how far from where it was followed an end may lie for it to be moved there, pixels."""
    least = settings.least_place_sd_widths * known.width
    return max(settings.place_sd_over_end_sd * known.sd_px, least)


def _cost_of_place(placed: PlacedEnd, known: KnownEnd, sd: float, likelihood: float) -> float:
    """Return what a place costs if it is within about `sd` of where the end was followed.

    By the picture, by how far off it is and by how long the body is so.
    """
    away = float(abs(placed.line[0] - known.place)) / sd
    longer = (placed.length_px - known.length_px) / known.length_sd_px
    return placed.cost + likelihood * (away**2 + longer**2) / 2


def _spread_about(
    told: PlacedEnd,
    places: list[PlacedEnd],
    known: KnownEnd,
    likelihood: float,
    settings: LikeliestEndSettings,
) -> float:
    """Return how far from an end likely ones lie, root mean square, pixels."""
    sd = settings.told_place_sd_widths * known.width
    cost = np.array([_cost_of_place(each, known, sd, likelihood) for each in places])
    likely = np.exp((cost.min() - cost) / likelihood)
    away = np.array([each.line[0] for each in places]) - told.line[0]
    cells = away / (settings.same_place_widths * known.width)
    _, cell = np.unique(np.rint(cells.real) + 1j * np.rint(cells.imag), return_inverse=True)
    likeliest = np.zeros(cell.max() + 1)
    np.maximum.at(likeliest, cell, likely)
    counted = np.where(likely == likeliest[cell], likely, 0)
    return sqrt(np.average(np.abs(away) ** 2, weights=counted))
