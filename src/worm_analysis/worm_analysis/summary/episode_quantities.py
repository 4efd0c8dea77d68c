"""d_c, d_nc, Δr_h and τ_h: exponential means, how well the law fits, and what contact rests on."""

from collections.abc import Iterator
from functools import partial
from math import exp, isfinite

from worm_analysis.accumulators.episode_sums import LengthSums
from worm_analysis.statistics.censored_exponential import ExcessBlocks, ExcessSums
from worm_analysis.statistics.estimators import (
    Estimate,
    exponential_mean,
    merged_excursion_factor,
    unmerged_means,
)
from worm_analysis.statistics.goodness_of_fit import exponential_p, grouped
from worm_analysis.summary.quantity_table import Evidence, none, tell
from worm_msgs_py import Quantity

CONTACTS = "complete contacts above the resolution limit"
EXCURSIONS = "complete excursions above the resolution limit"
FINDINGS = "findings of the exit after a contact"
FEWEST_FOR_P = 20
"""Fewer items cannot tell one law from another."""
STEPS_A_GROUP = 3
"""Lengths come in the head's steps from frame to frame; the test of the law looks coarser."""


def episode_quantities(evidence: Evidence) -> Iterator[Quantity]:
    """Yield the exponential means of Fig. 3, with what frames and pixels hide allowed for.

    Episodes shorter than one and a half of the head's advance a frame (or of a pixel) are cut off,
    and episodes that were taken for one because a short one between them was not seen are corrected
    for; an excursion is deeper than the threshold of contact by definition. Intervals are the
    wider ones of the exponential law's own and of the jackknife over blocks of time.
    """
    episodes, parameters = evidence.search.episodes, evidence.parameters
    lengths, blocks = episodes.lengths, episodes.by_time
    limit_m = resolution_limit(lengths, evidence.pixel_m)
    scale_c, scale_nc, scale_r = corrections(lengths, limit_m)
    width_m = parameters.body_width_m or evidence.body.median_width()
    threshold_m = parameters.contact_factor * width_m if isfinite(width_m) else 0.0
    rows = (
        ("d_c", lengths.d_c, limit_m, scale_c, CONTACTS),
        ("d_nc", lengths.d_nc, limit_m, scale_nc, EXCURSIONS),
        ("delta_r_h", episodes.delta_r_h, max(evidence.pixel_m, threshold_m), scale_r, EXCURSIONS),
    )
    for name, sums, limit, scale, items in rows:
        yield tell(
            evidence,
            name,
            "mm",
            sums.above(limit)[0],
            partial(mean_above, sums, blocks[name], limit),
            scale=1e3 * scale,
            items=items,
        )
    for name, sums, limit, _, items in rows:
        coarse_m = STEPS_A_GROUP * lengths.step_m if name != "delta_r_h" else evidence.pixel_m
        yield law(evidence, name, sums, limit, coarse_m, items)


def search_time(evidence: Evidence) -> Iterator[Quantity]:
    """Yield ⟨τ_h⟩ (Figs 5, 6a) and how well an exponential law describes it."""
    sums = evidence.passages.tau_h
    if not evidence.exit_width_m > 0:
        yield none("tau_h", "s", "no exit in view")
        yield none("tau_h_exponential_p", "1", "no exit in view")
        return
    yield tell(
        evidence,
        "tau_h",
        "s",
        sums.above(0.0)[0],
        partial(mean_above, sums, evidence.passages.tau_by_time, 0.0),
        items=FINDINGS,
    )
    yield law(evidence, "tau_h", sums, 0.0, sums.bin_width, FINDINGS)


def sensitivities(evidence: Evidence) -> Iterator[Quantity]:
    """Yield d_c and d_nc under every other rule of contact, named after what it changes."""
    sensitivity = evidence.search.sensitivity
    for rule, lengths in zip(sensitivity.rules, sensitivity.lengths, strict=True):
        limit_m = resolution_limit(lengths, evidence.pixel_m)
        scales = corrections(lengths, limit_m)
        for name, sums, scale, items in (
            ("d_c", lengths.d_c, scales[0], CONTACTS),
            ("d_nc", lengths.d_nc, scales[1], EXCURSIONS),
        ):
            n, excess_m, _ = sums.above(limit_m)
            yield tell(
                evidence,
                f"{name}_at_{rule.label}",
                "mm",
                n,
                partial(exponential_mean, n, excess_m),
                scale=1e3 * scale,
                items=items,
            )


def resolution_limit(lengths: LengthSums, pixel_m: float) -> float:
    """Return the length below which episodes are not all seen, m."""
    return 1.5 * max(lengths.step_m, pixel_m)


def corrections(lengths: LengthSums, limit_m: float) -> tuple[float, float, float]:
    """Return what the means of d_c, d_nc and Δr_h are to be multiplied by; see `unmerged_means`."""
    n_c, excess_c, _ = lengths.d_c.above(limit_m)
    n_nc, excess_nc, _ = lengths.d_nc.above(limit_m)
    if not (n_c and n_nc and lengths.step_m > 0 and excess_c > 0 and excess_nc > 0):
        return 1.0, 1.0, 1.0
    seen = (excess_c / n_c, excess_nc / n_nc)
    true = unmerged_means(*seen, lengths.step_m)
    merged = merged_excursion_factor(true[0], lengths.step_m)
    return true[0] / seen[0], true[1] / seen[1], 1 / merged


def cycles_in_one(lengths: LengthSums, pixel_m: float) -> float:
    """Return how many cycles of slide and hop an observed one holds: 1, where frames are dense."""
    limit_m = resolution_limit(lengths, pixel_m)
    scales = corrections(lengths, limit_m)
    observed_m = true_m = 0.0
    for sums, scale in zip((lengths.d_c, lengths.d_nc), scales, strict=False):
        n, whole_m, _ = sums.above(0.0)
        n_above, excess_m, _ = sums.above(limit_m)
        if not (n and n_above):
            return 1.0
        observed_m += whole_m / n
        true_m += scale * excess_m / n_above
    return max(1.0, observed_m / true_m) if true_m > 0 else 1.0


def mean_above(sums: ExcessSums, blocks: ExcessBlocks, limit: float) -> Estimate:
    """Return the mean excess above a limit and the wider one of its two intervals.

    The law's own interval is right where episodes are independent and exponential; the jackknife's,
    on a logarithmic scale, also where the worm changes in the course of a trial.
    """
    n, excess, _ = sums.above(limit)
    value, low, high = exponential_mean(n, excess)
    half = blocks.half_width(limit)
    if half is not None and value > 0:
        low = min(low, value * exp(-half / value))
        high = max(high, value * exp(half / value))
    return value, low, high


def law(
    evidence: Evidence, name: str, sums: ExcessSums, limit: float, coarse: float, items: str
) -> Quantity:
    """Return the p value of an exponential law; censored items, which are few, are left out.

    Where items are cut short at random, at a constant rate, the complete ones are exponential
    too, with a shorter mean: the test is of the law, whatever its mean.
    """
    counts, excess = sums.complete_above(limit)
    per_group = max(1, round(coarse / sums.bin_width))

    def p() -> tuple[float, None]:
        coarse_counts = grouped(counts, per_group)
        return exponential_p(coarse_counts, per_group * sums.bin_width, excess), None

    return tell(
        evidence,
        f"{name}_exponential_p",
        "1",
        int(counts.sum()),
        p,
        items=items,
        fewest=FEWEST_FOR_P,
    )
