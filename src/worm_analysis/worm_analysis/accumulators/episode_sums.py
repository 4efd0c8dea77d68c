"""What every closed episode at the wall adds to: lengths of slides and hops, and reversals."""

import numpy as np

from worm_analysis.accumulators.bins import BLOCK_BINS, LENGTH_BIN_M, LENGTH_BINS
from worm_analysis.events.contacts import ClosedEpisode
from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_msgs_py import Distribution, EpisodeKind
from worm_msgs_py.arrays import Floats


class LengthSums:
    """Lengths of contacts and excursions along the wall.

    Attributes
    ----------
    d_c, d_nc : ExcessSums
        Lengths in m. Episodes whose start was not seen are left out: their length is not known,
        and under an exponential law the others are not biased by that. Those whose end was not
        seen are censored.
    """

    def __init__(self, radius_m: float):
        self._radius_m = radius_m
        self.d_c = ExcessSums(LENGTH_BIN_M, LENGTH_BINS)
        self.d_nc = ExcessSums(LENGTH_BIN_M, LENGTH_BINS)
        self._distance_m = 0.0
        self._intervals = 0

    @property
    def step_m(self) -> float:
        """The head's mean net advance along the wall between two frames; 0 before any episode."""
        return self._distance_m / self._intervals if self._intervals else 0.0

    def steps(self, rule: str = "") -> dict[str, Floats]:
        """Return the intervals between frames and the head's net advance over them, m."""
        return {f"advance{rule}": np.array([[self._intervals, self._distance_m]])}

    def push(
        self,
        turn_rad: float,
        intervals: int,
        *,
        in_contact: bool,
        start_seen: bool,
        complete: bool,
    ) -> None:
        """Add an episode: |Δθ_h|, the intervals between frames that it spans, and how it ended."""
        distance_m = self._radius_m * abs(turn_rad)
        if start_seen:
            (self.d_c if in_contact else self.d_nc).push(distance_m, complete=complete)
        if complete:
            self._distance_m += distance_m
            self._intervals += intervals


class EpisodeSums:
    """Sufficient statistics of contacts and excursions.

    Parameters
    ----------
    radius_m : float
        R.

    Attributes
    ----------
    lengths : LengthSums
        d_c and d_nc.
    delta_r_h : ExcessSums
        Δr_h in m, complete or censored as the lengths.
    by_time : dict of str to ExcessBlocks
        The same three by blocks of time, for intervals that allow for a worm that changes.
    cycles, reversals : int
        Pairs of successive cycles (one contact and the excursion after it) in an unbroken track,
        and how many of them differ in direction.
    """

    def __init__(self, radius_m: float) -> None:
        self.lengths = LengthSums(radius_m)
        self.delta_r_h = ExcessSums(LENGTH_BIN_M, LENGTH_BINS)
        self.by_time = {
            name: ExcessBlocks(LENGTH_BIN_M, BLOCK_BINS) for name in ("d_c", "d_nc", "delta_r_h")
        }
        self.cycles = 0
        self.reversals = 0
        self._slide_rad: float | None = None
        self._last_direction = 0

    def push(self, closed: ClosedEpisode) -> None:
        """Add an episode."""
        episode = closed.episode
        in_contact = episode.kind is EpisodeKind.CONTACT
        self.lengths.push(
            closed.turn_rad,
            closed.frames,
            in_contact=in_contact,
            start_seen=closed.start_seen,
            complete=episode.complete,
        )
        if closed.start_seen:
            blocks = self.by_time["d_c" if in_contact else "d_nc"]
            blocks.push(episode.start_ns, episode.distance_m, complete=episode.complete)
            if not in_contact:
                self.delta_r_h.push(episode.delta_r_m, complete=episode.complete)
                self.by_time["delta_r_h"].push(
                    episode.start_ns, episode.delta_r_m, complete=episode.complete
                )
        if episode.complete:
            self._add_to_cycle(closed.turn_rad, in_contact=in_contact)
        if closed.cut:
            self._slide_rad, self._last_direction = None, 0

    def sums(self, limit_m: float, depth_limit_m: float) -> dict[str, Floats]:
        """Return the sums of the episodes above two limits of resolution.

        Parameters
        ----------
        limit_m : float
            Of d_c and d_nc.
        depth_limit_m : float
            Of Δr_h.
        """
        found = {"reversal_per_cycle": np.array([[self.cycles, self.reversals]], dtype=np.float64)}
        for name, lengths, limit in (
            ("d_c", self.lengths.d_c, limit_m),
            ("d_nc", self.lengths.d_nc, limit_m),
            ("delta_r_h", self.delta_r_h, depth_limit_m),
        ):
            by_time = self.by_time[name].rows(limit)
            found[name] = lengths.row(limit) if by_time is None else by_time
            found[f"{name}_excess"] = lengths.excess_histogram(limit)
        return found | self.lengths.steps()

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
            self.lengths.d_c.distribution("d_c", 2.5e-4, 2e-2),
            self.lengths.d_nc.distribution("d_nc", 2.5e-4, 2e-2),
            self.delta_r_h.distribution("delta_r_h", 2.5e-4, 1e-2),
        ]
