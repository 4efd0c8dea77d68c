"""The order in which midlines come, to that of a chain of them: what widths and the way say."""

from dataclasses import dataclass, replace

from worm_tracker.head_tail.certainty import both_say
from worm_tracker.observation import Observation


@dataclass(frozen=True, slots=True)
class OrderByWidthsSettings:
    """How surely the widths of a body tell which of its ends is which."""

    reliability: float = 0.998
    turned_reliability: float = 0.98
    """At most where they tell another order than its way from the last body of which they told
    it."""
    contradicted_reliability: float = 0.75
    """How surely that way tells it where it is surer than they are: that body may lie otherwise."""
    most_contradicted: int = 10
    """Open midlines that contradict such a way, none that agrees between them, until neither is
    believed: either the way exchanged the ends, or the widths do not tell them. A folded one may be
    what is wrong."""
    given_up_reliability: float = 0.5
    """How surely the order has been kept then: motion and looks tell anew which end is the head."""


@dataclass(frozen=True, slots=True)
class KnownAgain:
    """A midline whose widths tell the order of its ends, as those of an earlier one did.

    Attributes
    ----------
    frames_between : int
        How many frames lie between the two.
    way_was_wrong : bool
        Whether the links between them say the contrary: one of them was the wrong way round.
    reliability : float
        Probability, 0.5 to 1, that the two are in the same order.
    """

    frames_between: int
    way_was_wrong: bool
    reliability: float


@dataclass(frozen=True, slots=True)
class ChainOrder:
    """How the order in which midlines come, that of the body model, is to the chain's.

    Attributes
    ----------
    is_reversed : bool
        Whether the last midline had to be turned round.
    model_reversed : bool or None
        Whether the body model would have to be, by the last midline whose widths told its order;
        None where none has.
    path_number : int
        Of the last one.
    frames_unexplained : int
        Since one explained its picture.
    frames_unknown : int
        Since the widths of one told its order.
    kept : float
        Probability that the order has been kept since then, by the links alone.
    loops_known, ends_seen : bool
        Whether the last midline's loops were known to be passed as they were, and both its ends
        seen.
    contradicted : int
        Of how many open midlines the widths told another order than a way that was surer, since
        one agreed.
    """

    is_reversed: bool = False
    model_reversed: bool | None = None
    path_number: int = 0
    frames_unexplained: int = 0
    frames_unknown: int = 0
    kept: float = 1.0
    loops_known: bool = True
    ends_seen: bool = False
    contradicted: int = 0

    def then(
        self, observation: Observation, is_reversed: bool, told: int, kept: float
    ) -> "ChainOrder":
        """Return the order after one midline more; `told` and `kept` as of `known_again`."""
        return ChainOrder(
            is_reversed,
            is_reversed != (told < 0) if told else self.model_reversed,
            observation.path_number,
            0 if observation.explains else self.frames_unexplained + 1,
            0 if told else self.frames_unknown + 1,
            1.0 if told else kept,
            observation.loops_known,
            not any(observation.occluded),
            0 if told else self.contradicted,
        )

    def then_contradicted(self, settings: OrderByWidthsSettings) -> "ChainOrder":
        """Return the order, its last midline an open one that contradicts the way.

        After too many neither is believed: from then on the order is the one that widths tell now.
        """
        if self.contradicted + 1 < settings.most_contradicted:
            return replace(self, contradicted=self.contradicted + 1)
        other = not self.model_reversed
        return replace(self, model_reversed=other, contradicted=0, kept=1.0, frames_unknown=0)

    def missed(self) -> "ChainOrder":
        """Return the order after a frame without a midline."""
        return replace(
            self,
            path_number=0,
            ends_seen=False,
            frames_unexplained=self.frames_unexplained + 1,
            frames_unknown=self.frames_unknown + 1,
        )

    def reversed(self, frames: int) -> "ChainOrder":
        """Return the order where the chain is turned round from so many frames ago on."""
        order = replace(self, is_reversed=not self.is_reversed)
        if self.model_reversed is None or self.frames_unknown > frames:
            return order
        return replace(order, model_reversed=not self.model_reversed)

    def contradicts(self, told: int, is_reversed: bool) -> bool:
        """Tell whether a midline's widths tell another order than the way to it.

        Parameters
        ----------
        told : int
            1 where its widths tell that it comes in the model's order, -1 in the other, or 0.
        is_reversed : bool
            Whether it has to be turned round by the way.
        """
        known = self.model_reversed
        return bool(told) and known is not None and (is_reversed != (told < 0)) != known

    def known_again(
        self, told: int, is_reversed: bool, kept: float, settings: OrderByWidthsSettings
    ) -> KnownAgain | None:
        """Return what the widths of a midline say, together with the way to it.

        Parameters
        ----------
        told, is_reversed
            As of `contradicts`.
        kept : float
            Probability that the way kept the order since widths told it last.
        settings : OrderByWidthsSettings
        """
        if not told or self.model_reversed is None:
            return None
        if self.contradicts(told, is_reversed):
            surely = min(both_say(settings.reliability, 1 - kept), settings.turned_reliability)
            return KnownAgain(self.frames_unknown, True, surely)
        return KnownAgain(self.frames_unknown, False, both_say(kept, settings.reliability))
