"""Bodies laid along arcs, which may lie on themselves, as the simulator's renderer draws them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from hypothesis import strategies as st

from worm_model.simulator.rig import Body, Optics, Rig, expose
from worm_model.simulator.rig.strands import (
    Layers,
    Shade,
    covered,
    polyline_body,
    shaded_view,
    strands_over,
)

LIGHT, TRANSMISSION = 200.0, 0.45
LEVEL = LIGHT * (1 - TRANSMISSION)
"""Signal of one layer, grey levels."""
DARKENING = TRANSMISSION
"""What a second layer adds to it, relatively: (1 - T)(1 + T) = 1 - T²."""
NODES_PER_WIDTH = 16
MARGIN_WIDTHS = 4.0

Arcs = list[tuple[float, float]]
"""Stretches of constant curvature: length, widths, and turn over a width, radians."""


def laid(arcs: Arcs, width: float, heading: float = 0.0):
    """Return the curve that stretches of constant curvature make one after the other, u + iv."""
    turns = np.concatenate(
        [np.full(round(length * NODES_PER_WIDTH), turn / NODES_PER_WIDTH) for length, turn in arcs]
    )
    direction = heading + np.cumsum(turns) - turns / 2
    return np.concatenate([[0.0], np.cumsum(width / NODES_PER_WIDTH * np.exp(1j * direction))])


def as_rows(curve):
    return np.stack([curve.real, curve.imag], axis=1)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A body in a window, as the renderer draws it.

    Attributes
    ----------
    curve : ndarray of complex, shape (n,)
        Its true midline in the window, NODES_PER_WIDTH nodes in a width.
    width : float
        Pixels; each end is half a circle.
    darker : bool
        Whether it is darker where it lies on itself.
    noise : float
        Grey levels.
    """

    curve: np.ndarray
    width: float
    darker: bool = True
    noise: float = 0.0

    @classmethod
    def of(cls, arcs: Arcs, width: float, heading: float = 0.0, **look) -> "Drawn":
        curve = laid(arcs, width, heading)
        margin = MARGIN_WIDTHS * width * (1 + 1j)
        return cls(curve - complex(curve.real.min(), curve.imag.min()) + margin, width, **look)

    @property
    def length(self) -> float:
        return self.body.length_px

    @cached_property
    def body(self) -> Body:
        return polyline_body(as_rows(self.curve), np.full(len(self.curve), self.width))

    @cached_property
    def rig(self) -> Rig:
        """Return nothing but water: a chamber wider than the window."""
        far = MARGIN_WIDTHS * self.width
        size = [int(np.ceil(x.max() + far)) + 1 for x in (self.curve.real, self.curve.imag)]
        optics = Optics(
            light=LIGHT,
            worm_transmission=TRANSMISSION,
            gradient=(0.0, 0.0),
            noise=self.noise,
            blur_px=0.8,
        )
        return Rig(
            width_px=size[0],
            height_px=size[1],
            px_per_mm=10.0,
            centre_px=(size[0] / 2, size[1] / 2),
            radius_mm=0.2 * max(size),
            optics=optics,
        )

    @cached_property
    def strands(self) -> Layers:
        return strands_over(self.body)

    @cached_property
    def layers(self) -> np.ndarray:
        """Return how many strands lie over each pixel, in the mean over it."""
        found = self.strands
        rows, columns = found.total.shape[0] // 3, found.total.shape[1] // 3
        window = np.zeros((self.rig.height_px, self.rig.width_px))
        here = np.s_[found.v0 : found.v0 + rows, found.u0 : found.u0 + columns]
        window[here] = found.total.reshape(rows, 3, columns, 3).mean(axis=(1, 3))
        return window

    @cached_property
    def signal(self) -> np.ndarray:
        """Return water minus picture."""
        view = shaded_view(self.rig, self.strands, Shade(overlap_darker=self.darker))
        picture = expose(self.rig, view, 0).astype(float)
        return np.clip(np.rint(LIGHT - picture), 0, 255).astype(np.uint8)

    @property
    def mask(self) -> np.ndarray:
        return (self.signal >= LEVEL / 2).astype(np.uint8) * 255

    @property
    def area(self) -> float:
        """Return the area that the body covers, pixels."""
        return float(covered(self.strands).part.sum())

    def claimed(self, first_widths: float = 0.0, last_widths: float = 0.0):
        """Return midline points and widths, the ends so much within the true ones (or beyond)."""
        at = np.linspace(first_widths * self.width, self.length - last_widths * self.width, 65)
        return as_rows(self.at(at)), rounded_widths(at - at[0], self.width)

    def at(self, s):
        """Return points of the midline, u + iv; beyond its ends on straight lines."""
        true = self.body.points_px @ np.array([1, 1j])
        inner = np.interp(s, self.body.s_px, true)
        first = (self.curve[0] - self.curve[1]) / abs(self.curve[0] - self.curve[1])
        last = (self.curve[-1] - self.curve[-2]) / abs(self.curve[-1] - self.curve[-2])
        beyond = np.maximum(s - self.length, 0.0) * last + np.maximum(-s, 0.0) * first
        return inner + beyond


def rounded_widths(s, width: float):
    """Return widths along a body of one width whose ends are half circles."""
    inside = np.clip(1 - 2 * np.minimum(s, s[-1] - s) / width, 0.0, 1.0)
    return width * np.sqrt(1 - inside**2)


WIDTHS = st.floats(8.0, 16.0)
HEADINGS = st.floats(0.0, 2 * np.pi)
BENDS = st.lists(
    st.tuples(st.floats(1.0, 4.0), st.floats(-0.7, 0.7)), min_size=3, max_size=6
).filter(lambda arcs: sum(length for length, _ in arcs) > 8.0)
"""Any way that a body bends; it may cross itself, and turn as tightly as 1.4 widths."""


@st.composite
def loops(draw) -> Arcs:
    """Draw a body that goes round a loop and, mostly, on across itself."""
    turn = draw(st.floats(0.4, 0.7)) * draw(st.sampled_from([-1, 1]))
    round_rad = draw(st.floats(3.8, 7.5))
    lead = draw(st.floats(2.0, 6.0)), draw(st.floats(-0.2, 0.2))
    onwards = draw(st.floats(1.0, 6.0)), draw(st.floats(-0.4, 0.4))
    return [lead, (round_rad / abs(turn), turn), onwards]
