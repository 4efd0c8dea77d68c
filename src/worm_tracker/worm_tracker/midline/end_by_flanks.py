"""Where the flanks of a body of one shade say that an end lies which lies on it.

Where overlaps are no darker an end on the body shows by the outline alone: the strand that it lies
on is broader beside it, by little and on one side. Many places in which it may be are tried, and in
each the strands there are moved until their flanks lie on the outline as well as they can. The end
is as sure as those places lie near to each other that do so about as well.
"""

from dataclasses import dataclass, field

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
from worm_tracker.midline.likeliest_end import (
    KnownEnd,
    LikeliestEnd,
    LikeliestEndSettings,
    PlacedEnd,
    cost_at_first,
    likeliest_end,
)
from worm_tracker.midline.object_outline import Outline
from worm_tracker.midline.rounded_widths import rounded_half_widths


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
    likeliest: LikeliestEndSettings = field(
        default_factory=lambda: LikeliestEndSettings(
            likelihood=1.2,
            likelihood_over_cost=0.3,
            most_cost=8.0,
            most_cost_moved=16.0,
            sd_over_spread=1.05,
        )
    )
    """By what places cost, squared pixels times pixels of flank. For noise alone a lesser
    likelihood would do, but widths are not known so well: true places cost 1 to 4 in films of one
    shade, and 50 to 180 on a real worm whose brightness is patchy. Of 613 ends told so to 0.35
    widths in eight films four were more than a width off; up to 0.15 widths their error was what is
    told, up to 0.35 one and a half times that."""
    fit: FlankFitSettings = field(default_factory=FlankFitSettings)


def end_by_flanks(
    outline: Outline,
    curve: Complex,
    widths: Floats,
    known: KnownEnd,
    settings: EndByFlanksSettings,
) -> LikeliestEnd:
    """Return where the first end of a body lies best, by its flanks.

    Parameters
    ----------
    outline : Outline
    curve : ndarray of complex, shape (n,)
        Where the body lies, from that end on at equal steps, in the same coordinates.
    widths : ndarray, shape (m,)
        Its widths from that end on, at equal parts of its length, pixels.
    known : KnownEnd
        That end, in these coordinates.
    settings : EndByFlanksSettings
    """
    near = outline.near(known.place, settings.fit.reach_widths * known.width)
    places = _Surroundings(near, widths, known, settings).places(curve)
    return likeliest_end(places, known, settings.likeliest)


@dataclass(frozen=True, eq=False, slots=True)
class _Surroundings:
    """An outline about an end, and the body that is fitted to it."""

    outline: Outline
    widths: Floats
    known: KnownEnd
    settings: EndByFlanksSettings
    half_widths: dict[int, Floats] = field(default_factory=dict)

    def places(self, curve: Complex) -> list[PlacedEnd]:
        """Return a body with its first end in many places; first of all where it is."""
        settings, width = self.settings, self.known.width
        half, tried = self.half_widths_of(len(curve)), settings.places
        starts = [
            *places_along(curve, width, tried),
            *places_beyond_flanks(curve, half, self.outline.pixels, width, tried),
        ]
        coarse = [self.fitted(start) for start in starts]
        coarse.sort(key=self.cost)
        few, others = coarse[: settings.tried_finer], coarse[settings.tried_finer :]
        finer = [again for each in few for again in self.fitted_again(each, settings.finer_widths)]
        places = [self.fitted_finer(curve), *finer, *others]
        return places + self.fitted_again(min(places, key=self.cost), settings.explored_widths)

    def cost(self, placed: PlacedEnd) -> float:
        """Return what a place costs, for the few to be chosen that are tried finer."""
        return cost_at_first(placed, self.known, self.settings.likeliest)

    def fitted(self, start: Complex) -> PlacedEnd:
        """Return a body fitted from a start."""
        st = self.settings
        sds = st.strand_sd_widths, st.end_sd_widths
        return self._fitted_by(start, StrandMoves(st.end_widths, *sds, st.iterations))

    def fitted_finer(self, start: Complex) -> PlacedEnd:
        """Return a body fitted from a start that lies well."""
        st = self.settings
        sds = st.finer_strand_sd_widths, st.finer_end_sd_widths
        return self._fitted_by(start, StrandMoves(st.end_widths, *sds, st.finer_iterations))

    def fitted_again(self, placed: PlacedEnd, longer: tuple[float, ...]) -> list[PlacedEnd]:
        """Return a body fitted again, some widths shorter or longer."""
        starts = [
            lengthened(placed.line, widths, self.known.width, self.settings.places)
            for widths in longer
        ]
        return [self.fitted_finer(start) for start in starts if start is not None]

    def half_widths_of(self, nodes: int) -> Floats:
        """Return half the width at each node of a body of so many: many have as many."""
        if nodes not in self.half_widths:
            self.half_widths[nodes] = rounded_half_widths(unit_grid(nodes), self.widths)
        return self.half_widths[nodes]

    def _fitted_by(self, start: Complex, moves: StrandMoves) -> PlacedEnd:
        half, known = self.half_widths_of(len(start)), self.known
        cost, line = fitted_to_flanks(
            start, half, self.outline, known.place, known.width, moves, self.settings.fit
        )
        length_px = float(complex_arc_length(line)[-1])
        return PlacedEnd(line, length_px, cost)
