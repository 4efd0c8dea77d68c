"""Where the flanks of a body of one shade say that an end lies which lies on it.

Where overlaps are no darker an end on the body shows by the outline alone: the strand that it lies
on is broader beside it, by little and on one side. Many places in which it may be are tried, and in
each the strands there are moved until their flanks lie on the outline as well as they can. The end
is as sure as those places lie near to each other that do so about as well.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf, sqrt

import numpy as np

from worm_msgs_py.arrays import Complex, Floats
from worm_tracker.midline.curve import complex_arc_length
from worm_tracker.midline.flank_fit import (
    FlankFitSettings,
    StrandMoves,
    fitted_to_flanks,
)
from worm_tracker.midline.object_outline import Outline


@dataclass(frozen=True, slots=True)
class EndByFlanksSettings:
    """Which places are tried, how likely each is, and from when on an end is moved there."""

    longer_widths: tuple[float, ...] = (-2.4, -1.6, -0.8, 0.0, 0.8, 1.6, 2.4)
    """How much longer than it is the body is tried."""
    aside_widths: tuple[float, ...] = (-0.5, 0.0, 0.5)
    aside_over_widths: float = 4.0
    """How far aside its end is tried, and over how much of it that comes about."""
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
    end_widths: float = 4.0
    """How much of the body is its end."""
    least_nodes: int = 12
    """How many nodes must be left of a body."""
    least_apart_along_widths: float = 2.5
    least_cosine_of_strand: float = -0.3
    least_cosine_along_strand: float = 0.9
    """How far along the body another strand is apart; how an end must head that goes on along it,
    and from when on it is not tried straight on, too."""
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
    sd_over_spread: float = 1.2
    """How surely an end lies somewhere, over how far likely places lie from there, root mean
    square: of 407 ends told so to 0.35 widths in eight films four were more than a width off. Up to
    0.2 widths their error was what is told, up to 0.35 one and a half times that."""
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
    """A body with its first end in some place, how much of it is that end, and what that costs."""

    line: Complex
    end_widths: float
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
    view = _Surroundings(outline, widths, width, complex(curve[0]), known, settings)
    tried = [view.fitted(start, end) for start, end in _places_tried(curve, width, settings)]
    if not tried:
        return EndByFlanks(None, inf)
    sd = max(settings.place_sd_over_end_sd * known.sd_px, settings.least_place_sd_widths * width)
    tried.sort(key=lambda each: view.cost(each, sd, settings.likelihood_px2))
    stays = view.fitted_finer(curve, settings.end_widths)
    few, others = tried[: settings.tried_finer], tried[settings.tried_finer :]
    places = [stays, *(again for each in few for again in view.fitted_again(each)), *others]
    least = min(each.cost for each in places)
    likelihood = max(settings.likelihood_px2, settings.likelihood_over_cost * least)
    cost = [view.cost(each, sd, likelihood) for each in places]
    best = places[int(np.argmin(cost))]
    gain = cost[0] - min(cost)
    moves = gain > settings.least_gain_over_likelihood * likelihood
    moves &= best.cost < settings.most_cost_moved_px2
    moves &= abs(best.line[0] - curve[0]) > settings.least_moved_widths * width
    told = best if moves else stays
    sd_px = inf
    if told.cost < settings.most_cost_px2:
        sd_px = settings.sd_over_spread * view.spread_about(told, places, likelihood)
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
        line, known = placed.line, self.known
        away = float(abs(line[0] - self.place)) / sd
        longer = (float(complex_arc_length(line)[-1]) - known.length_px) / known.length_sd_px
        return placed.cost + likelihood * (away**2 + longer**2) / 2

    def spread_about(self, told: _PlacedEnd, places: list[_PlacedEnd], likelihood: float) -> float:
        """Return how far from an end likely ones lie, root mean square, pixels."""
        sd = self.settings.told_place_sd_widths * self.width
        cost = np.array([self.cost(each, sd, likelihood) for each in places])
        likely = np.exp((cost.min() - cost) / likelihood)
        away = np.abs(np.array([each.line[0] for each in places]) - told.line[0])
        return sqrt(np.average(away**2, weights=likely))

    def fitted(self, start: Complex, end_widths: float) -> _PlacedEnd:
        """Return a body fitted from a start."""
        st = self.settings
        moves = StrandMoves(end_widths, st.strand_sd_widths, st.end_sd_widths, st.iterations)
        return self._fitted_by(start, moves)

    def fitted_finer(self, start: Complex, end_widths: float) -> _PlacedEnd:
        """Return a body fitted from a start that lies well."""
        st = self.settings
        sds = st.finer_strand_sd_widths, st.finer_end_sd_widths
        return self._fitted_by(start, StrandMoves(end_widths, *sds, st.finer_iterations))

    def fitted_again(self, placed: _PlacedEnd) -> list[_PlacedEnd]:
        """Return a body fitted again, a little shorter and longer, too."""
        settings = self.settings
        starts = [
            _lengthened(placed.line, widths, self.width, settings)
            for widths in settings.finer_widths
        ]
        return [
            self.fitted_finer(start, placed.end_widths)
            for start in starts
            if len(start) >= settings.least_nodes
        ]

    def half_widths_of(self, nodes: int) -> Floats:
        """Return half the width at each node of a body of so many: many have as many."""
        if nodes not in self.half_widths:
            part = np.linspace(0, 1, nodes)
            self.half_widths[nodes] = rounded_half_widths(part, self.widths)
        return self.half_widths[nodes]

    def _fitted_by(self, start: Complex, moves: StrandMoves) -> _PlacedEnd:
        half = self.half_widths_of(len(start))
        cost, line = fitted_to_flanks(
            start, half, self.outline, self.place, self.width, moves, self.settings.fit
        )
        return _PlacedEnd(line, moves.end_widths, cost)


def rounded_half_widths(part: Floats, widths: Floats) -> Floats:
    """Return half the width at parts of a body's length, with its ends as round as they are blunt.

    Parameters
    ----------
    part : ndarray, shape (n,)
        0 to 1.
    widths : ndarray, shape (m,)
        At equal steps.
    """
    half = np.interp(part, np.linspace(0, 1, len(widths)), widths / 2)
    spacing, most = 1 / (len(widths) - 1), float(widths.max()) / 2
    for beside, from_end in ((widths[1] / 2, part), (widths[-2] / 2, 1 - part)):
        near = from_end < spacing
        power = min(max(1 - beside / most, 0.45), 1.0)
        half[near] = beside * (from_end[near].clip(0) / spacing) ** power
    return half


def _places_tried(
    curve: Complex, width: float, settings: EndByFlanksSettings
) -> Iterator[tuple[Complex, float]]:
    """Yield bodies whose first end lies in many places, and how much of each that end is."""
    step = _node_distance(curve)
    ways = _ways_on(curve, width, max(settings.longer_widths), settings)
    for longer in settings.longer_widths:
        for on in ways if longer > 0 else ways[:1]:
            left_out = len(on) - round(longer * width / step)
            whole = np.concatenate([on[::-1], curve])
            if left_out < 0 or left_out > len(whole) - settings.least_nodes:
                continue
            line = whole[left_out:]
            along = np.gradient(line)
            normal = 1j * along / np.maximum(np.abs(along), 1e-9)
            over = settings.aside_over_widths * width
            ramp = (1 - step * np.arange(len(line)) / over).clip(0) * width
            for aside in settings.aside_widths:
                yield line + aside * ramp * normal, settings.end_widths + max(longer, 0.0)


def _ways_on(
    curve: Complex, width: float, longest_widths: float, settings: EndByFlanksSettings
) -> list[Complex]:
    """Return ways on which a body may go on beyond its first end, the likeliest first.

    Along the strand that it lies on, either way, as far aside as it lies; and straight on.
    """
    step = _node_distance(curve)
    count = int(longest_widths * width / step)
    heading = curve[0] - curve[min(3, len(curve) - 1)]
    heading /= max(abs(heading), 1e-9)
    ways = list[tuple[float, Complex]]()
    apart = round(settings.least_apart_along_widths * width / step)
    if len(curve) > apart:
        beside = apart + int(np.abs(curve[apart:] - curve[0]).argmin())
        along = curve[min(beside + 2, len(curve) - 1)] - curve[max(beside - 2, 0)]
        along /= max(abs(along), 1e-9)
        for sign in (1, -1):
            cosine = sign * float((along * heading.conjugate()).real)
            strand = curve[beside::sign][: count + 1]
            if cosine > settings.least_cosine_of_strand and len(strand) > 3:
                ways.append((cosine, _along_strand(strand, complex(curve[0]))))
    if not any(cosine > settings.least_cosine_along_strand for cosine, _ in ways):
        ways.append((1.0, curve[0] + heading * step * np.arange(1, count + 1)))
    return [way for _, way in sorted(ways, key=lambda each: -each[0])]


def _along_strand(strand: Complex, place: complex) -> Complex:
    """Return a way on along a strand, as far aside as a place beside its first node."""
    tangent = np.gradient(strand)
    tangent /= np.maximum(np.abs(tangent), 1e-9)
    aside = ((place - strand[0]) / tangent[0]).imag
    return np.asarray((strand + 1j * aside * tangent)[1:])


def _lengthened(
    curve: Complex, widths: float, width: float, settings: EndByFlanksSettings
) -> Complex:
    """Return a body longer or shorter at its first end by some widths."""
    if widths <= 0:
        return curve[round(-widths * width / _node_distance(curve)) :]
    on = _ways_on(curve, width, widths, settings)[0]
    return np.concatenate([on[::-1], curve])


def _node_distance(curve: Complex) -> float:
    """Return how far apart a body's nodes are, pixels."""
    return float(complex_arc_length(curve)[-1]) / (len(curve) - 1)
