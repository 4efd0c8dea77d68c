"""Undoes what is hidden of episodes and cycles by looking only once a frame."""

from math import expm1, log, log1p


def unmerged_means(mean_c: float, mean_nc: float, step: float) -> tuple[float, float]:
    """Undo what sampling in frames does to the means of alternating exponential episodes.

    Between two frames a short episode can begin and end unseen; its neighbours are then taken for
    one. For a head that advances by `step` a frame, contact and no contact are a two-state Markov
    chain whose sampled runs are geometric, and the continuous rates follow from the sampled ones.

    Parameters
    ----------
    mean_c, mean_nc : float
        Means of the sampled episodes, after the cut-off.
    step : float
        The head's net advance a frame, same unit.

    Returns
    -------
    (float, float)
        Means of the true episodes; the inputs where they are too near to `step` to tell.
    """
    leave_c, leave_nc = step / (mean_c + step / 2), step / (mean_nc + step / 2)
    both = leave_c + leave_nc
    if not 0 < both < 0.9:
        return mean_c, mean_nc
    rate = -log(1 - both) / step
    return both / (rate * leave_c), both / (rate * leave_nc)


def merged_excursion_factor(mean_c: float, step: float) -> float:
    """Return by how much unseen contacts enlarge the mean of an excursion's largest depth.

    Two excursions whose contact in between falls between two frames are taken for one, which has
    the larger depth of the two. With the probability q of such a contact, exponential depths have
    the mean −ln(1 − q)/q of what they would have.

    Parameters
    ----------
    mean_c : float
        Mean length of a contact.
    step : float
        The head's net advance a frame, same unit.
    """
    unseen = 1 + expm1(-step / mean_c) * mean_c / step if step > 0 else 0.0
    return -log1p(-unseen) / unseen if unseen > 1e-12 else 1.0


def per_true_cycle(observed: float, cycles: float) -> float:
    """Return the chance of a reversal per cycle from that over several cycles taken for one.

    Parameters
    ----------
    observed : float
        Fraction of observed cycles that go the other way than the one before.
    cycles : float
        True cycles in an observed one: a slide or a hop between two frames is not seen, and the
        cycles around it are taken for one. An even number of reversals in it goes unseen. Less
        than 1 where noise makes one cycle two.
    """
    kept = max(0.0, 1 - 2 * observed)
    return float((1 - kept ** (1 / cycles)) / 2) if kept > 0 else observed
