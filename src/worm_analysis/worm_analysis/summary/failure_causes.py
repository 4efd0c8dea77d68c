"""Why attempts at the exit fail, as parts of the failures: by contact and by the stroke."""

import numpy as np

from worm_analysis.statistics.block_jackknife import jackknife_half_width
from worm_analysis.summary.direction_persistence import NotEnoughData
from worm_analysis.summary.estimates import Estimator, over, share, widened
from worm_analysis.summary.sums import Sums
from worm_analysis.wording import not_enough
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import Interval, fraction


def share_of_determined(name: str) -> Estimator:
    """Return the estimator of the part of the failures of which something can be told that have it.

    The interval allows for all others to have it, and for none.
    """

    def estimate(sums: Sums) -> Interval:
        value, low, high = share(name)(sums)
        told, having = (round(part) for part in sums.total(name))
        undetermined = _undetermined_failures(sums)
        every = told + undetermined
        least = fraction(having, every)[1]
        return value, min(low, least), max(high, fraction(having + undetermined, every)[2])

    return estimate


def _undetermined_failures(sums: Sums) -> int:
    """Return the number of failures of which it cannot be told whether they touch."""
    every = float(sums.total("failures_of_unknown_phase")[0])
    return round(every - float(sums.total("failures_without_contact")[0]))


def touching_share(name: str) -> Estimator:
    """Return the estimator of the part of the failures that touch and have one phase of the stroke.

    The phase of those without contact need not be known. So where it is not known of others, these
    would be too few beside them: it is taken to be as often this one as where it is known. The
    interval allows for those of which contact cannot be told to be all such, and none.
    """

    def value_of(rows: Floats) -> Floats:
        told, without, n, in_phase = rows.T
        touching = np.nan_to_num(over(told - without, told))
        return np.where(touching > 0, touching * over(in_phase, n - without), 0.0)

    def estimate(sums: Sums) -> Interval:
        both = [
            np.hstack([trial["failures_without_contact"], trial[name]])
            for trial in sums.trials
            if name in trial
        ]
        units = sums.units_of(both)
        told, without, n, _ = (round(part) for part in units.total())
        known, touching, undetermined = n - without, told - without, _undetermined_failures(sums)
        if known < min(sums.settings.minimum_n, touching):
            items = "failed attempts in contact with a known phase of the stroke"
            raise NotEnoughData(not_enough(known, items, sums.settings.minimum_n))
        value = float(value_of(units.total()[None])[0])
        effective_n = told * known // touching if touching else told
        _, low, high = fraction(round(value * effective_n), effective_n)
        value, low, high = widened((value, low, high), jackknife_half_width(units, value_of))
        part = undetermined / (told + undetermined) if undetermined else 0.0
        return value, low * (1 - part), min(high * (1 - part) + part, 1.0)

    return estimate
