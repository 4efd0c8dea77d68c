"""Which way round a part of a body is passed, by the marks of its skin.

A loop passed the other way round covers the same of the picture, and a body laid from its tail to
its head does, too. But each place of a skin with marks has its own shade: what is seen along the
way agrees with one of the two.
"""

from dataclasses import dataclass, field
from math import ceil, floor

import numpy as np

from worm_msgs_py.arrays import Floats, Mask
from worm_tracker.midline.body_shade import ShadedObject, at_parts, places_across, shade_along
from worm_tracker.midline.curve import median_of, unit_grid
from worm_tracker.midline.path import BodyPath
from worm_tracker.midline.self_cover import SelfCoverSettings, parts_over
from worm_tracker.midline.strand_exchange import DoubtfulLoop, loops_otherwise
from worm_tracker.midline.strand_meetings import StrandExchangeSettings


@dataclass(frozen=True, slots=True)
class WayByMarksSettings:
    """What a place tells, and how much all of them must."""

    least_sd_relative: float = 0.05
    """Scatter of a place at least, over the signal."""
    slip_widths: float = 0.5
    """How far along the body a mark may lie from where it is in an open picture: no part of a body
    stretches as the rest of it does."""
    least_correlation: float = 0.6
    """Of what is seen with what is known, on the way that agrees more, for either to be told: of
    240 bodies that wore another skin than is known 5 % came to more. A real worm's marks come to
    0.6 to 0.8 (pictures of another kind, the right way), and to 0.2 to 0.5 where it has rolled."""
    most_log_odds: float = 4.5
    """What one place tells at most."""
    alike_along_widths: float = 0.5
    alike_across: float = 3.5
    """How far from each other, along the body and in places across it, two places are that tell
    something of their own."""
    margin_widths: float = 0.15
    """How far beyond the edge of another part of the body a place still looks like both."""
    least_log_odds: float = 10.0
    """Log odds from which on marks tell the way. Of 713 loops of four films, passed as they lay,
    none came to less than 17, but for bodies that lay the wrong way round as a whole; of 7 passed
    the other way round none to more than -48."""
    cover: SelfCoverSettings = field(default_factory=SelfCoverSettings)


@dataclass(frozen=True, eq=False, slots=True)
class MarksOnPath:
    """What is seen along a body and across it, and what is known of each place.

    Attributes
    ----------
    seen, known : ndarray, shape (n, len(ACROSS))
        Signal at the nodes of the path, and that of one layer of the body there.
    variance : ndarray, same shape
        Of what is seen, about what is known.
    told : ndarray of bool, same shape
        Where no other part of the body lies on the place or beside it.
    per_place : float
        How many of these tell as much as one by itself.
    settings : WayByMarksSettings
    """

    seen: Floats
    known: Floats
    variance: Floats
    told: Mask
    per_place: float
    settings: WayByMarksSettings

    @classmethod
    def on(
        cls,
        shaded: ShadedObject,
        path: BodyPath,
        widths: Floats,
        width: float,
        settings: WayByMarksSettings,
    ) -> "MarksOnPath":
        """Return what is seen on a path.

        Parameters
        ----------
        shaded : ShadedObject
        path : BodyPath
            In the picture's coordinates.
        widths : ndarray, shape (n,)
            Of the body at the path's nodes, pixels.
        width : float
            The body's, pixels.
        settings : WayByMarksSettings
        """
        line, n = path.curve, len(path.curve)
        part = unit_grid(n)
        known = at_parts(shaded.shade.mean, part)
        slip = np.gradient(known, axis=0) * (settings.slip_widths * width / path.step)
        least = settings.least_sd_relative * median_of(shaded.shade.mean.ravel())
        at, margin = places_across(line, widths), settings.margin_widths * width
        over = parts_over(at, line, widths / 2, slice(0, n), path.step, margin, settings.cover)
        return cls(
            shade_along(shaded.signal, line, widths),
            known,
            at_parts(shaded.shade.variance, part) + least**2 + slip**2,
            over == 0,
            settings.alike_along_widths * width / path.step * settings.alike_across,
            settings,
        )

    def log_odds(
        self, first: float = 0.0, last: float = 1.0, within: tuple[float, float] | None = None
    ) -> float:
        """Return the log odds of a part being passed as the path has it, not the other way round.

        Parameters
        ----------
        first, last : float
            From where to where, parts of the path's length.
        within : tuple of float, or None
            The same of a part within it that is not asked.

        Notes
        -----
        A skin that bends or rolls looks otherwise than it did: places scatter as much as the way
        does that agrees more. Where not even that one agrees nothing is told: 0.
        """
        part = self._nodes(first, last)
        asked = self.told[part].copy()
        if within is not None:
            inner = self._nodes(*within)
            asked[inner.start - part.start : inner.stop - part.start] = False
        if not asked.any():
            return 0.0
        seen, known, variance = self.seen[part], self.known[part], self.variance[part]
        ways = [(known, variance), (known[::-1, ::-1], variance[::-1, ::-1])]
        off = [((seen - there) ** 2 / spread)[asked] for there, spread in ways]
        better = int(off[1].mean() < off[0].mean())
        if _correlated(seen[asked], ways[better][0][asked]) < self.settings.least_correlation:
            return 0.0
        most, scatter = self.settings.most_log_odds, max(1.0, float(off[better].mean()))
        each = np.clip((off[1] - off[0]) / (2 * scatter), -most, most)
        return float(each.sum()) / self.per_place

    def _nodes(self, first: float, last: float) -> slice:
        end = len(self.seen) - 1
        return slice(max(floor(first * end), 0), min(ceil(last * end), end) + 1)


def _correlated(one: Floats, other: Floats) -> float:
    """Return the correlation coefficient of two samples, 0 where either does not vary."""
    one, other = one - one.mean(), other - other.mean()
    size = float(np.sqrt((one**2).sum() * (other**2).sum()))
    return float((one * other).sum()) / size if size > 0 else 0.0


@dataclass(frozen=True, eq=False, slots=True)
class MarkedLoop:
    """A loop, and what marks say of it beside the loop that lies within it.

    Two strands that run beside each other meet more than once. Where they cross is told by what
    lies between these places alone: the loop beyond them is the same.

    Attributes
    ----------
    loop : DoubtfulLoop
    otherwise : BodyPath
        The body that passes it the other way round.
    log_odds : float
        Of being passed as it is.
    """

    loop: DoubtfulLoop
    otherwise: BodyPath
    log_odds: float


def marked_loops(
    marks: MarksOnPath,
    path: BodyPath,
    width: float,
    exchange: StrandExchangeSettings,
    least_breadth_widths: float,
) -> list[MarkedLoop]:
    """Return the loops of a path that are broader than that, and what marks say of each."""
    loops = loops_otherwise(path, width, exchange, least_breadth_widths)
    found = []
    for loop, otherwise in loops:
        inner = _largest_within(loop, [other for other, _ in loops])
        within = None if inner is None else (inner.first, inner.last)
        odds = marks.log_odds(loop.first, loop.last, within)
        found.append(MarkedLoop(loop, otherwise, odds))
    return found


def _largest_within(loop: DoubtfulLoop, others: list[DoubtfulLoop]) -> DoubtfulLoop | None:
    """Return the longest of some loops that lies within another one; None without one."""
    within = [
        other
        for other in others
        if other != loop and loop.first <= other.first and other.last <= loop.last
    ]
    return max(within, key=lambda other: other.last - other.first, default=None)
