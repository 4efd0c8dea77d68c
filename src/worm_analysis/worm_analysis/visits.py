"""Stays in a chamber: the first touch of the wall, the finding of the exit, and the skips."""

from dataclasses import dataclass
from math import floor, nan, pi

from worm_analysis.angular_motion import NS
from worm_analysis.observables import wrap_angle
from worm_msgs_py import Visit


@dataclass(slots=True)
class _Stay:
    """The current visit; `found` once the head has entered the exit for the first time."""

    chamber: str
    start_ns: int
    start_seen: bool
    last_ns: int
    first_contact_ns: int | None = None
    theta_h0_rad: float = nan
    skips: int = 0
    found: bool = False


class Visits:
    """Follows the body from chamber to chamber (paper, section on Figs 5 to 7).

    A visit starts when the head comes into a chamber with the body behind it, and is closed when
    the head first enters the exit. Where the head withdraws, the body has not left: skips are
    still counted for the trial, but there is no second τ_h, because the search would start at the
    exit.
    """

    def __init__(self) -> None:
        self._stay: _Stay | None = None
        self._left = False
        self._skips = SkipCounter()
        self.number = 0
        self.skips = 0

    @property
    def home(self) -> str:
        """The chamber that the body is in; empty while it is in the passage, or not known."""
        return self._stay.chamber if self._stay else ""

    def locate(self, chamber: str, stamp_ns: int) -> Visit | None:
        """Say which chamber the head is in; return the visit that this ends, if it does.

        A visit that ends so, without the exit having been seen found, is incomplete.
        """
        if self._stay and self._stay.chamber == chamber:
            self._stay.last_ns = stamp_ns
            return None
        ended = self.finish()
        self._stay = _Stay(chamber, stamp_ns, self._left, stamp_ns)
        self._left = False
        self.number += 1
        return ended

    def search(
        self, stamp_ns: int, theta_rad: float, contact: bool | None, half_arc_rad: float
    ) -> None:
        """Take a frame with the head in the chamber.

        Parameters
        ----------
        stamp_ns : int
            The frame's stamp.
        theta_rad : float
            θ_h, unwrapped.
        contact : bool or None
            Whether the head touches the wall.
        half_arc_rad : float
            Half of the exit's arc; NaN where there is no exit.
        """
        stay = self._stay
        assert stay is not None
        if contact and stay.first_contact_ns is None and not stay.found:
            stay.first_contact_ns = stamp_ns
            stay.theta_h0_rad = wrap_angle(theta_rad)
        if self._skips.push(theta_rad, contact, half_arc_rad):
            self.skips += 1
            stay.skips += 0 if stay.found else 1

    def lose(self) -> None:
        """Say that frames are missing: what the head did meanwhile is not known."""
        self._skips.reset()
        self._left = False

    def pass_through(self) -> None:
        """Say that head and body are in the passage: the next chamber's entry will be seen."""
        self._left = True

    def find_exit(self, stamp_ns: int) -> Visit | None:
        """Say that the head has entered the exit; return the visit if it is the first time."""
        self._skips.reset()
        stay = self._stay
        if stay is None or stay.found:
            return None
        stay.found = True
        return _visit(stay, stamp_ns, complete=stay.start_seen)

    def leave(self) -> None:
        """Say that the body has followed the head out."""
        self._stay = None
        self._left = True

    def finish(self) -> Visit | None:
        """End an open visit where its last frame was."""
        stay = self._stay
        self._stay = None
        self._skips.reset()
        if stay is None or stay.found:
            return None
        return _visit(stay, stay.last_ns, complete=False)


def _visit(stay: _Stay, end_ns: int, *, complete: bool) -> Visit:
    tau_h_s = nan
    if stay.found and stay.first_contact_ns is not None:
        tau_h_s = (end_ns - stay.first_contact_ns) / NS
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


class SkipCounter:
    """Sees the head pass the exit's arc from one side to the other without touching the wall."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget on which side the head is."""
        self._side: int | None = None
        self._touched_outside = False
        self._inside = 0
        self._touched_inside = False

    def push(self, theta_rad: float, contact: bool | None, half_arc_rad: float) -> bool:
        """Take a frame; return whether the head has now passed the exit out of contact.

        Between the frames before and after the arc, those inside it must all be out of contact;
        where there are none, one of the two must be.
        """
        if contact is None or half_arc_rad != half_arc_rad:
            self.reset()
            return False
        if abs(wrap_angle(theta_rad)) <= half_arc_rad:
            self._inside += 1
            self._touched_inside |= contact
            return False
        side = floor(theta_rad / (2 * pi))
        passed = self._side is not None and side != self._side
        in_touch = self._touched_outside and contact if self._inside == 0 else self._touched_inside
        self._side, self._touched_outside = side, contact
        self._inside, self._touched_inside = 0, False
        return passed and not in_touch
