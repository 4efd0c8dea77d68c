"""What episodes add up to: lengths, censored or not, and reversals."""

import pytest

from worm_analysis.accumulators.episode_sums import EpisodeSums
from worm_analysis.events.contacts import ClosedEpisode
from worm_msgs_py import Episode, EpisodeKind

NS = 10**9


def closed_episode(kind, turn_rad, *, complete=True, start_seen=True, cut=None):
    distance_m = 0.01 * abs(turn_rad)
    depth_m = 1e-3 if kind is EpisodeKind.FREE else float("nan")
    episode = Episode("chamber_a", kind, 0, NS, distance_m, depth_m, complete=complete)
    return ClosedEpisode(
        episode, turn_rad, 10, start_seen, cut=not complete if cut is None else cut
    )


def test_an_episode_without_its_start_is_left_out_and_one_without_its_end_is_censored():
    sums = EpisodeSums(0.01)
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.1))
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.2, complete=False, start_seen=False))
    sums.push(closed_episode(EpisodeKind.CONTACT, 0.3, complete=False))
    assert sums.lengths.d_c.above(0.0) == (1, pytest.approx(4e-3), 0.0)


def test_reversals_are_counted_between_neighbouring_cycles_only():
    contact, free = EpisodeKind.CONTACT, EpisodeKind.FREE
    sums = EpisodeSums(0.01)
    for direction in (1, 1, -1, -1, 1):
        sums.push(closed_episode(contact, 0.1 * direction))
        sums.push(closed_episode(free, 0.1 * direction))
    assert sums.directions.pairs.tolist() == [4, 2]
    sums.push(closed_episode(contact, 0.1, complete=False))  # a gap
    sums.push(closed_episode(free, -0.1, complete=False, start_seen=False))
    sums.push(closed_episode(contact, -0.1))
    sums.push(closed_episode(free, -0.1))
    assert sums.directions.pairs.tolist() == [4, 2]
    sums.push(closed_episode(contact, 0.1))
    sums.push(closed_episode(free, 0.1, cut=True))  # into the exit: complete, and the last one
    assert sums.directions.pairs.tolist() == [5, 3]
    sums.push(closed_episode(contact, -0.1))
    sums.push(closed_episode(free, -0.1))
    assert sums.directions.pairs.tolist() == [5, 3]


def test_across_a_gap_that_is_bridged_the_cycles_at_its_edges_count_too():
    contact, free = EpisodeKind.CONTACT, EpisodeKind.FREE
    sums = EpisodeSums(0.01)
    for direction in (1, 1):
        sums.push(closed_episode(contact, 0.1 * direction))
        sums.push(closed_episode(free, 0.1 * direction))
    sums.push(closed_episode(contact, 0.02, complete=False), 3.0)  # a fold of three seconds
    sums.push(closed_episode(free, -0.05, complete=False, start_seen=False, cut=False))
    sums.push(closed_episode(contact, -0.1))
    sums.push(closed_episode(free, -0.1))
    found = sums.directions
    assert found.pairs.tolist() == [3, 0]  # 1-2, 2-edge, edge-3
    assert found.gaps.tolist() == [1, 1, 3.0]


def test_what_lies_between_two_gaps_is_compared_with_both_sides():
    sums = EpisodeSums(0.01)
    for turn_rad in (0.1, -0.1, 0.2, 0.1):
        piece = closed_episode(EpisodeKind.CONTACT, turn_rad, complete=False, start_seen=False)
        sums.push(piece, 2.0)
    found = sums.directions
    assert (found.pairs[0], *found.gaps) == (0, 3, 2, 6.0)
    sums.push(closed_episode(EpisodeKind.FREE, 0.1, complete=False, start_seen=False))
    sums.push(closed_episode(EpisodeKind.FREE, -0.1, start_seen=False))
    assert (found.pairs[0], found.gaps[0]) == (0, 4)  # and the last gap is none that is bridged
