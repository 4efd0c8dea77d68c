"""Where the flanks of a body of one shade say that an end lies which lies on it.

Where overlaps are no darker an end on the body shows by the outline alone: the strand that it lies
on is broader beside it, by little and on one side. Many places in which it may be are tried, and in
each the strands there are moved until their flanks lie on the outline as well as they can. The end
is as sure as those places lie near to each other that do so about as well.
"""

from dataclasses import dataclass, field
from math import hypot, inf, sqrt

import numpy as np

from worm_msgs_py.arrays import Complex, Floats
from worm_tracker.midline.curve import complex_arc_length, unit_grid
from worm_tracker.midline.end_places import (
    EndPlacesSettings,
    lengthened,
    places_along,
    places_beyond_flanks,
)
from worm_tracker.midline.flank_fit import (
    FlankFitSettings,
    StrandMoves,
    fitted_to_flanks,
)
from worm_tracker.midline.object_outline import Outline


@dataclass(frozen=True, slots=True)
class EndByFlanksSettings:
    """Which places are tried, how likely each is, and from when on an end is moved there."""

    places: EndPlacesSettings = field(default_factory=EndPlacesSettings)
    iterations: int = 3
    strand_sd_widths: float = 0.15
    end_sd_widths: float = 0.6
    """How often strands are moved, and how far: those of the body, and the end."""
    tried_finer: int = 4
    finer_widths: tuple[float, ...] = (-0.3, 0.0, 0.3)
    finer_iterations: int = 3
    finer_strand_sd_widths: float = 0.1
    finer_end_sd_widths: float = 0.3
    """How many of those that do best are fitted again, by how much shorter and longer, too, and the
    same of those."""
    explored_widths: tuple[float, ...] = (-2.0, -1.0, 1.0, 2.0)
    """How much shorter and longer what does best then is tried."""
    end_widths: float = 4.0
    """How much of the body is its end."""
    likelihood_px2: float = 1.2
    """What a place costs more that is less likely by a factor of e: for noise alone less would do,
    but widths are not known so well. True places cost 1 to 4 in films of one shade."""
    likelihood_over_cost: float = 0.3
    """The same at least, over what the best place costs: where flanks fit less well anywhere they
    tell less well where an end is, and count less than where it was followed."""
    most_cost_px2: float = 8.0
    """What fits less well tells nothing of the end: nor does a real worm whose brightness is patchy
    (50 to 180)."""
    most_cost_moved_px2: float = 16.0
    """The same for an end to be moved."""
    same_place_widths: float = 0.15
    """Of places as near to each other the likeliest counts."""
    sd_over_spread: float = 1.05
    """How surely an end lies somewhere, over how far likely places lie from there, root mean
    square: of 613 ends told so to 0.35 widths in eight films four were more than a width off. Up to
    0.15 widths their error was what is told, up to 0.35 one and a half times that."""
    place_sd_over_end_sd: float = 2.0
    least_place_sd_widths: float = 0.5
    told_place_sd_widths: float = 1.0
    """How far from where it was followed an end may lie: for it to be moved there, over how surely
    it was followed, and at least; and where it is asked how surely it lies there."""
    least_gain_over_likelihood: float = 1.5
    least_moved_widths: float = 0.25
    """How much likelier another place must be, and how far away, for the end to be moved there."""
    fit: FlankFitSettings = field(default_factory=FlankFitSettings)


@dataclass(frozen=True, eq=False, slots=True)
class EndByFlanks:
    """Where an end lies best.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,), or None
        The body from that end on; None where the end stays where it is.
    sd_px : float
        How surely it lies there, by the outline alone; inf where it could be tried nowhere else.
    """

    curve: Complex | None
    sd_px: float


@dataclass(frozen=True, slots=True)
class KnownEnd:
    """What is known of an end and its body before the outline is asked.

    Attributes
    ----------
    sd_px : float
        How surely the end lies where it was followed.
    length_px, length_sd_px : float
        How long the body is, and how far from that it may be.
    """

    sd_px: float
    length_px: float
    length_sd_px: float


@dataclass(frozen=True, eq=False, slots=True)
class _PlacedEnd:
    """A body with its first end in some place, how long it is so, pixels, and what that costs."""

    line: Complex
    length_px: float
    cost: float


def end_by_flanks(
    outline: Outline,
    curve: Complex,
    widths: Floats,
    width: float,
    known: KnownEnd,
    settings: EndByFlanksSettings,
) -> EndByFlanks:
    """Return where the first end of a body lies best, by its flanks.

    Parameters
    ----------
    outline : Outline
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps, in the same coordinates.
    widths : ndarray, shape (m,)
        Its widths from that end on, at equal parts of its length, pixels.
    width : float
        That of most of the body, pixels.
    known : KnownEnd
    settings : EndByFlanksSettings
    """
    place = complex(curve[0])
    near = outline.near(place, settings.fit.reach_widths * width)
    view = _Surroundings(near, widths, width, place, known, settings)
    sd = max(settings.place_sd_over_end_sd * known.sd_px, settings.least_place_sd_widths * width)
    places = view.places(curve, sd)
    least = min(each.cost for each in places)
    likelihood = max(settings.likelihood_px2, settings.likelihood_over_cost * least)
    cost = [view.cost(each, sd, likelihood) for each in places]
    stays, best = places[0], places[int(np.argmin(cost))]
    likelier = cost[0] - min(cost) > settings.least_gain_over_likelihood * likelihood
    likelier &= best.cost < settings.most_cost_moved_px2
    away = float(abs(best.line[0] - place))
    moves = likelier and away > settings.least_moved_widths * width
    told, off, sd_px = best if likelier else stays, away if likelier and not moves else 0.0, inf
    if told.cost < settings.most_cost_px2:
        spread = view.spread_about(told, places, likelihood)
        sd_px = hypot(settings.sd_over_spread * spread, off)
    return EndByFlanks(told.line if moves else None, sd_px)


@dataclass(frozen=True, eq=False, slots=True)
class _Surroundings:
    """An outline about a place, and the body that is fitted to it."""

    outline: Outline
    widths: Floats
    width: float
    place: complex
    known: KnownEnd
    settings: EndByFlanksSettings
    half_widths: dict[int, Floats] = field(default_factory=dict)

    def cost(self, placed: _PlacedEnd, sd: float, likelihood: float) -> float:
        """Return what a body costs if its end is within about `sd` of the place."""
        known, away = self.known, float(abs(placed.line[0] - self.place)) / sd
        longer = (placed.length_px - known.length_px) / known.length_sd_px
        return placed.cost + likelihood * (away**2 + longer**2) / 2

    def spread_about(self, told: _PlacedEnd, places: list[_PlacedEnd], likelihood: float) -> float:
        """Return how far from an end likely ones lie, root mean square, pixels."""
        sd = self.settings.told_place_sd_widths * self.width
        cost = np.array([self.cost(each, sd, likelihood) for each in places])
        likely = np.exp((cost.min() - cost) / likelihood)
        away = np.array([each.line[0] for each in places]) - told.line[0]
        cells = away / (self.settings.same_place_widths * self.width)
        _, cell = np.unique(np.rint(cells.real) + 1j * np.rint(cells.imag), return_inverse=True)
        likeliest = np.zeros(cell.max() + 1)
        np.maximum.at(likeliest, cell, likely)
        counted = np.where(likely == likeliest[cell], likely, 0)
        return sqrt(np.average(np.abs(away) ** 2, weights=counted))

    def places(self, curve: Complex, sd: float) -> list[_PlacedEnd]:
        """Return a body with its first end in many places; first of all where it is."""
        settings, width = self.settings, self.width
        half, tried = self.half_widths_of(len(curve)), settings.places
        starts = [
            *places_along(curve, width, tried),
            *places_beyond_flanks(curve, half, self.outline.pixels, width, tried),
        ]
        coarse = [self.fitted(start) for start in starts]
        coarse.sort(key=lambda each: self.cost(each, sd, settings.likelihood_px2))
        few, others = coarse[: settings.tried_finer], coarse[settings.tried_finer :]
        finer = [again for each in few for again in self.fitted_again(each, settings.finer_widths)]
        places = [self.fitted_finer(curve), *finer, *others]
        best = min(places, key=lambda each: self.cost(each, sd, settings.likelihood_px2))
        return places + self.fitted_again(best, settings.explored_widths)

    def fitted(self, start: Complex) -> _PlacedEnd:
        """Return a body fitted from a start."""
        st = self.settings
        sds = st.strand_sd_widths, st.end_sd_widths
        return self._fitted_by(start, StrandMoves(st.end_widths, *sds, st.iterations))

    def fitted_finer(self, start: Complex) -> _PlacedEnd:
        """Return a body fitted from a start that lies well."""
        st = self.settings
        sds = st.finer_strand_sd_widths, st.finer_end_sd_widths
        return self._fitted_by(start, StrandMoves(st.end_widths, *sds, st.finer_iterations))

    def fitted_again(self, placed: _PlacedEnd, longer: tuple[float, ...]) -> list[_PlacedEnd]:
        """Return a body fitted again, some widths shorter or longer."""
        starts = [
            lengthened(placed.line, widths, self.width, self.settings.places) for widths in longer
        ]
        return [self.fitted_finer(start) for start in starts if start is not None]

    def half_widths_of(self, nodes: int) -> Floats:
        """Return half the width at each node of a body of so many: many have as many."""
        if nodes not in self.half_widths:
            self.half_widths[nodes] = rounded_half_widths(unit_grid(nodes), self.widths)
        return self.half_widths[nodes]

    def _fitted_by(self, start: Complex, moves: StrandMoves) -> _PlacedEnd:
        half = self.half_widths_of(len(start))
        cost, line = fitted_to_flanks(
            start, half, self.outline, self.place, self.width, moves, self.settings.fit
        )
        length_px = float(complex_arc_length(line)[-1])
        return _PlacedEnd(line, length_px, cost)


def rounded_half_widths(part: Floats, widths: Floats) -> Floats:
    """Return half the width at parts of a body's length, with its ends as round as they are blunt.

    Parameters
    ----------
    part : ndarray, shape (n,)
        0 to 1.
    widths : ndarray, shape (m,)
        At equal steps.
    """
    half = np.interp(part, unit_grid(len(widths)), widths / 2)
    spacing, most = 1 / (len(widths) - 1), float(widths.max()) / 2
    for beside, from_end in ((widths[1] / 2, part), (widths[-2] / 2, 1 - part)):
        near = from_end < spacing
        power = min(max(1 - beside / most, 0.45), 1.0)
        half[near] = beside * (from_end[near].clip(0) / spacing) ** power
    return half
