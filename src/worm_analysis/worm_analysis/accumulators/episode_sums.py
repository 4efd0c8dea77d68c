"""What every closed episode at the wall adds to: lengths of slides and hops, and reversals."""

from math import nan

import numpy as np

from worm_analysis.accumulators.bins import BLOCK_BINS, LENGTH_BIN_M, LENGTH_BINS
from worm_analysis.accumulators.cycle_directions import CycleDirections
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
    directions : CycleDirections
        Reversals from cycle to cycle.
    """

    def __init__(self, radius_m: float) -> None:
        self.lengths = LengthSums(radius_m)
        self.delta_r_h = ExcessSums(LENGTH_BIN_M, LENGTH_BINS)
        self.by_time = {
            name: ExcessBlocks(LENGTH_BIN_M, BLOCK_BINS) for name in ("d_c", "d_nc", "delta_r_h")
        }
        self.directions = CycleDirections()

    def push(self, closed: ClosedEpisode, gap_s: float = nan) -> None:
        """Add an episode; `gap_s` is the length of a gap that cuts it and is bridged."""
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
        self.directions.push(closed, gap_s)

    def sums(self, limit_m: float, depth_limit_m: float) -> dict[str, Floats]:
        """Return the sums of the episodes above two limits of resolution.

        Parameters
        ----------
        limit_m : float
            Of d_c and d_nc.
        depth_limit_m : float
            Of Δr_h.
        """
        found = self.directions.sums()
        for name, lengths, limit in (
            ("d_c", self.lengths.d_c, limit_m),
            ("d_nc", self.lengths.d_nc, limit_m),
            ("delta_r_h", self.delta_r_h, depth_limit_m),
        ):
            by_time = self.by_time[name].rows(limit)
            found[name] = lengths.row(limit) if by_time is None else by_time
            found[f"{name}_excess"] = lengths.excess_histogram(limit)
        return found | self.lengths.steps()

    def distributions(self) -> list[Distribution]:
        """Return the complete episodes' d_c, d_nc and Δr_h in bins for people."""
        return [
            self.lengths.d_c.distribution("d_c", 2.5e-4, 2e-2),
            self.lengths.d_nc.distribution("d_nc", 2.5e-4, 2e-2),
            self.delta_r_h.distribution("delta_r_h", 2.5e-4, 1e-2),
        ]
