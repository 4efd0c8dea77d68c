"""Whether a first body may be one laid double: a part of it is darker, or broader, than the rest.

A worm that lies exactly on itself, or close beside itself, when a film begins looks like a shorter
one. What gives it away is a step: a darkness, or a width, that is even on either side of it and
clearly different. A skin varies, and a body tapers, but neither steps.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import SD_OF_MAD
from worm_tracker.midline.curve import median_of
from worm_tracker.midline.refine import RefinedMidline


@dataclass(frozen=True, slots=True)
class DoubledBodySettings:
    """Which step is that of a body laid double."""

    end_part: float = 0.12
    """Part of the length at either end that does not count: a body tapers there."""
    least_step_relative: float = 0.18
    """Difference over the lower value from which on it is a step."""
    most_scatter_relative: float = 0.06
    """Most that either side of the step may scatter about its own median."""
    most_level_step_relative: float = 1.05
    """Difference in darkness beyond which it is no overlap, which is less than twice as dark as
    one layer: an end is pale."""
    least_part: float = 0.08
    """Least part of the body on either side."""


def looks_doubled(body: RefinedMidline, settings: DoubledBodySettings) -> bool:
    """Tell whether a body's darkness or width falls into two even parts."""
    cut = round(settings.end_part * len(body.levels))
    inner = slice(cut, len(body.levels) - cut)
    most = settings.most_level_step_relative
    levels, widths = body.levels[inner], body.widths[inner]
    return _steps(levels, settings, most) or _steps(widths, settings)


def _steps(values: Floats, settings: DoubledBodySettings, most: float = inf) -> bool:
    """Tell whether values fall into two groups, each of its own level."""
    ordered = np.sort(values)
    n = len(ordered)
    least = max(2, round(settings.least_part * n))
    count = np.arange(1, n)
    total = np.cumsum(ordered)
    low, high = total[:-1] / count, (total[-1] - total[:-1]) / (n - count)
    between = count * (n - count) * (high - low) ** 2
    between[: least - 1] = 0.0
    between[n - least :] = 0.0
    k = int(between.argmax()) + 1
    below, above = median_of(ordered[:k]), median_of(ordered[k:])
    if not settings.least_step_relative <= above / max(below, 1e-9) - 1 <= most:
        return False
    scatter = (_relative_scatter(ordered[:k], below), _relative_scatter(ordered[k:], above))
    return max(scatter) < settings.most_scatter_relative


def _relative_scatter(values: Floats, about: float) -> float:
    """Return the robust relative scatter of values about their median."""
    return SD_OF_MAD * median_of(np.abs(values - about)) / max(about, 1e-9)
