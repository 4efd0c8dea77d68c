"""How certain it is which end is the head, as a probability and as log odds, from link to link."""

from math import exp, log

LEAST_CERTAINTY = 0.5
"""That of a head which may as well be the tail."""


def probability(log_odds: float) -> float:
    """Return the probability that the first end is the head."""
    return 1 / (1 + exp(-log_odds))


def certainty(log_odds: float) -> float:
    """Return the probability of the likelier way round, 0.5 to 1."""
    return 1 / (1 + exp(-abs(log_odds)))


def certainty_before_link(certainty_after: float, reliability: float) -> float:
    """Return the certainty before a link from that after it."""
    return certainty_after * reliability + (1 - certainty_after) * (1 - reliability)


def smoothed_before_link(after: float, before: float, reliability: float) -> float:
    """Return the probability before a link by all that is known.

    Parameters
    ----------
    after : float
        The probability after the link by all that is known, also of before it.
    before : float
        The probability before the link by what was known until then; `LEAST_CERTAINTY`: nothing.
    reliability : float
        Of the link, 0.5 to 1.

    Notes
    -----
    The backward step of the forward and backward recursions for a chain of two states, which
    `certainty_before_link` is where nothing was known before. Where what was known before and what
    came after contradict each other, it is the link that is likelier to be wrong.
    """
    expected = certainty_before_link(before, reliability)
    same, turned = after / expected, (1 - after) / (1 - expected)
    return before * (reliability * same + (1 - reliability) * turned)


def diluted(log_odds: float, reliability: float) -> float:
    """Return the log odds after a link that may be the wrong way round."""
    if reliability == 1.0:
        return log_odds
    p = certainty_before_link(probability(log_odds), reliability)
    return log(p / (1 - p))


def both_say(one: float, other: float) -> float:
    """Return the probability of what two say, of probabilities that do not hang together."""
    return one * other / (one * other + (1 - one) * (1 - other))
