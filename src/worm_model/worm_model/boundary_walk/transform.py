"""The boundary walk's linear equations, solved: transforms of τ_h, and skips, from any state.

Direction and phase make four states on a ring. From state i at x let u_i(x) = ⟨e^{−sτ_h}⟩. Outside
the exit a head moves at v, so u obeys four coupled linear differential equations with constant
coefficients; over the exit only hops live. With e = u₊ + u₋ and o = u₊ − u₋ (+, −: the direction;
each a pair: slide, hop), and lengths in place of times (κ = s/v),

    e′ = B o,   o′ = C e,   B = κ + D,   C = κ + G,

where −G is the generator of the phases alone and −D that of the phases weighted by the direction.
The mirror image of the walk is the walk, so e is even about the wall's middle and o odd, and two
numbers are left for the two conditions at the exit. Each mode is written with exponentials that
decay from the wall's ends, so nothing overflows on a large ring or for short slides.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.boundary_walk.relative_state import RelativeState
from worm_msgs_py.arrays import Complex

_SAME = 1e-13
"""Relative size below which the modes' 2 × 2 matrix is a multiple of one."""
_VANISHED = 1e-150
_FLAT = 3e-6
"""Below this μL a mode is straight to 1e-12."""


@dataclass(frozen=True, eq=False, slots=True)
class Solution:
    """One quantity of a walk, solved for all states; arrays over κ, the two modes in rows.

    The quantity is ⟨e^{−sτ_h}⟩ (`solve_transform`) or the mean number of skips (`solve_skips`).
    """

    parameters: WalkParameters
    modes: "_Modes"
    over: "_OverExit"
    amplitude: Complex
    skip: float
    """What leaving the exit's arc adds: 0, or 1 where skips are counted."""
    found: float
    """The quantity where the exit is found: 1, or 0 where skips are counted."""

    def at(self, place: RelativeState) -> Complex:
        """Return the quantity from one state, shape of κ."""
        if place.over_exit:
            return self._above(place.ahead_mm)
        slide, hop = self._forwards(place.ahead_mm)
        return hop if place.hopping else slide

    def uniform(self) -> Complex:
        """Return the quantity from a slide that starts uniformly on the wall."""
        modes = self.modes
        length = self.parameters.wall_mm
        return np.asarray((self.amplitude * modes.slide * modes.tanh_over_mu).sum(0) / length)

    def _forwards(self, ahead_mm: float) -> tuple[Complex, Complex]:
        """Return the quantity of a slide and of a hop, `ahead_mm` before the exit."""
        modes = self.modes
        even, odd = modes.shapes(self.parameters.wall_mm, ahead_mm)
        slide = (self.amplitude * (modes.slide * even + modes.slide_odd * odd)).sum(0) / 2.0
        hop = (self.amplitude * (modes.hop * even + modes.hop_odd * odd)).sum(0) / 2.0
        return slide, hop

    def _above(self, ahead_mm: float) -> Complex:
        slide, hop = self._forwards(self.parameters.wall_mm)
        share, lands, flies = self.over.at(self.parameters, ahead_mm)
        return np.asarray(
            share * (hop + self.skip)
            + lands * self.found
            + flies * (_from_far_edge(self.parameters, slide, self.found) + self.skip)
        )


def solve_transform(parameters: WalkParameters, s: NDArray[np.inexact]) -> Solution:
    """Solve for ⟨e^{−sτ_h}⟩.

    Parameters
    ----------
    parameters : WalkParameters
        The walk.
    s : ndarray, shape (n,)
        Laplace's variable, 1/s, to the right of the law's slowest decay.
    """
    kappa = np.asarray(s, dtype=np.complex128) / parameters.speed_mm_s
    modes, over = _solve_modes(parameters, kappa), _solve_over(parameters, kappa)
    return _join(parameters, modes, over, found=1.0, skip=0.0)


def solve_skips(parameters: WalkParameters) -> Solution:
    """Solve for the mean number of skips until the exit is found, shape (1,)."""
    zero = np.zeros(1, dtype=np.complex128)
    modes, over = _solve_modes(parameters, zero), _solve_over(parameters, zero)
    return _join(parameters, modes, over, found=0.0, skip=1.0)


def _from_far_edge(parameters: WalkParameters, slide: Complex, found: float) -> Complex:
    """Return the quantity of a hop that flew on to the far edge.

    There it becomes a slide and goes on, or turns, and so finds the exit.

    Only where a hop may not land.
    """
    turns = parameters.flip_after_hop
    return np.asarray((1.0 - turns) * slide + turns * found)


def _join(
    parameters: WalkParameters, modes: "_Modes", over: "_OverExit", found: float, skip: float
) -> Solution:
    """Fit the modes' amplitudes to the exit: a slide finds it, a hop passes over it."""
    half = modes.tanh_over_mu
    # Going forwards, before the exit (x = L) and behind it (x = 0).
    slide_before, slide_behind = (
        (modes.slide + sign * half * modes.slide_odd) / 2.0 for sign in (1.0, -1.0)
    )
    hop_before, hop_behind = (
        (modes.hop + sign * half * modes.hop_odd) / 2.0 for sign in (1.0, -1.0)
    )
    share, lands, flies = over.at(parameters, parameters.exit_arc_mm)
    turns = parameters.flip_after_hop
    row = hop_before - share * hop_behind - flies * (1.0 - turns) * slide_behind
    right = lands * found + flies * (turns * found + skip) + share * skip
    determinant = slide_before[0] * row[1] - slide_before[1] * row[0]
    amplitude = np.stack(
        [
            (found * row[1] - slide_before[1] * right) / determinant,
            (slide_before[0] * right - found * row[0]) / determinant,
        ]
    )
    return Solution(parameters, modes, over, amplitude, skip, found)


@dataclass(frozen=True, eq=False, slots=True)
class _Modes:
    """The wall's two modes, shape (2, n): e = (slide, hop) cosh μy, o = (…_odd) sinh(μy)/μ."""

    mu: Complex
    slide: Complex
    hop: Complex
    slide_odd: Complex
    hop_odd: Complex
    decay: Complex
    """e^{−μL}."""
    tanh_over_mu: Complex
    """tanh(μL/2)/μ."""

    def shapes(self, length: float, ahead: float) -> tuple[Complex, Complex]:
        """Return cosh μy and sinh(μy)/μ, both over cosh(μL/2), at y = L/2 − ahead."""
        larger = np.exp(-self.mu * min(ahead, length - ahead))
        rest = np.zeros_like(larger)
        np.divide(self.decay, larger, out=rest, where=np.abs(larger) > _VANISHED)
        near, far = (larger, rest) if ahead <= length - ahead else (rest, larger)
        both = 1.0 + self.decay
        flat = np.abs(self.mu) * length < _FLAT
        mu = np.where(flat, 1.0, self.mu)
        odd = np.where(flat, length / 2.0 - ahead, (near - far) / (mu * both))
        return (near + far) / both, odd


def _solve_modes(parameters: WalkParameters, kappa: Complex) -> _Modes:
    """Return the eigenvectors of BC and the roots of its eigenvalues, without cancellation."""
    sigma, eta = 1.0 / parameters.mean_slide_mm, 1.0 / parameters.mean_hop_mm
    value, m12, m21 = _eigenvalues(parameters, kappa)
    # C(1, 1) = κ(1, 1): at small κ what matters is by how much a vector (1, 1 + ε), or (1 + ε, 1),
    # deviates from that, so it is solved for: from the matrix's row of the larger coupling.
    by_slide = np.abs(m12) >= np.abs(m21)
    turning = kappa + 2.0 * parameters.flip_rate_s / parameters.speed_mm_s
    turns_s = turning + 2.0 * sigma * parameters.flip_after_slide
    turns_h = turning + 2.0 * eta * parameters.flip_after_hop
    coupling = np.where(by_slide, m12, m21)
    uncoupled = np.abs(coupling) <= _SAME * np.abs(value).sum(axis=0)
    epsilon = (value - kappa * np.where(by_slide, turns_s, turns_h)) / np.where(
        uncoupled, 1.0, coupling
    )
    # A multiple of one has any two vectors.
    epsilon = np.where(uncoupled, np.array([[0.0], [-2.0]]), epsilon)
    slide, hop = np.where(by_slide, 1.0, 1.0 + epsilon), np.where(by_slide, 1.0 + epsilon, 1.0)
    slide_odd = np.where(by_slide, kappa - sigma * epsilon, kappa * slide + sigma * epsilon)
    hop_odd = np.where(by_slide, kappa * hop + eta * epsilon, kappa - eta * epsilon)
    mu, length = np.sqrt(value), parameters.wall_mm
    flat, decay = np.abs(mu) * length < _FLAT, np.exp(-mu * length)
    tanh = np.where(flat, length / 2.0, (1.0 - decay) / (np.where(flat, 1.0, mu) * (1.0 + decay)))
    return _Modes(mu, slide, hop, slide_odd, hop_odd, decay, tanh)


def _eigenvalues(parameters: WalkParameters, kappa: Complex) -> tuple[Complex, Complex, Complex]:
    """Return the eigenvalues of BC, shape (2, n), and its elements off the diagonal."""
    sigma, eta = 1.0 / parameters.mean_slide_mm, 1.0 / parameters.mean_hop_mm
    rho = parameters.flip_rate_s / parameters.speed_mm_s
    q_s, q_h = parameters.flip_after_slide, parameters.flip_after_hop
    kept_s, kept_h = 1.0 - 2.0 * q_s, 1.0 - 2.0 * q_h
    b11, b22 = kappa + sigma + 2.0 * rho, kappa + eta + 2.0 * rho
    m11 = b11 * (kappa + sigma) + sigma * kept_s * eta
    m12 = -sigma * (b11 + kept_s * (kappa + eta))
    m21 = -eta * (b22 + kept_h * (kappa + sigma))
    m22 = b22 * (kappa + eta) + eta * kept_h * sigma
    det_d = 2.0 * sigma * eta * (q_s + q_h - 2.0 * q_s * q_h)
    det_d += 2.0 * rho * (sigma + eta + 2.0 * rho)
    det_b = kappa * (kappa + sigma + eta + 4.0 * rho) + det_d
    det_c = kappa * (kappa + sigma + eta)
    middle, gap = (m11 + m22) / 2.0, np.sqrt(((m11 - m22) / 2.0) ** 2 + m12 * m21)
    large = middle + np.where((np.conj(middle) * gap).real < 0.0, -gap, gap)
    # Both are 0 at κ = 0 where slides and hops are alike and each end of either turns.
    small = np.divide(det_b * det_c, large, out=np.zeros_like(large), where=large != 0.0)
    return np.stack([small, large]), m12, m21


@dataclass(frozen=True, eq=False, slots=True)
class _OverExit:
    """Hops above the exit: they turn around there too, where the rule is a rate."""

    kappa: Complex
    nu: Complex
    ratio: Complex

    def at(self, parameters: WalkParameters, ahead: float) -> tuple[Complex, Complex, Complex]:
        """Return what a hop `ahead` of the far edge comes to.

        It leaves the arc as a hop, lands, or flies on to an edge where it becomes a slide: each
        with its transform. Both edges are one, by symmetry.
        """
        arc = parameters.exit_arc_mm
        kappa, eta = self.kappa, 1.0 / parameters.mean_hop_mm
        rho = parameters.flip_rate_s / parameters.speed_mm_s
        most, least = 1.0 + self.ratio, 1.0 - self.ratio
        share = (most * np.exp(-self.nu * ahead) + least * np.exp(-self.nu * (arc - ahead))) / (
            most + least * np.exp(-self.nu * arc)
        )
        if parameters.hop_may_land:
            return share, eta / (eta + kappa) * (1.0 - share), np.zeros_like(share)
        back = rho / (eta + rho + 2.0 * kappa)
        on = eta / (eta + rho - rho * back)
        here = on * (np.exp(-kappa * ahead) + back * np.exp(-kappa * (arc - ahead)))
        edge = on * (1.0 + back * np.exp(-kappa * arc))
        return share, np.zeros_like(share), here - share * edge


def _solve_over(parameters: WalkParameters, kappa: Complex) -> _OverExit:
    eta = 1.0 / parameters.mean_hop_mm + kappa
    turning = eta + 2.0 * parameters.flip_rate_s / parameters.speed_mm_s
    return _OverExit(kappa, np.sqrt(eta * turning), np.sqrt(eta / turning))
