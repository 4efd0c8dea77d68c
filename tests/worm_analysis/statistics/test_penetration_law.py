"""F(x_p) is fitted by its likelihood."""

import numpy as np
import pytest

from worm_analysis.statistics.penetration_law import fit_penetration, penetration_p

NS = 10**9


def fitted(x, bin_mm=0.1):
    edges = np.arange(np.ceil(x.max() / bin_mm) + 1) * bin_mm
    return fit_penetration(edges, np.histogram(x, edges)[0])


def depths(rng, n, share, beta=0.5, span=10.0):
    x = rng.exponential(1 / beta, 4 * n)
    x = x[x < span][:n]
    even = rng.random(n) < share
    x[even] = rng.uniform(0, span, even.sum())
    return x


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_the_decay_of_failures_and_the_constant_are_covered_by_their_intervals(share):
    rng = np.random.default_rng(4)
    beta, span = 0.5, 10.0
    truth = {
        "beta": beta,
        "const": share / span,
        "alpha": (1 - share) * beta / -np.expm1(-beta * span),
    }
    hits = dict.fromkeys(truth, 0)
    for _ in range(60):
        found = fitted(depths(rng, 150, share, beta, span))
        for name, true in truth.items():
            value, low, high = getattr(found, name)
            assert np.isnan(low) or low <= value * (1 + 1e-9)
            assert np.isnan(high) or value <= high * (1 + 1e-9)
            hits[name] += not (true < low or true > high)
    # At 95 % each, fewer than 51 of 60 happens once in two hundred times.
    assert min(hits.values()) >= 51, hits


def test_the_decay_of_failures_is_the_maximum_of_the_likelihood():
    x = depths(np.random.default_rng(8), 200, 0.15)
    found = fitted(x)
    edges = np.arange(np.ceil(x.max() / 0.1) + 1) * 0.1
    counts, span = np.histogram(x, edges)[0], edges[-1]

    def log_likelihood(beta, share):
        decay = np.diff(-np.exp(-beta * edges)) / -np.expm1(-beta * span)
        return counts @ np.log((1 - share) * decay + share * 0.1 / span)

    beta, share = found.beta[0], found.const[0] * span
    best = log_likelihood(beta, share)
    for factor in (0.99, 1.01):
        assert log_likelihood(beta * factor, share) < best
        assert log_likelihood(beta, share * factor) < best
    for end in found.beta[1:]:
        profile = max(log_likelihood(end, s) for s in np.linspace(0, 0.9, 2000))
        assert best - profile == pytest.approx(1.92, abs=0.05)


def p_of(x, bin_mm=0.1):
    edges = np.arange(np.ceil(x.max() / bin_mm) + 1) * bin_mm
    counts = np.histogram(x, edges)[0]
    return penetration_p(edges, counts, fit_penetration(edges, counts))


def test_depths_of_the_law_are_seldom_rejected_and_others_are():
    rng = np.random.default_rng(11)
    own = [p_of(depths(rng, 150, 0.2)) for _ in range(60)]
    assert np.mean(np.array(own) < 0.05) < 0.17  # at 5 %, more happens once in two thousand times
    assert np.mean(np.array(own) < 0.5) > 0.3
    for other in (np.abs(rng.normal(4, 1, 150)), rng.choice([1.0, 5.0], 150) + rng.random(150)):
        assert p_of(other) < 1e-3


def test_too_few_failures_test_no_law():
    assert np.isnan(p_of(depths(np.random.default_rng(12), 19, 0.1)))
