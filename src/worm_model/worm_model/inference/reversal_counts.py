"""Counts how often the head turns around, from the sign of its motion in each slide and hop."""

from dataclasses import dataclass, field

from worm_msgs_py import Episode, EpisodeKind
from worm_msgs_py.intervals import Interval, fraction


@dataclass
class Reversals:
    """Reversals from one phase to the next, in an unbroken track.

    The rules of the walk tell themselves apart here: `per_cycle` turns after a hop alone,
    `per_phase` after slides and hops alike.

    Attributes
    ----------
    resolution_m : float
        A phase that is shorter has no direction: its sign is that of the noise.
    after_slide, after_hop : (int, int)
        Reversals, and changes of phase at which both directions are known.
    """

    resolution_m: float = 0.0
    after_slide: tuple[int, int] = (0, 0)
    after_hop: tuple[int, int] = (0, 0)
    _last: tuple[int, int] = field(default=(-1, 0), repr=False)
    """Stamp at which the last phase ended, and its direction."""

    def push(self, episode: Episode, turn_rad: float) -> None:
        """Take the next episode.

        Parameters
        ----------
        episode : Episode
            In the order in which they closed. One that was cut short breaks the track.
        turn_rad : float
            Δθ_h over it, counter-clockwise positive; NaN where it is not known.
        """
        end_ns, before = self._last
        self._last = (-1, 0)
        if not episode.complete:
            return
        seen = episode.distance_m > self.resolution_m
        direction = (turn_rad > 0.0) - (turn_rad < 0.0) if seen else 0
        self._last = (episode.end_ns, direction)
        if episode.start_ns != end_ns or not before or not direction:
            return
        turned = int(direction != before)
        if episode.kind is EpisodeKind.FREE:
            self.after_slide = (self.after_slide[0] + turned, self.after_slide[1] + 1)
        else:
            self.after_hop = (self.after_hop[0] + turned, self.after_hop[1] + 1)

    @property
    def changes(self) -> int:
        """Changes of phase at which both directions are known."""
        return self.after_slide[1] + self.after_hop[1]

    def per_phase(self) -> Interval:
        """Return the fraction of changes of phase that are reversals, with its 95 % interval."""
        return fraction(self.after_slide[0] + self.after_hop[0], self.changes)


class PhaseDirections:
    """Gives Δθ_h of each episode, whose record has no sign, from θ_h of the frames."""

    def __init__(self) -> None:
        self._theta_rad: dict[int, float] = {}
        self._anew = False

    def see(self, stamp_ns: int, theta_rad: float) -> None:
        """Take a frame with θ_h, unwrapped, before the episodes that it ends."""
        if self._anew:
            self._theta_rad.clear()
            self._anew = False
        self._theta_rad[stamp_ns] = theta_rad

    def turn_rad(self, episode: Episode) -> float:
        """Return Δθ_h over an episode; NaN where its frames were not seen.

        Frames before its end are forgotten: the next episode starts there.
        """
        start = self._theta_rad.get(episode.start_ns, float("nan"))
        end = self._theta_rad.get(episode.end_ns, float("nan"))
        self._theta_rad = {
            stamp_ns: theta for stamp_ns, theta in self._theta_rad.items()
            if stamp_ns >= episode.end_ns
        }  # fmt: skip
        return end - start

    def forget(self) -> None:
        """Say that the head has left the chamber: θ_h starts anew, once it is back.

        Its last episodes are told when it has left.
        """
        self._anew = True
