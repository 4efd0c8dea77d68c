"""Where the law of τ_h is singular: heads that do not turn, and those that turn once.

In closed form. Without these parts what is left of the law has a continuous density, so that it can
be inverted numerically.
"""

from functools import lru_cache
from math import exp, expm1, sqrt

import numpy as np

from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.relative_state import RelativeState
from worm_model.boundary_walk.singular_terms import Series, SingularTerms, hop_rates
from worm_msgs_py.arrays import Floats

_SERIES_BELOW = 1e-2


def singular_terms_of(parameters: WalkParameters, relative: RelativeState | None) -> SingularTerms:
    """Return the singular terms of the law from a state, or from a uniform start (None)."""
    builder = _builder(parameters)
    if relative is None:
        return builder.from_anywhere()
    return builder.above(relative) if relative.over_exit else builder.on_wall(relative)


@lru_cache(maxsize=16)
def _builder(parameters: WalkParameters) -> "_TermBuilder":
    return _TermBuilder(parameters)


class _TermBuilder:
    """What a walk's singular terms are made of; rows are (slide, hop), matrices act from the right.

    `keep` has the rates of the phases between reversals, and `flip` half the rates of reversal: two
    paths that were reversed at different places come apart at twice the speed.
    """

    def __init__(self, parameters: WalkParameters):
        self.parameters = parameters
        sigma, eta = 1.0 / parameters.mean_slide_mm, 1.0 / parameters.mean_hop_mm
        rho = parameters.flip_rate_s / parameters.speed_mm_s
        q_s, q_h = parameters.flip_after_slide, parameters.flip_after_hop
        self.keep = np.array([[-sigma - rho, sigma * (1.0 - q_s)], [eta * (1.0 - q_h), -eta - rho]])
        self.flip = np.array([[rho, sigma * q_s], [eta * q_h, rho]]) / 2.0
        self.wall, self.arc = parameters.wall_mm, parameters.exit_arc_mm
        self.along_wall = self.along(self.wall)
        self.over_arc = self.over(self.arc)
        self.around = self.over_arc @ self.along_wall
        """A hop at the exit, one round later, if there was no reversal."""
        self.around_with_two_reversals = self.over_with_two_reversals(self.arc) @ self.along_wall
        self.around_with_two_reversals += self.over_arc @ self.along_with_two_reversals(self.wall)

    def along(self, distance: float) -> Floats:
        """Return exp(keep·distance): phases at the end, if there was no reversal."""
        middle, _, cosh, sinh, _ = self._hyperbolic(distance)
        return np.asarray(cosh * np.eye(2) + sinh * (self.keep - middle * np.eye(2)))

    def _hyperbolic(self, y: float) -> tuple[float, float, float, float, float]:
        """Return m and g, of the eigenvalues m ± g of `keep`, and functions of them.

        These are e^{my}·cosh gy, e^{my}·sinh(gy)/g and e^{my}·(y cosh gy − sinh(gy)/g)/2g².
        """
        (a, b), (c, d) = self.keep
        middle, gap = float(a + d) / 2.0, sqrt(((a - d) / 2.0) ** 2 + b * c)
        slow, both = exp((middle + gap) * y), -expm1(-2.0 * gap * y)
        cosh = slow * (2.0 - both) / 2.0
        sinh = slow * (both / (2.0 * gap) if gap > 0.0 else y)
        if gap * y < _SERIES_BELOW:
            return middle, gap, cosh, sinh, exp(middle * y) * y**3 / 6.0 * (1 + (gap * y) ** 2 / 10)
        return middle, gap, cosh, sinh, (y * cosh - sinh) / (2.0 * gap**2)

    def over(self, arc: float) -> Floats:
        """Return the row of a hop that leaves an arc of the exit: as a slide, as a hop."""
        _, leave = hop_rates(self.parameters)
        stays = np.exp(-leave * arc)
        if self.parameters.hop_may_land:
            return np.array([0.0, stays])
        ends = -np.expm1(-leave * arc) / (leave * self.parameters.mean_hop_mm)
        return np.array([ends * (1.0 - self.parameters.flip_after_hop), stays])

    def edge_find(self, arc: float) -> float:
        """Return how often a hop flies on to the far edge, turns there, and finds the exit."""
        if self.parameters.hop_may_land:
            return 0.0
        return float(-np.expm1(-arc / self.parameters.mean_hop_mm) * self.parameters.flip_after_hop)

    def along_with_two_reversals(self, distance: float) -> Floats:
        """Return the change of `along` by two reversals in short order, anywhere on the way.

        The head goes back by d and on again: found later by 2d, so it adds to the density.
        """
        middle, _, cosh, sinh, both = self._hyperbolic(distance)
        twice = 2.0 * self.flip @ self.flip
        rest = self.keep - middle * np.eye(2)
        # ∫ exp(keep·y)·twice·exp(keep·(distance − y)) dy, as rest·rest is a multiple of one.
        return np.asarray(
            (distance * cosh + sinh) / 2.0 * twice
            + distance * sinh / 2.0 * (twice @ rest + rest @ twice)
            + both * rest @ twice @ rest
        )

    def over_with_two_reversals(self, arc: float) -> Floats:
        """Return the same change of `over`."""
        _, leave = hop_rates(self.parameters)
        both, stays = 2.0 * self.flip[1, 1] ** 2, np.exp(-leave * arc)
        if self.parameters.hop_may_land:
            return np.array([0.0, both * arc * stays])
        ends = (-np.expm1(-leave * arc) - leave * arc * stays) / leave**2
        return np.array([both * ends / self.parameters.mean_hop_mm, both * arc * stays])

    def finds_after_two_reversals(self, before: float, row: Floats, late: Floats) -> list[Series]:
        """Return the jumps of the density just behind the atoms, by two reversals.

        `late` is the change of `row`.
        """
        arc, around, change = self.arc, self.around, self.around_with_two_reversals
        found = []
        for after, slide, hop in ((0.0, 1.0, 0.0), (arc, 0.0, self.edge_find(arc))):
            if not (slide or hop):
                continue
            finds = np.array([slide, hop])
            once = late[1] * (around @ finds) + row[1] * (change @ finds)
            twice = row[1] * change[1] * (around @ finds)
            weights = map(float, (late @ finds, once, twice))
            found.append(Series(before + after, *weights))
        return found

    def finds(self, before: float, row: Floats, scale: float = 1.0) -> list[Series]:
        """Return when a row that comes to the exit after `before` finds it, without reversal."""
        arc, around = self.arc, self.around
        found = []
        for late, slide, hop in ((0.0, 1.0, 0.0), (arc, 0.0, self.edge_find(arc))):
            once, first = (float(r[0] * slide + r[1] * hop) for r in (around, row))
            if slide or hop:
                found.append(Series(before + late, first * scale, float(row[1]) * once * scale))
        return found

    def turns_again(self, before: float, row: Floats, turn: Floats, scale: float) -> list[Series]:
        """Return the finds of rows that come to the exit again and again, and each time turn.

        At each coming a row r is followed by r·turn, which comes to the exit after `before`.
        """
        around = self.around
        start, later = row @ turn, row[1] * (around @ turn)
        found = []
        for one, two in zip(
            self.finds(before, start, scale), self.finds(before, later, scale), strict=True
        ):
            # (one₀ + one₁ z/(1−vz)) + z/(1−vz) · (two₀ + two₁ z/(1−vz))
            found.append(Series(one.first_mm, one.weight, one.once + two.weight, two.once))
        return found

    def turned_at_exit(self, before: float, row: Floats) -> list[Series]:
        """Return the density's jumps by turning just before, above or just behind the exit."""
        arc = self.arc
        back = self.along_wall
        wall_again = before + self.wall
        hop = np.array([[0.0, 0.0], [0.0, 1.0]])
        pass_over = np.array([[0.0, 0.0], self.over_arc])
        stays = np.array([[0.0, 0.0], [0.0, self.over_arc[1]]])
        return [
            *self.turns_again(wall_again, row, self.flip @ back, -1.0),
            *self.turns_again(wall_again, row, hop @ self.flip @ hop @ back, 1.0),
            *self.turns_again(
                wall_again + 2.0 * arc, row, stays @ self.flip @ pass_over @ back, -1.0
            ),
            *self.turns_again(before + arc, row, pass_over @ self.flip, 1.0),
        ]

    def on_wall(self, relative: RelativeState) -> SingularTerms:
        ahead = relative.ahead_mm
        start = np.array([0.0, 1.0] if relative.hopping else [1.0, 0.0])
        row = start @ self.along(ahead)
        behind = self.wall - ahead
        jumps = [
            *self.finds_after_two_reversals(
                ahead, row, start @ self.along_with_two_reversals(ahead)
            ),
            *self.finds(behind, start @ self.flip @ self.along(behind)),
            *self.turned_at_exit(ahead, row),
        ]
        return self._parts(self.finds(ahead, row), self.finds_by_landing(ahead, row), jumps)

    def above(self, relative: RelativeState) -> SingularTerms:
        ahead, arc = relative.ahead_mm, self.arc
        out = self.over(ahead)
        back = self.along_wall
        turning = self.flip[1, 1]
        behind = arc - ahead
        late = self.over_with_two_reversals(ahead) @ back + out @ self.along_with_two_reversals(
            self.wall
        )
        jumps = [
            *self.finds_after_two_reversals(ahead + self.wall, out @ back, late),
            *self.finds(behind + self.wall, turning * self.over(behind) @ back),
            *self.finds(ahead + arc + self.wall, -turning * out[1] * self.over_arc @ back),
            *self.finds(ahead, out @ self.flip),
            *self.turned_at_exit(ahead + self.wall, out @ back),
        ]
        row, before = out @ back, ahead + self.wall
        atoms = [Series(ahead, self.edge_find(ahead)), *self.finds(before, row)]
        landings = self.finds_by_landing(before, row)
        if self.parameters.hop_may_land:
            landings.append((Series(0.0, 1.0), ahead))
        return self._parts(atoms, landings, jumps)

    def from_anywhere(self) -> SingularTerms:
        start = np.array([1.0, 0.0])
        jumps = [
            *self.finds(0.0, start, 1.0 / self.wall),
            *self.finds(self.wall, start @ self.along(self.wall), -1.0 / self.wall),
        ]
        return self._parts([], [], jumps)

    def finds_by_landing(self, before: float, row: Floats) -> list[tuple[Series, float]]:
        """Return when hops of a row that comes to the exit begin to pass over it."""
        if not self.parameters.hop_may_land:
            return []
        again = float(row[1] * self.around[1])
        return [(Series(before, float(row[1]), again), self.parameters.exit_arc_mm)]

    def _parts(
        self, atoms: list[Series], landings: list[tuple[Series, float]], jumps: list[Series]
    ) -> SingularTerms:
        fade = float(-np.trace(self.keep) / 2.0)
        return SingularTerms(
            self.parameters,
            float(self.around[1]),
            fade,
            _merge(atoms),
            tuple(landings),
            _merge(jumps),
        )


def _merge(parts: list[Series]) -> tuple[Series, ...]:
    """Add up series that begin at one distance."""
    merged: dict[float, Series] = {}
    for part in parts:
        key = round(part.first_mm, 9)
        other = merged.get(key, Series(part.first_mm, 0.0))
        merged[key] = Series(
            other.first_mm,
            other.weight + part.weight,
            other.once + part.once,
            other.twice + part.twice,
        )
    return tuple(merged.values())
