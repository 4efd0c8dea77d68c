"""What frames, pixels and noise hide in trials: how much, and by what means are off for it."""

from math import exp, nan, sqrt

from worm_analysis.statistics.unseen_episodes import merged_excursion_factor, unmerged_means
from worm_analysis.summary.sums import Sums
from worm_msgs_py.intervals import Interval


def corrections(sums: Sums, rule: str = "") -> tuple[float, float, float]:
    """Return what the means of d_c, d_nc and Δr_h are to be multiplied by; see `unmerged_means`."""
    return sums.once(f"corrections{rule}", lambda: _corrections(sums, rule))


def _corrections(sums: Sums, rule: str) -> tuple[float, float, float]:
    (n_c, excess_c), (n_nc, excess_nc) = (
        sums.total(f"{name}{rule}")[:2] for name in ("d_c", "d_nc")
    )
    step_m = head_step_m(sums, rule)
    more = 1.0 if rule else excursions_per_detected(sums)
    if not (n_c and n_nc and step_m > 0 and excess_c > 0 and excess_nc > 0):
        return 1.0, 1.0, 1.0
    told = (excess_c / n_c, excess_nc / n_nc)
    seen = (told[0] / more, told[1] / more)
    # A rule's are cut off on the left; the others are means of all, as frames tell them.
    of_all = 0.0 if rule else step_m / 2
    if min(seen) <= of_all:
        return 1.0, 1.0, 1.0
    true = unmerged_means(seen[0] - of_all, seen[1] - of_all, step_m)
    return true[0] / told[0], true[1] / told[1], 1 / merged_excursion_factor(true[0], step_m)


def hidden_part(sums: Sums) -> float:
    """Return how far the excursions that noise and pixels hide reach, in means of their depth.

    Nearly the part of the excursions that is hidden, where that is small; 0 before any is seen.
    """
    if not (sums.has("depth_limit") and sums.has("delta_r_h")):
        return 0.0
    deep, excess_m = sums.total("delta_r_h")[:2]
    trials, beyond_m = sums.total("depth_limit")
    return float(beyond_m / trials * deep / excess_m) if excess_m > 0 else 0.0


def excursions_per_detected(sums: Sums) -> float:
    """Return how many excursions there are for one that is expected, by those noise cannot make.

    Of the shallow ones noise hides some, and others that stay below the threshold are told for
    excursions. How many there are follows from the deep ones, by the law of depths. 1 where these
    are too few.
    """
    if not sums.has("delta_r_h"):
        return 1.0
    deep, excess_m, told = sums.total("delta_r_h")[:3]
    expected, _, complete, _ = sums.total("d_nc")
    if deep < sums.settings.minimum_n or not (excess_m > 0 and expected > 0):
        return 1.0
    above_threshold = deep * exp(hidden_part(sums))
    return float(above_threshold / told * complete / expected)


def head_step_m(sums: Sums, rule: str = "") -> float:
    """Return the head's mean net advance along the wall from frame to frame; 0 before any."""
    intervals, distance_m = sums.total(f"advance{rule}")
    return float(distance_m / intervals) if intervals else 0.0


def radius_noise_m(sums: Sums) -> tuple[Interval, float]:
    """Return the noise of the radius with its interval, and the distance that counts as contact.

    Of several trials those of the noisiest; NaN where no contact was seen.
    """
    return sums.once("radius noise", lambda: _radius_noise_m(sums))


def _radius_noise_m(sums: Sums) -> tuple[Interval, float]:
    trials = [trial["radius_noise"].sum(axis=0) for trial in sums.trials if "radius_noise" in trial]
    of_one = sums.settings.noise_error_of_one_contact
    seen = [(noise / n, threshold / n, of_one / sqrt(n)) for n, noise, threshold in trials if n > 0]
    noise_m, threshold_m, error = max(
        seen, key=lambda found: found[0] / found[1], default=(nan, nan, nan)
    )
    return (noise_m, noise_m * max(1 - error, 0.0), noise_m * (1 + error)), threshold_m


def noise_in_thresholds(sums: Sums) -> tuple[float, float]:
    """Return it, and how large it may be, in parts of that distance; 0 where nothing was seen."""
    (noise_m, _, most_m), threshold_m = radius_noise_m(sums)
    return (noise_m / threshold_m, most_m / threshold_m) if threshold_m > 0 else (0.0, 0.0)


def largest_radius_m(sums: Sums) -> float:
    """Return R, the largest one of several trials."""
    return max(float(t["chamber_radius"][0, 1]) for t in sums.trials if "chamber_radius" in t)


def pixel_m(sums: Sums) -> float:
    """Return the size of a pixel, the mean one of several trials."""
    trials, size_m = sums.total("pixel")
    return float(size_m / trials)
