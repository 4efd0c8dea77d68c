"""Hides an end of a body that a frame tells off the way that it moves before and after.

An end that lies on the body is told where the picture is explained best, which for one picture may
be a width beside where it is in those about it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from worm_tracker.observation import Observation
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.waiting.lone_ends import tells_ends, with_ends_hidden
from worm_tracker.waiting.ways_between import WaysBetweenSettings, ways_between


@dataclass(frozen=True, slots=True)
class EndsOffWaySettings:
    """When an end that a frame tells is held to be elsewhere, by the frames about it."""

    most_widths: float = 0.7
    most_sds: float = 2.4
    """How far it may be told from the way that it moves, and how far in standard deviations of
    both. Of 31 ends in 88 films that are farther 11 were more than a width off, of 79,922 others
    that lie on the body 18. By how they moved one of the 31 was, so that neither tells them."""
    least_seen_sd_widths: float = 0.08
    """How unsure an end is that lies on the body: nearer to others nothing else shows it."""
    most_way_sd_widths: float = 0.27
    most_misfit_sds: float = 2.0
    """How unsure that way may be, and how far in standard deviations it may be from the frames that
    tell it: of 18 ends as far from one that was less sure, or farther from them, none was wrong."""
    ways: WaysBetweenSettings = field(default_factory=lambda: WaysBetweenSettings(most_gap_s=0.3))
    """Over longer gaps it is not known as surely; and a frame need not wait for longer, in which
    what comes after a gap in the film may say that its head is the tail."""


def may_be_off_their_way(seen: Observation, settings: EndsOffWaySettings) -> bool:
    """Tell whether a frame tells an end that lies on the body, so that others may know better."""
    return tells_ends(seen) and max(seen.seen_end_sd_px) >= (
        settings.least_seen_sd_widths * seen.width
    )


def without_ends_off_their_way(
    frames: Sequence[PendingFrame], at: int, settings: EndsOffWaySettings
) -> Observation:
    """Return what a frame says, with an end hidden that lies elsewhere by how it moves.

    Parameters
    ----------
    frames : sequence of PendingFrame
        In their order, and their midlines all head first or all tail first.
    at : int
        Which of them is asked for; see `may_be_off_their_way`.
    settings : EndsOffWaySettings
    """
    seen = frames[at].observation
    tips = [0, -1]
    wanted = np.zeros(len(seen.points), bool)
    wanted[tips] = True
    between = ways_between(frames, at, wanted, settings.ways)
    width, seen_sd_px, sd_px = seen.width, np.array(seen.seen_end_sd_px), between.sd_px[tips]
    away_px = np.hypot(*(seen.points - between.smooth)[tips].T)
    off = seen_sd_px >= settings.least_seen_sd_widths * width
    off &= sd_px < settings.most_way_sd_widths * width  # nor where it is NaN
    off &= between.misfit_sds[tips] < settings.most_misfit_sds
    off &= away_px > settings.most_widths * width
    off &= away_px > settings.most_sds * np.hypot(sd_px, seen_sd_px)
    return with_ends_hidden(seen, off.tolist()) if off.any() else seen
