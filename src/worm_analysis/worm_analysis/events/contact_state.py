"""Contact as a hidden state: told now by a filter, and for good by a smoother a little later."""

from dataclasses import dataclass, replace
from math import expm1, nan
from typing import NamedTuple

import numpy as np

from worm_analysis.statistics.depth_law import (
    BINS_PER_THRESHOLD,
    DEPTH_LAW,
    FIRST_BIN,
    LAST_BIN,
    DepthLaw,
    DepthLawSettings,
    fit_depth_law,
)
from worm_msgs_py.arrays import Floats, Mask
from worm_msgs_py.units import NS_PER_S

BINS = LAST_BIN - FIRST_BIN


@dataclass(frozen=True, slots=True)
class ContactStateSettings:
    """How contact is told.

    Attributes
    ----------
    look_ahead_s : float
        What comes later says nothing of a frame: an episode takes less than a second. Frames are
        held back for twice as long and settled many at once.
    first_fit_s : float
        A dozen contacts: enough for the law of their depths. Until then nothing is told for good.
    shortest_fit_s : float
        A track that ends sooner is told by the law that is begun with.
    clear_touch_deviations : float
        Within so many standard deviations of its mean a depth is one in contact.
    most_depth_sd : float
        Contact is told of a head whose depth is as sure as that, in thresholds: it was within one
        of where it was given in 99.6 % of such frames, and in 80 % of others (17 834 frames of 19
        films of folds with exact truth).
    fewest_pairs : int
        Pairs of neighbouring frames in contact that the noise's correlation needs; 0 with fewer.
    depth_law : DepthLawSettings
        What the laws of depths may be.
    """

    look_ahead_s: float = 1.5
    first_fit_s: float = 15.0
    shortest_fit_s: float = 3.0
    clear_touch_deviations: float = 2.5
    most_depth_sd: float = 0.5
    fewest_pairs: int = 100
    depth_law: DepthLawSettings = DEPTH_LAW


CONTACT_STATE = ContactStateSettings()


def tells_contact(
    depth_sd_m: float, threshold_m: float, settings: ContactStateSettings = CONTACT_STATE
) -> bool:
    """Say whether contact can be told of a head that is placed so surely, wherever it is.

    One that is not may be clear of the wall, and never clearly at it: were it counted there,
    contacts would be missed more often than excursions, and the latter seem longer.

    Parameters
    ----------
    depth_sd_m : float
        How far R − r_h may be off; NaN counts as 0.
    threshold_m : float
        The distance that counts as contact; NaN where it is not known.
    settings : ContactStateSettings
    """
    return threshold_m > 0 and not depth_sd_m > settings.most_depth_sd * threshold_m


class ResolvedFrame(NamedTuple):
    """A frame of which it is settled whether the head touches the wall.

    Attributes
    ----------
    stamp_ns, theta_rad, depth_m, head_m
        As they were given.
    contact : bool
        Whether contact is more probable than not.
    in_mouth : bool
        Whether the head is before the exit, where there is no wall.
    share : float
        Probability of contact.
    leaves, touches : float
        Probability that a contact, or an excursion, ends between this frame and the next.
    """

    stamp_ns: int
    theta_rad: float
    depth_m: float
    head_m: tuple[float, float]
    contact: bool
    in_mouth: bool
    share: float
    leaves: float
    touches: float


@dataclass(slots=True)
class _Rates:
    """Chances of an end, 1/s: a count and a time each; one end in a second to begin with."""

    ends_c: float = 1.0
    time_c_s: float = 1.0
    ends_f: float = 1.0
    time_f_s: float = 1.0

    def ends_within(self, dt_s: float) -> tuple[float, float]:
        """Return the chances that a contact, and an excursion, ends within a time."""
        return (
            -expm1(-dt_s * self.ends_c / self.time_c_s),
            -expm1(-dt_s * self.ends_f / self.time_f_s),
        )


class _Waiting:
    """The frames that are held back, a list a column."""

    def __init__(self) -> None:
        self.stamp_ns: list[int] = []
        self.theta_rad: list[float] = []
        self.depth_m: list[float] = []
        self.head_m: list[tuple[float, float]] = []
        self.in_mouth: list[bool] = []
        self.depth: list[float] = []
        self.odds: list[float] = []
        self.touching: list[float] = []

    def drop(self, n: int) -> None:
        """Forget the first frames."""
        for column in vars(self).values():
            del column[:n]


class HiddenContact:
    """Tells contact from R − r_h under noise that it measures itself.

    Two states, contact and excursion, alternate at constant chances per time; each has its law of
    depths (`DepthLaw`). The forward recursion is the filter, which says what is most probable now;
    the backward recursion over the frames held back is the smoother. Laws and chances are fitted
    to all that was seen, after 15 s and after each doubling of the time: what comes out depends on
    the frames and their stamps alone. Before the exit there is no wall, and no contact.
    """

    def __init__(self, settings: ContactStateSettings = CONTACT_STATE) -> None:
        self._settings = settings
        self._look_ahead_ns = round(settings.look_ahead_s * NS_PER_S)
        self.law = DepthLaw()
        self.threshold_m = nan
        self._odds = _odds_of(self.law)
        self._counts = [0] * (BINS + 1)
        self._beyond = 0.0
        self._seen_s, self._next_fit_s = 0.0, settings.first_fit_s
        self._rates = _Rates()
        self._pairs = np.zeros(3)
        self._waiting = _Waiting()
        self._before: tuple[int, float] | None = None

    @property
    def is_fitted(self) -> bool:
        """Whether enough was seen for the law to be the trial's own."""
        return self._seen_s >= self._settings.shortest_fit_s

    def push(
        self,
        stamp_ns: int,
        theta_rad: float,
        depth_m: float,
        head_m: tuple[float, float],
        threshold_m: float,
        *,
        in_mouth: bool,
    ) -> tuple[bool | None, list[ResolvedFrame]]:
        """Take a frame.

        Parameters
        ----------
        stamp_ns : int
            Later than that of the last frame.
        theta_rad, depth_m : float
            θ_h, unwrapped, and R − r_h.
        head_m : (float, float)
            x, y of the head.
        threshold_m : float
            The distance that counts as contact, 0.3·d_w.
        in_mouth : bool
            Whether the head is before the exit.

        Returns
        -------
        contact : bool or None
            What is most probable now; None where depth or threshold is NaN.
        resolved : list of ResolvedFrame
            The frames that are settled by this one, in order.
        """
        if not (threshold_m > 0 and depth_m == depth_m):
            return None, []
        self.threshold_m = threshold_m
        self._hold(stamp_ns, theta_rad, depth_m, head_m, in_mouth=in_mouth)
        if self._seen_s >= self._next_fit_s:
            self._next_fit_s *= 2
            self._fit()
        held = self._waiting
        resolved: list[ResolvedFrame] = []
        held_ns = stamp_ns - held.stamp_ns[0]
        if self._next_fit_s > self._settings.first_fit_s and held_ns >= 2 * self._look_ahead_ns:
            resolved = self._resolve(stamp_ns - self._look_ahead_ns)
        return held.touching[-1] > 0.5, resolved

    def _hold(
        self,
        stamp_ns: int,
        theta_rad: float,
        depth_m: float,
        head_m: tuple[float, float],
        *,
        in_mouth: bool,
    ) -> None:
        """Count a frame's depth, let the frame wait, and filter it."""
        depth = depth_m / self.threshold_m
        bin_ = min(max(int(depth * BINS_PER_THRESHOLD - FIRST_BIN), 0), BINS)
        if not in_mouth:
            self._counts[bin_] += 1
            if bin_ == BINS:
                self._beyond += depth
        held = self._waiting
        if held.stamp_ns:
            self._seen_s += (stamp_ns - held.stamp_ns[-1]) / NS_PER_S
        elif self._before is not None:
            self._seen_s += (stamp_ns - self._before[0]) / NS_PER_S
        held.stamp_ns.append(stamp_ns)
        held.theta_rad.append(theta_rad)
        held.depth_m.append(depth_m)
        held.head_m.append(head_m)
        held.in_mouth.append(in_mouth)
        held.depth.append(depth)
        held.odds.append(0.0 if in_mouth else self._odds[bin_])
        self._filter(len(held.stamp_ns) - 1)

    def cut(self) -> list[ResolvedFrame]:
        """Settle all frames: what follows is not connected."""
        if not self._waiting.stamp_ns:
            self._before = None
            return []
        if self._next_fit_s == self._settings.first_fit_s and self.is_fitted:
            self._fit()
        resolved = self._resolve(self._waiting.stamp_ns[-1])
        self._before = None
        return resolved

    def _filter(self, at: int) -> None:
        """Find the probability of contact in a frame that waits, from all up to it."""
        held = self._waiting
        if at:
            last_ns, chance = held.stamp_ns[at - 1], held.touching[at - 1]
        elif self._before is not None:
            last_ns, chance = self._before
        else:
            last_ns, chance = held.stamp_ns[at], self.law.share
        leave, touch = self._rates.ends_within((held.stamp_ns[at] - last_ns) / NS_PER_S)
        chance += (1 - chance) * touch - chance * leave
        weighted = chance * held.odds[at]
        del held.touching[at:]
        held.touching.append(weighted / (weighted + 1 - chance))

    def _fit(self) -> None:
        """Fit the law and the chances to all that was seen, and filter anew what waits."""
        held, settings = self._waiting, self._settings
        counts = np.array(self._counts, dtype=np.float64)
        beyond = (counts[BINS], self._beyond)
        law = fit_depth_law(counts[:BINS], beyond, self.law.kept, settings.depth_law)
        depth, mouth = np.array(held.depth), np.array(held.in_mouth)
        off = np.abs(depth - law.touch)
        touching = (off < settings.clear_touch_deviations * law.noise) & ~mouth
        pairs = self._pairs + _pairs(depth - law.touch, touching)
        kept = pairs[1] / pairs[2] if pairs[0] >= settings.fewest_pairs and pairs[2] > 0 else 0.0
        self.law = replace(law, kept=min(max(float(kept), 0.0), settings.depth_law.most_kept))
        self._odds = _odds_of(self.law)
        bins = np.clip((depth * BINS_PER_THRESHOLD - FIRST_BIN).astype(int), 0, BINS)
        held.odds = [0.0 if m else self._odds[b] for m, b in zip(mouth, bins, strict=True)]
        held.touching = []
        for at in range(len(depth)):
            self._filter(at)

    def _resolve(self, upto_ns: int) -> list[ResolvedFrame]:
        """Smooth what waits, and let go of the frames up to a time."""
        held = self._waiting
        stamps, alpha, odds = held.stamp_ns, held.touching, held.odds
        found: list[ResolvedFrame] = []
        ratio, leaves, touches = 1.0, 0.0, 0.0  # of the chances of all that follows
        for at in range(len(stamps) - 1, -1, -1):
            chance = alpha[at]
            if at + 1 < len(stamps):
                leave, touch = self._rates.ends_within((stamps[at + 1] - stamps[at]) / NS_PER_S)
                ahead = odds[at + 1] * ratio
                in_c, in_f = (1 - leave) * ahead + leave, touch * ahead + 1 - touch
                every = chance * in_c + (1 - chance) * in_f
                leaves = 0.0 if held.in_mouth[at + 1] else chance * leave / every
                touches = (1 - chance) * touch * ahead / every
                ratio = in_c / in_f
            if stamps[at] <= upto_ns:
                share = chance * ratio / (chance * ratio + 1 - chance)
                found.append(
                    ResolvedFrame(
                        stamps[at], held.theta_rad[at], held.depth_m[at], held.head_m[at],
                        share > 0.5, held.in_mouth[at], share, leaves, touches,
                    )
                )  # fmt: skip
        found.reverse()
        self._learn(found)
        return found

    def _learn(self, found: list[ResolvedFrame]) -> None:
        """Add what was settled to the counts that the next fit rests on."""
        n = len(found)
        stamps, alpha = self._waiting.stamp_ns[: n + 1], self._waiting.touching
        rates = self._rates
        for frame, now_ns, next_ns in zip(found, stamps, stamps[1:], strict=False):
            dt_s = (next_ns - now_ns) / NS_PER_S
            rates.ends_c += frame.leaves
            rates.ends_f += frame.touches
            rates.time_c_s += frame.share * dt_s
            rates.time_f_s += (1 - frame.share) * dt_s
        residual = np.array(self._waiting.depth[:n]) - self.law.touch
        touching = np.array([frame.contact for frame in found])
        touching &= np.abs(residual) < self._settings.clear_touch_deviations * self.law.noise
        self._pairs += _pairs(residual, touching)
        self._before = (stamps[n - 1], alpha[n - 1])
        self._waiting.drop(n)


def _odds_of(law: DepthLaw) -> list[float]:
    """Return the odds of contact by bins of depth; the last one is for all beyond."""
    depth = (np.arange(FIRST_BIN, LAST_BIN + 1) + 0.5) / BINS_PER_THRESHOLD
    odds: list[float] = np.exp(np.clip(law.log_odds(depth), -60.0, 60.0)).tolist()
    return odds


def _pairs(residual: Floats, touching: Mask) -> Floats:
    """Return the number of pairs of neighbours in contact, and the sums behind the correlation."""
    both = touching[1:] & touching[:-1]
    a, b = residual[:-1][both], residual[1:][both]
    return np.array([len(a), float(a @ b), float(a @ a + b @ b) / 2])
