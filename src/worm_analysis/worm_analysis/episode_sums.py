"""What every closed episode adds to: lengths of slides and hops, visits, attempts, reversals."""

from worm_analysis.contacts import ClosedEpisode
from worm_analysis.distributions import ExcessSums
from worm_msgs_py import Attempt, Distribution, EpisodeKind, StrokePhase, Visit

FINE_BIN_M = 1e-5
LONGEST_M = 0.06


class EpisodeSums:
    """Sufficient statistics of contacts and excursions.

    Attributes
    ----------
    d_c, d_nc, delta_r_h : ExcessSums
        Lengths. Episodes whose start was not seen are left out: their length is not known, and
        under an exponential law the others are not biased by that. Those whose end was not seen
        are censored.
    cycles, reversals : int
        Pairs of successive cycles (one contact and the excursion after it) in an unbroken track,
        and how many of them differ in direction.
    """

    def __init__(self) -> None:
        n_bins = round(LONGEST_M / FINE_BIN_M) + 1
        self.d_c = ExcessSums(FINE_BIN_M, n_bins)
        self.d_nc = ExcessSums(FINE_BIN_M, n_bins)
        self.delta_r_h = ExcessSums(FINE_BIN_M, n_bins)
        self.cycles = 0
        self.reversals = 0
        self._distance_m = 0.0
        self._intervals = 0
        self._slide_rad: float | None = None
        self._last_direction = 0

    @property
    def step_m(self) -> float:
        """The head's mean net advance along the wall between two frames; 0 before any episode."""
        return self._distance_m / self._intervals if self._intervals else 0.0

    def push(self, closed: ClosedEpisode) -> None:
        """Add an episode."""
        episode = closed.episode
        in_contact = episode.kind is EpisodeKind.CONTACT
        if closed.start_seen:
            lengths = self.d_c if in_contact else self.d_nc
            lengths.push(episode.distance_m, complete=episode.complete)
            if not in_contact:
                self.delta_r_h.push(episode.delta_r_m, complete=episode.complete)
        if episode.complete:
            self._distance_m += episode.distance_m
            self._intervals += closed.frames
            self._add_to_cycle(closed.turn_rad, in_contact=in_contact)
        else:
            self._slide_rad, self._last_direction = None, 0

    def _add_to_cycle(self, turn_rad: float, *, in_contact: bool) -> None:
        if in_contact:
            self._slide_rad = turn_rad
        elif self._slide_rad is not None:
            cycle_rad = self._slide_rad + turn_rad
            direction = (cycle_rad > 0) - (cycle_rad < 0)
            if self._last_direction and direction:
                self.cycles += 1
                self.reversals += direction != self._last_direction
            self._slide_rad, self._last_direction = None, direction

    def distributions(self) -> list[Distribution]:
        """Return the complete episodes' d_c, d_nc and Δr_h in bins for people."""
        return [
            self.d_c.distribution("d_c", 2.5e-4, 2e-2),
            self.d_nc.distribution("d_nc", 2.5e-4, 2e-2),
            self.delta_r_h.distribution("delta_r_h", 2.5e-4, 1e-2),
        ]


class PassageSums:
    """Sufficient statistics of visits and of attempts at the exit.

    Attributes
    ----------
    finds, search_s : int, float
        Times that the exit was found after a contact, and the time searched for it in all, visits
        that were cut short included.
    attempts, successes, failures : int
        Decided attempts.
    free_failures, told_failures : int
        Failures without contact with the passage's walls, of those in which it can be told.
    elongations, phases : int
        Failures whose withdrawal began during elongation, of those in which it can be told.
    depths : ExcessSums
        x_p of the failures.
    """

    def __init__(self) -> None:
        self.finds = 0
        self.search_s = 0.0
        self.attempts = self.successes = self.failures = 0
        self.free_failures = self.told_failures = 0
        self.elongations = self.phases = 0
        self.depths = ExcessSums(FINE_BIN_M, round(LONGEST_M / FINE_BIN_M) + 1)

    def push_visit(self, visit: Visit) -> None:
        """Add a visit that has closed."""
        if visit.first_contact_ns is None:
            return
        self.finds += visit.tau_h_s == visit.tau_h_s
        self.search_s += (visit.end_ns - visit.first_contact_ns) * 1e-9

    def push_attempt(self, attempt: Attempt) -> None:
        """Add an attempt; one that was not decided counts for nothing."""
        if not attempt.complete:
            return
        self.attempts += 1
        self.successes += attempt.success
        if attempt.success:
            return
        self.failures += 1
        self.depths.push(attempt.penetration_m, complete=True)
        if attempt.wall_contact is not None:
            self.told_failures += 1
            self.free_failures += not attempt.wall_contact
        if attempt.stroke_phase is not StrokePhase.UNKNOWN:
            self.phases += 1
            self.elongations += attempt.stroke_phase is StrokePhase.ELONGATION

    def distributions(self) -> list[Distribution]:
        """Return x_p of the failed attempts in bins for people."""
        return [self.depths.distribution("x_p", 2.5e-4, 3.5e-2)]
