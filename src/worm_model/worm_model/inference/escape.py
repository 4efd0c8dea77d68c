"""From finding the exit to leaving through it: the head may withdraw and search again.

The paper's second stage (section "Effect of Body Undulations on Escape Rate"): only about 60 % of
the head's entries are followed by the body, so that escaping takes nearly twice as long as finding.
"""

from dataclasses import dataclass
from math import isfinite, nan

from worm_msgs_py import Attempt, Event, Visit
from worm_msgs_py.intervals import Interval, exponential_mean
from worm_msgs_py.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class Escape:
    """How long an escape takes.

    Attributes
    ----------
    mean_s : (float, float, float)
        From the first contact with the wall until the head enters the exit for good, and its 95 %
        interval, from that of the success rate.
    ratio : (float, float, float)
        The same in units of ⟨τ_h⟩.
    """

    mean_s: Interval
    ratio: Interval


def escape_time(finding_s: float, again_s: float, success: Interval, lost_s: float = nan) -> Escape:
    """Return the mean time of an escape.

    Each entry of the head succeeds with the same probability s, so (1 − s)/s of them fail before
    the one that does not:

        ⟨escape⟩ = ⟨τ_h⟩ + (1 − s)/s · (time lost in a failed entry + time to find the exit again).

    Parameters
    ----------
    finding_s : float
        ⟨τ_h⟩ from a uniform start.
    again_s : float
        The same from where a withdrawn head goes on: the exit's edge, sliding away from it. (It
        may leave by either edge; they are mirror images.)
    success : (float, float, float)
        s and its 95 % interval.
    lost_s : float
        Mean time from the head's entry to its withdrawal; NaN, where it was not measured, counts
        as 0.

    Returns
    -------
    Escape
        NaN where s is not known; an end of the interval is infinite where s may be 0.
    """
    again = again_s + (lost_s if isfinite(lost_s) else 0.0)

    def mean_s(s: float) -> float:
        if s != s:
            return nan
        return finding_s + (1.0 - s) / s * again if s > 0.0 else float("inf")

    value, low, high = mean_s(success[0]), mean_s(success[2]), mean_s(success[1])
    return Escape((value, low, high), (value / finding_s, low / finding_s, high / finding_s))


class EscapeTimes:
    """Measures escapes and lost time from the events of a trial.

    An escape lasts from the first contact of a visit to the entry of the head that the body
    follows. One that does not come to its end adds to the time under way, as the law is close to
    exponential.

    Attributes
    ----------
    escapes : int
        Escapes that were seen from the first contact to the end.
    failures : int
        Failed entries.
    """

    def __init__(self) -> None:
        self.escapes = self.failures = 0
        self._total_s = self._lost_s = 0.0
        self._since: tuple[str, int] | None = None

    def push(self, event: Event) -> None:
        """Take a visit or an attempt, in the order in which they closed; pass over the rest."""
        if isinstance(event, Visit):
            self._visit(event)
        elif isinstance(event, Attempt) and event.complete:
            self._attempt(event)

    def mean_s(self, now_ns: int) -> Interval:
        """Return the mean time of an escape and its 95 % interval, as of now."""
        under_way = (now_ns - self._since[1]) / NS_PER_S if self._since else 0.0
        return exponential_mean(self.escapes, self._total_s + max(under_way, 0.0))

    def end_trial(self, now_ns: int) -> None:
        """Say that the trial is over: what was under way stays so, and another trial may follow."""
        if self._since is not None:
            self._total_s += max(now_ns - self._since[1], 0) / NS_PER_S
        self._since = None

    @property
    def lost_s(self) -> float:
        """Mean time that a failed entry takes; NaN before the first one."""
        return self._lost_s / self.failures if self.failures else nan

    def _visit(self, visit: Visit) -> None:
        self._since = None
        if visit.first_contact_ns is None:
            return
        if isfinite(visit.tau_h_s):
            self._since = (visit.chamber, visit.first_contact_ns)
        else:
            self._total_s += (visit.end_ns - visit.first_contact_ns) / NS_PER_S

    def _attempt(self, attempt: Attempt) -> None:
        if not attempt.success:
            self.failures += 1
            self._lost_s += (attempt.end_ns - attempt.start_ns) / NS_PER_S
        elif self._since is not None and self._since[0] == attempt.chamber:
            self.escapes += 1
            self._total_s += (attempt.start_ns - self._since[1]) / NS_PER_S
            self._since = None
