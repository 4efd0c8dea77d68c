"""What every closed episode at the wall adds to: lengths of slides and hops, and reversals."""

from math import nan

import numpy as np

from worm_analysis.accumulators.bins import BLOCK_BINS, LENGTH_BIN_M, LENGTH_BINS
from worm_analysis.accumulators.cycle_directions import CycleDirections
from worm_analysis.accumulators.settings import SEARCH, SearchSettings
from worm_analysis.events.contacts import ClosedEpisode
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_msgs_py import Distribution, EpisodeKind
from worm_msgs_py.arrays import Floats
from worm_msgs_py.units import NS_PER_S


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
    settings : SearchSettings

    Attributes
    ----------
    lengths : LengthSums
        d_c and d_nc.
    delta_r_h : ExcessSums
        Δr_h in m, of the excursions whose largest depth was seen. One that was cut on its way out
        is left out: how deep it would have gone does not depend on when frames are lost.
    directions : CycleDirections
        Reversals from cycle to cycle.
    """

    def __init__(self, radius_m: float, settings: SearchSettings = SEARCH) -> None:
        self._radius_m = radius_m
        self._deepest_m = settings.deepest_along_wall_radii * radius_m
        self.lengths = LengthSums(radius_m)
        self.delta_r_h = ExcessSums(LENGTH_BIN_M, LENGTH_BINS)
        self._depths_by_time = ExcessBlocks(LENGTH_BIN_M, BLOCK_BINS)
        self._expected = BlockSums(8)
        self._plain = BlockSums(6)
        self._speed = BlockSums(3)
        self._phase_before = (-1, 0.0)
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
        self._expect(closed)
        self._add_speed(closed)
        if closed.start_seen and episode.complete:
            at = 0 if in_contact else 2
            self._plain.row(episode.start_ns)[at : at + 2] += (1.0, episode.distance_m)
        if closed.start_seen and not in_contact and (episode.complete or closed.past_peak):
            self.delta_r_h.push(episode.delta_r_m, complete=True)
            self._depths_by_time.push(episode.start_ns, episode.delta_r_m, complete=True)
            self._plain.row(episode.start_ns)[4:] += (1.0, episode.delta_r_m)
        self.directions.push(closed, gap_s)

    def _add_speed(self, closed: ClosedEpisode) -> None:
        """Add the time and the way of a phase near the wall: far from it R·θ̇_h is no speed.

        Where the head turns round, a way to and fro between two frames is lost, and so its time is
        taken off: a frame's on average between two episodes, half of one within an episode.
        """
        episode, (before_start, after_end) = closed.episode, closed.beyond_rad
        spent_s = (episode.end_ns - episode.start_ns) / NS_PER_S
        before_ns, before = self._phase_before
        first, last = (-1 if beyond > 0 else 1 for beyond in closed.beyond_rad)
        self._phase_before = (-1 if closed.cut else episode.end_ns, last * closed.turn_rad)
        if episode.delta_r_m > self._deepest_m:
            return
        turned = before_ns == episode.start_ns and first * before * closed.turn_rad < 0
        frames = turned + (before_start > 0) / 2 + (after_end > 0) / 2
        lost_s = spent_s * min(frames / max(closed.frames, 1), 1.0)
        way_m = episode.distance_m + 2 * self._radius_m * (before_start + after_end)
        self._speed.row(episode.start_ns)[:] += (spent_s - lost_s, way_m, lost_s)

    def _expect(self, closed: ClosedEpisode) -> None:
        """Add what the frames say of contacts, then of excursions, as `sums` returns it."""
        expected, episode = closed.expected, closed.episode
        in_contact = episode.kind is EpisodeKind.CONTACT
        if not in_contact and not closed.start_seen:
            return  # it may have come out of the exit: that is no excursion from the wall
        row = self._expected.row(episode.start_ns)
        row[0] += expected.ends_c
        row[1] += self._radius_m * expected.turn_c_rad
        row[4] += expected.ends_f
        row[5] += self._radius_m * expected.turn_f_rad
        at = 2 if in_contact else 6
        row[at : at + 2] += (closed.start_seen and episode.complete, episode.distance_m)

    def sums(self, limit_m: float, depth_limit_m: float) -> dict[str, Floats]:
        """Return the sums behind the means of the episodes and the tests of their laws.

        d_c and d_nc by blocks of time: the expected number of episodes that end, the expected way
        in all of them, the complete ones that are seen, and the length of all that are seen.

        Parameters
        ----------
        limit_m : float
            The test of the laws of d_c and d_nc takes episodes that are longer.
        depth_limit_m : float
            Δr_h is that of deeper excursions, by what they are deeper.
        """
        found = self.directions.sums()
        found["d_c"], found["d_nc"] = np.hsplit(self._expected.rows(), 2)
        depths = self._depths_by_time.rows(depth_limit_m)
        found["delta_r_h"] = self.delta_r_h.row(depth_limit_m) if depths is None else depths
        for name, lengths, limit in (
            ("d_c", self.lengths.d_c, limit_m),
            ("d_nc", self.lengths.d_nc, limit_m),
            ("delta_r_h", self.delta_r_h, depth_limit_m),
        ):
            found[f"{name}_excess"] = lengths.excess_histogram(limit)
        plain = np.hsplit(self._plain.rows(), 3)
        found |= dict(zip(("d_c_mean", "d_nc_mean", "delta_r_h_mean"), plain, strict=True))
        return found | self.lengths.steps() | {"v_b": self._speed.rows()}

    def distributions(self) -> list[Distribution]:
        """Return the complete episodes' d_c, d_nc and Δr_h in bins for people."""
        return [
            self.lengths.d_c.distribution("d_c", 2.5e-4, 2e-2),
            self.lengths.d_nc.distribution("d_nc", 2.5e-4, 2e-2),
            self.delta_r_h.distribution("delta_r_h", 2.5e-4, 1e-2),
        ]
