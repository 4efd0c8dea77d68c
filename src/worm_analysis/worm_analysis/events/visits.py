"""Stays in a chamber: the first touch of the wall, the finding of the exit, and the skips."""

from dataclasses import dataclass
from math import ceil, floor, nan, pi

from worm_analysis.events.exit_region import EXITS, ExitCorridor, ExitSettings
from worm_analysis.kinematics.observables import wrap_angle
from worm_msgs_py import Visit
from worm_msgs_py.units import NS_PER_S


@dataclass(slots=True)
class _Stay:
    """The current visit; `found` once the head has entered the exit for the first time."""

    chamber: str
    start_ns: int
    start_seen: bool
    last_ns: int
    first_contact_ns: int | None = None
    theta_h0_rad: float = nan
    may_touch_rad: float = nan
    skips: int = 0
    found: bool = False


class Visits:
    """Follows the body from chamber to chamber (paper, section on Figs 5 to 7).

    A visit starts when the head comes into a chamber with the body behind it, and is closed when
    the head first enters the exit. Where the head withdraws, the body has not left: skips are
    still counted for the trial, but there is no second τ_h, because the search would start at the
    exit.
    """

    def __init__(self, settings: ExitSettings = EXITS) -> None:
        self._in_doubt_rad = settings.first_touch_in_doubt_rad
        self._stay: _Stay | None = None
        self._ended: list[tuple[_Stay, int, bool]] = []
        self._left = False
        self.number = 0
        self.skips = self.wide_skips = 0

    @property
    def home(self) -> str:
        """The chamber that the body is in; empty while it is in the passage, or not known."""
        return self._stay.chamber if self._stay else ""

    def locate(self, chamber: str, stamp_ns: int) -> None:
        """Say which chamber the head is in.

        A visit that ends so, without the exit having been seen found, is incomplete.
        """
        if self._stay and self._stay.chamber == chamber:
            self._stay.last_ns = stamp_ns
            return
        self.finish()
        self._stay = _Stay(chamber, stamp_ns, self._left, stamp_ns)
        self._left = False
        self.number += 1

    def stay(self, stamp_ns: int) -> None:
        """Say that the head is in the same chamber as before."""
        assert self._stay is not None
        self._stay.last_ns = stamp_ns

    def ended(self) -> list[Visit]:
        """Return the visits that have ended; their contacts and hops must have been told."""
        visits = [_visit(stay, end_ns, complete=complete) for stay, end_ns, complete in self._ended]
        self._ended = []
        return visits

    def may_touch(self, theta_rad: float) -> None:
        """Take where an episode may be in contact first; NaN where it is not. θ_h as in `touch`."""
        stay = self._searching
        if stay is not None and stay.may_touch_rad != stay.may_touch_rad:
            stay.may_touch_rad = theta_rad

    def touch(self, stamp_ns: int, theta_rad: float) -> None:
        """Take a contact where it begins; θ_h may be unwrapped.

        Contacts and hops are known for good a little later than the visit's end: they are those of
        the visit that has ended, until it is taken. A touch that is shorter than a frame may hide
        in noise: where the head may have touched elsewhere before, θ_h⁰ is not told.
        """
        stay = self._searching
        if stay is not None and stay.first_contact_ns is None:
            stay.first_contact_ns = stamp_ns
            if not abs(wrap_angle(theta_rad - stay.may_touch_rad)) > self._in_doubt_rad:
                stay.theta_h0_rad = wrap_angle(theta_rad)

    @property
    def _searching(self) -> _Stay | None:
        """The visit whose exit is still searched for, as far as contacts are known."""
        if self._ended:
            return self._ended[0][0]
        return self._stay if self._stay is not None and not self._stay.found else None

    def hop(self, before_rad: float, end_rad: float, corridor: ExitCorridor) -> None:
        """Take an excursion that began and ended at the wall, and stayed near it: `exits_passed`.

        Only such an excursion is a hop in the sense of d_nc and of the boundary walk: a head that
        comes from the wall on one side of the exit and goes back to the wall on the other side,
        without having entered, has skipped the exit. A head that crosses θ = 0 and turns back
        before it touches the wall has not.
        """
        passed = exits_passed(before_rad, end_rad, corridor.half_arc_rad)
        self.wide_skips += exits_passed(before_rad, end_rad, corridor.effective_half_arc_rad)
        self.skips += passed
        stay = self._searching
        if stay is not None:
            stay.skips += passed

    def lose(self) -> None:
        """Say that frames are missing: what the head did meanwhile is not known."""
        self._left = False

    def pass_through(self) -> None:
        """Say that head and body are in the passage: the next chamber's entry will be seen."""
        self._left = True

    def find_exit(self, stamp_ns: int) -> None:
        """Say that the head has entered the exit: the visit ends if it is the first time."""
        stay = self._stay
        if stay is not None and not stay.found:
            stay.found = True
            self._ended.append((stay, stamp_ns, stay.start_seen))

    def leave(self) -> None:
        """Say that the body has followed the head out."""
        self._stay = None
        self._left = True

    def finish(self) -> None:
        """End an open visit where its last frame was."""
        stay, self._stay = self._stay, None
        if stay is not None and not stay.found:
            self._ended.append((stay, stay.last_ns, False))


def _visit(stay: _Stay, end_ns: int, *, complete: bool) -> Visit:
    tau_h_s = nan
    if stay.found and stay.first_contact_ns is not None:
        tau_h_s = (end_ns - stay.first_contact_ns) / NS_PER_S
    return Visit(
        chamber=stay.chamber,
        start_ns=stay.start_ns,
        end_ns=end_ns,
        first_contact_ns=stay.first_contact_ns,
        theta_h0_rad=stay.theta_h0_rad,
        tau_h_s=tau_h_s,
        skips=stay.skips,
        complete=complete,
    )


def exits_passed(before_rad: float, end_rad: float, half_arc_rad: float) -> int:
    """Return how many times the way from one place at the wall to another goes over the exit.

    Parameters
    ----------
    before_rad, end_rad : float
        θ_h, unwrapped, where the head left the wall and where it came back to it.
    half_arc_rad : float
        Half of the exit's arc; NaN where there is no exit.

    Returns
    -------
    int
        How many times the whole arc lies between the two.
    """
    if half_arc_rad != half_arc_rad or before_rad != before_rad:
        return 0
    low, high = min(before_rad, end_rad), max(before_rad, end_rad)
    turn = 2 * pi
    return max(0, floor((high - half_arc_rad) / turn) - ceil((low + half_arc_rad) / turn) + 1)
