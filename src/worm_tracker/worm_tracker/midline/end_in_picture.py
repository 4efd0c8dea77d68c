"""Where an end of a body lies best by how well the body, drawn so, is what is seen about the end.

The body is drawn with its end in many places, by whoever asks, and compared with the picture pixel
by pixel: along the strand that the end lies on, either way, and a little aside.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from worm_msgs_py.arrays import Complex, Floats32, Picture
from worm_tracker.midline.curve import complex_arc_length, tangents
from worm_tracker.midline.end_places import EndPlacesSettings, lengthened, places_along
from worm_tracker.midline.likeliest_end import (
    KnownEnd,
    LikeliestEnd,
    LikeliestEndSettings,
    PlacedEnd,
    cost_at_first,
    likeliest_end,
)

_EVERY_HALF_WIDTH = tuple(0.5 * k for k in range(-5, 7))


@dataclass(frozen=True, slots=True)
class EndInPictureSettings:
    """Which places are tried, and how likely each is.

    By the squared differences from the picture, over the body's signal, summed over squared widths.
    """

    likeliest: LikeliestEndSettings
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

    @property
    def moved_widths(self) -> float:
        """How much of the body from its end on lies otherwise in some place."""
        shorter = (self.places.longer_widths, self.finer_widths, self.finest_widths)
        return self.aside_over_widths - sum(map(min, shorter))


@dataclass(frozen=True, eq=False, slots=True)
class PictureAboutEnd:
    """What is seen about an end.

    Attributes
    ----------
    seen : ndarray of float32, shape (h, w)
        Signal over the body's, in a window.
    near : ndarray of float32, shape (h, w)
        1 where it is compared, else 0.
    corner : complex
        Where the window begins, u + iv.
    known : KnownEnd
    settings : EndInPictureSettings
    """

    seen: Floats32
    near: Floats32
    corner: complex
    known: KnownEnd
    settings: EndInPictureSettings

    @classmethod
    def of(
        cls, signal: Picture, level: float, known: KnownEnd, settings: EndInPictureSettings
    ) -> "PictureAboutEnd":
        """Return what of a picture's signal is about an end of a body whose signal is `level`."""
        place, reach_px = known.place, settings.reach_widths * known.width
        half = int(reach_px + settings.beyond_reach_widths * known.width)
        u0, v0 = max(int(place.real) - half, 0), max(int(place.imag) - half, 0)
        part = signal[v0 : int(place.imag) + half + 1, u0 : int(place.real) + half + 1]
        v, u = np.ogrid[: part.shape[0], : part.shape[1]]
        off = place - complex(u0, v0)
        near = (u - off.real) ** 2 + (v - off.imag) ** 2 < reach_px**2
        seen = part * np.float32(1 / level)
        return cls(seen, near.astype(np.float32), complex(u0, v0), known, settings)

    def cost_of(self, line: Complex, drawn: Callable[[Complex], Floats32]) -> float:
        """Return what a body that lies along a midline costs, drawn as in `likeliest_end`."""
        off = (drawn(line) - self.seen) * self.near if self.seen.size else self.seen
        return float(np.vdot(off, off)) / self.known.width**2

    def likeliest_end(self, curve: Complex, drawn: Callable[[Complex], Floats32]) -> LikeliestEnd:
        """Return where the first end of a body lies best.

        Parameters
        ----------
        curve : ndarray of complex, shape (n,)
            Its midline from that end on, u + iv; places differ from it by no more of its first
            nodes than lie on `moved_widths` of its length.
        drawn : callable
            Draws the body along a midline in the window, its signal over most of its own.
        """
        if not self.seen.size:
            return LikeliestEnd(None, np.inf)
        places = _Search(self, drawn).places(curve)
        return likeliest_end(places, self.known, self.settings.likeliest)


@dataclass(frozen=True, eq=False, slots=True)
class _Search:
    """Places of an end, with what a body that is drawn so differs from the picture."""

    picture: PictureAboutEnd
    drawn: Callable[[Complex], Floats32]

    def places(self, curve: Complex) -> list[PlacedEnd]:
        """Return the body with its end in many places, first of all where it is."""
        known, st = self.picture.known, self.picture.settings
        told = self.placed(curve)
        coarse = [self.placed(line) for line in places_along(curve, known.width, st.places)]
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
        width, st = self.picture.known.width, self.picture.settings
        moved = [
            with_end_aside(placed.line, by * width, st.aside_over_widths * width) for by in aside
        ]
        lines = [lengthened(placed.line, widths, width, st.places) for widths in longer]
        return [self.placed(line) for line in [*moved, *lines] if line is not None]

    def placed(self, line: Complex) -> PlacedEnd:
        """Return a body that lies so, with what it differs from the picture."""
        cost = self.picture.cost_of(line, self.drawn)
        return PlacedEnd(line, float(complex_arc_length(line)[-1]), cost)

    def cost(self, placed: PlacedEnd) -> float:
        """Return what a place costs, for those to be chosen that are tried finer."""
        return cost_at_first(placed, self.picture.known, self.picture.settings.likeliest)


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
