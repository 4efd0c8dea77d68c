"""Where a picture's grey levels say that an end lies, where overlaps are darker than the body.

The body is drawn with its end in many places, as dark as it is and as blurred, and compared with
the picture pixel by pixel: along the strand that the end lies on, either way, and a little aside.
A place along the path that one line of grey levels leaves open, as that of a thin tail on its own
strand, all of the picture about it tells.
"""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_tracker.midline.curve import complex_arc_length, tangents, unit_grid
from worm_tracker.midline.drawn_signal import BodySignal, SignalDrawingSettings, expected_signal
from worm_tracker.midline.end_places import EndPlacesSettings, lengthened, places_along
from worm_tracker.midline.likeliest_end import (
    KnownEnd,
    LikeliestEnd,
    LikeliestEndSettings,
    PlacedEnd,
    cost_at_first,
    likeliest_end,
)
from worm_tracker.midline.rounded_widths import rounded_half_widths

_EVERY_HALF_WIDTH = tuple(0.5 * k for k in range(-5, 7))


@dataclass(frozen=True, slots=True)
class EndBySignalSettings:
    """Which places are tried, how a body is drawn there, and how likely each is."""

    places: EndPlacesSettings = field(
        default_factory=partial(EndPlacesSettings, longer_widths=_EVERY_HALF_WIDTH)
    )
    tried_finer: int = 4
    aside_widths: tuple[float, ...] = (-0.3, -0.15, 0.15, 0.3)
    finer_widths: tuple[float, ...] = (-0.25, 0.25)
    """How many of those that do best are tried aside, and shorter and longer."""
    least_aside_widths: tuple[float, ...] = (-0.08, 0.08)
    finest_widths: tuple[float, ...] = (-0.12, 0.12)
    """The same of the best of those."""
    aside_over_widths: float = 2.5
    """How much of the body is moved aside then, its end all of the way."""
    reach_widths: float = 2.5
    beyond_reach_widths: float = 1.2
    """How far about the end the picture is compared, and how much more of it is drawn."""
    narrower_px: float = 0.5
    """How much narrower the body is drawn: each pixel that it touches is."""
    drawing: SignalDrawingSettings = field(default_factory=partial(SignalDrawingSettings, finer=2))
    likeliest: LikeliestEndSettings = field(
        default_factory=lambda: LikeliestEndSettings(
            likelihood=0.0064,
            likelihood_over_cost=0.2,
            most_cost=0.1,
            most_cost_moved=0.1,
            sd_over_spread=1.5,
        )
    )
    """By the squared differences from the picture, over the body's signal, summed over squared
    widths: 0.01 to 0.1 in the best place, more where the body lies otherwise. Of 1097 unsure ends
    in five films 608 are told so to 0.42 widths, one of them more than a width off (91 of all
    before); their root mean square error is half to two thirds of what is told."""


def end_by_signal(
    signal: Picture,
    body: BodySignal,
    widths: Floats,
    known: KnownEnd,
    settings: EndBySignalSettings,
) -> LikeliestEnd:
    """Return where the first end of a body lies best, by the picture's grey levels.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    body : BodySignal
        From that end on, in the signal's coordinates.
    widths : ndarray, shape (m,)
        Its widths from that end on, at equal parts of its length, pixels.
    known : KnownEnd
        That end.
    settings : EndBySignalSettings
    """
    places = _Picture.about(signal, body, widths, known, settings).places()
    return (
        likeliest_end(places, known, settings.likeliest) if places else LikeliestEnd(None, np.inf)
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Picture:
    """What is seen about an end, and the body that is drawn there."""

    seen: Floats32
    near: Floats32
    corner: complex
    body: BodySignal
    widths: Floats
    known: KnownEnd
    settings: EndBySignalSettings

    @classmethod
    def about(
        cls,
        signal: Picture,
        body: BodySignal,
        widths: Floats,
        known: KnownEnd,
        settings: EndBySignalSettings,
    ) -> "_Picture":
        """Return what of a picture is about an end."""
        place, reach_px = known.place, settings.reach_widths * known.width
        half = int(reach_px + settings.beyond_reach_widths * known.width)
        u0, v0 = max(int(place.real) - half, 0), max(int(place.imag) - half, 0)
        part = signal[v0 : int(place.imag) + half + 1, u0 : int(place.real) + half + 1]
        v, u = np.ogrid[: part.shape[0], : part.shape[1]]
        off = place - complex(u0, v0)
        near = (u - off.real) ** 2 + (v - off.imag) ** 2 < reach_px**2
        seen = part * np.float32(1 / body.level)
        corner, weight = complex(u0, v0), near.astype(np.float32)
        return cls(seen, weight, corner, body, widths, known, settings)

    def places(self) -> list[PlacedEnd]:
        """Return the body with its end in many places, first of all where it is."""
        if not self.seen.size:
            return []
        st, curve = self.settings, self.body.curve
        told = self.placed(curve)
        coarse = [self.placed(line) for line in places_along(curve, self.known.width, st.places)]
        few = sorted([told, *coarse], key=self.cost)[: st.tried_finer]
        finer = [p for each in few for p in self.beside(each, st.aside_widths, st.finer_widths)]
        best = min([told, *coarse, *finer], key=self.cost)
        return [
            told,
            *coarse,
            *finer,
            *self.beside(best, st.least_aside_widths, st.finest_widths),
        ]

    def beside(
        self, placed: PlacedEnd, aside: tuple[float, ...], longer: tuple[float, ...]
    ) -> list[PlacedEnd]:
        """Return the body with its end beside a place, and shorter and longer."""
        width, st = self.known.width, self.settings
        moved = [
            with_end_aside(placed.line, by * width, st.aside_over_widths * width) for by in aside
        ]
        lines = [lengthened(placed.line, widths, width, st.places) for widths in longer]
        return [self.placed(line) for line in [*moved, *lines] if line is not None]

    def placed(self, line: Complex) -> PlacedEnd:
        """Return a body that lies so, with what it differs from the picture."""
        body, st = self.body, self.settings
        widths = 2 * rounded_half_widths(unit_grid(len(line)), self.widths) - st.narrower_px
        drawn = expected_signal(
            self.seen.shape, self.corner, replace(body, curve=line), widths, True, st.drawing
        )
        off = (drawn - self.seen) * self.near
        cost = float(np.vdot(off, off)) / self.known.width**2
        return PlacedEnd(line, float(complex_arc_length(line)[-1]), cost)

    def cost(self, placed: PlacedEnd) -> float:
        """Return what a place costs, for those to be chosen that are tried finer."""
        return cost_at_first(placed, self.known, self.settings.likeliest)


def with_end_aside(line: Complex, by_px: float, over_px: float) -> Complex:
    """Return a body whose first end is moved aside, what is behind it the less.

    Parameters
    ----------
    line : ndarray of complex, shape (n,)
        From that end on, u + iv.
    by_px : float
        How far the end is moved, to the right of the body as it heads away from it in u + iv.
    over_px : float
        How much of the body is moved.
    """
    s = complex_arc_length(line)
    part = np.clip(1 - s / over_px, 0.0, None) ** 2
    return np.asarray(line + 1j * tangents(line) * part * by_px)
