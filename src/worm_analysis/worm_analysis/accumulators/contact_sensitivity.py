"""What d_c and d_nc would be, had contact been told in another way: computed beside the trial."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from worm_analysis.accumulators.episode_sums import LengthSums
from worm_analysis.accumulators.frame_rows import Frames
from worm_analysis.accumulators.settings import SEARCH, SearchSettings
from worm_analysis.parameters import AnalysisParameters
from worm_msgs_py.arrays import Floats, Integers, Mask
from worm_msgs_py.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class ContactRule:
    """One way to tell contact, as in `AnalysisParameters`.

    Attributes
    ----------
    label : str
        What it changes, for names: ``contact_factor_0.15``.
    contact_factor, release_factor, min_episode_s : float
        See `AnalysisParameters`.
    """

    label: str
    contact_factor: float
    release_factor: float
    min_episode_s: float


def threshold_rules(
    parameters: AnalysisParameters, settings: SearchSettings = SEARCH
) -> tuple[ContactRule, ...]:
    """Return the paper's rule, one threshold on the radius as it is seen, and others like it.

    The others differ from the first in one respect each. The threshold is halved and raised to
    threefold; contact is let go at one and a half and at two thresholds; episodes shorter than
    0.1 s and 0.2 s are taken into those around them.
    """
    contact, release = parameters.contact_factor, parameters.release_factor
    shortest_s = parameters.min_episode_s
    rules = [
        ContactRule(
            f"contact_factor_{contact * part:.4g}", contact * part, release * part, shortest_s
        )
        for part in (1.0, *settings.other_thresholds)
    ]
    rules += [
        ContactRule(f"release_factor_{contact * part:.4g}", contact, contact * part, shortest_s)
        for part in settings.release_thresholds
    ]
    rules += [
        ContactRule(f"min_episode_s_{time_s:.4g}", contact, release, time_s)
        for time_s in settings.shortest_episodes_s
    ]
    own = (contact, release, shortest_s)
    others = [
        rule
        for rule in rules[1:]
        if (rule.contact_factor, rule.release_factor, rule.min_episode_s) != own
    ]
    return (rules[0], *others)


class Sensitivity:
    """Lengths of contacts and excursions under several rules at once.

    What is kept are sums: memory does not grow.

    Parameters
    ----------
    rules : tuple of ContactRule
        The rules.
    radius_m : float
        R.

    Attributes
    ----------
    rules : tuple of ContactRule
        The rules.
    lengths : tuple of LengthSums
        d_c and d_nc, one for each rule.
    """

    def __init__(self, rules: tuple[ContactRule, ...], radius_m: float):
        self.rules = rules
        self.lengths = tuple(LengthSums(radius_m) for _ in rules)
        self._tracks = tuple(
            _Episodes(rule, lengths) for rule, lengths in zip(rules, self.lengths, strict=True)
        )
        self._approach = -1
        self._in_exit: set[int] = set()

    def ended_in_exit(self, approach: int) -> None:
        """Say that a stretch at the wall, by its number, ended with the head in the exit."""
        self._in_exit.add(approach)

    def sums(self, limits_m: Sequence[float]) -> dict[str, Floats]:
        """Return the sums of d_c and d_nc above a limit of resolution for each rule."""
        found: dict[str, Floats] = {}
        for rule, lengths, limit in zip(self.rules, self.lengths, limits_m, strict=True):
            found[f"d_c_at_{rule.label}"] = lengths.d_c.row(limit)
            found[f"d_nc_at_{rule.label}"] = lengths.d_nc.row(limit)
            found |= lengths.steps(f"_at_{rule.label}")
        return found

    def add(self, frames: Frames) -> None:
        """Take frames with the head in a chamber; where contact cannot be told they go by."""
        told = np.isfinite(frames.depth_widths)
        if not told.any():
            return
        approach = frames.approach[told]
        stamps_ns, theta = frames.stamp_ns[told], frames.theta_h_rad[told]
        depth = frames.depth_widths[told]
        cuts = np.flatnonzero(np.diff(approach)) + 1
        for part in np.split(np.arange(len(approach)), cuts):
            if approach[part[0]] != self._approach:
                self.cut()
                self._approach = int(approach[part[0]])
            piece = slice(int(part[0]), int(part[-1]) + 1)
            for track in self._tracks:
                track.add(stamps_ns[piece], theta[piece], depth[piece])

    def cut(self) -> None:
        """End all episodes where their last frames were."""
        into_exit = self._approach in self._in_exit
        self._in_exit = {number for number in self._in_exit if number > self._approach}
        for track in self._tracks:
            track.cut(into_exit=into_exit)


class _Episodes:
    """Episodes under one rule, run by run instead of frame by frame."""

    def __init__(self, rule: ContactRule, lengths: LengthSums):
        self._on, self._off = rule.contact_factor, rule.release_factor
        self._min_ns = round(rule.min_episode_s * NS_PER_S)
        self._lengths = lengths
        self._frame = 0
        self._reset()

    def _reset(self) -> None:
        self._touching = False
        self._kind: bool | None = None
        self._start: tuple[int, float] = (0, nan)
        self._start_seen = False
        self._last: tuple[int, float] = (0, nan)
        self._candidate: tuple[int, int, float] | None = None

    def add(self, stamps_ns: Integers, theta_rad: Floats, depth: Floats) -> None:
        """Take frames that are not cut apart."""
        contact = self._contact(depth)
        starts = [0, *(np.flatnonzero(np.diff(contact)) + 1).tolist()]
        ends = [*starts[1:], len(contact)]
        for start, end in zip(starts, ends, strict=True):
            self._run(
                bool(contact[start]),
                (self._frame + start, int(stamps_ns[start]), float(theta_rad[start])),
                int(stamps_ns[end - 1]),
            )
        self._frame += len(contact)
        self._last = (self._frame - 1, float(theta_rad[-1]))

    def _contact(self, depth: Floats) -> Mask:
        """Tell contact with hysteresis: between the thresholds a frame is as the one before."""
        below = depth < self._on
        if self._off > self._on:
            says = below | (depth >= self._off)
            upto = np.maximum.accumulate(np.where(says, np.arange(len(depth)), -1))
            below = np.where(upto >= 0, below[upto], self._touching)
        self._touching = bool(below[-1])
        return below

    def _run(self, kind: bool, start: tuple[int, int, float], last_ns: int) -> None:
        """Take a run of frames of one kind, or what has come of it so far."""
        if self._kind is None:
            self._kind, self._start = kind, (start[0], start[2])
        elif kind is self._kind:
            self._candidate = None
        else:
            if self._candidate is None:
                self._candidate = start
            frame, start_ns, theta_rad = self._candidate
            if last_ns - start_ns >= self._min_ns:
                self._close((frame, theta_rad), complete=self._start_seen)
                self._kind, self._start, self._start_seen = kind, (frame, theta_rad), True
                self._candidate = None

    def cut(self, *, into_exit: bool) -> None:
        """End the episode where the last frame was; an excursion into the exit is complete."""
        if self._kind is not None:
            landed = into_exit and not self._kind and self._start_seen
            self._close(self._last, complete=landed)
        self._reset()

    def _close(self, end: tuple[int, float], *, complete: bool) -> None:
        self._lengths.push(
            end[1] - self._start[1],
            end[0] - self._start[0],
            in_contact=bool(self._kind),
            start_seen=self._start_seen,
            complete=complete,
        )
