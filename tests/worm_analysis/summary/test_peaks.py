"""Peaks hold the truth or have no value; nothing lies beyond the wall."""

import numpy as np
import pytest

from worm_analysis.accumulators.bins import ANGLE_EDGES, RADIUS_BINS
from worm_analysis.accumulators.direction_correlation import lag_grid
from worm_analysis.statistics.block_jackknife import BlockSums
from worm_analysis.summary.direction_persistence import NotEnoughData
from worm_analysis.summary.peaks import angle_peak, angle_quantile, radius_peak, within_wall
from worm_analysis.summary.sums import Sums

T_PER_S = 20.0


def trial_of(seconds, **histograms):
    """The sums of a trial whose direction is kept for 20 s."""
    lag_s = lag_grid(120, 10, 0.1, 1.0) * 0.1
    pairs = np.full(len(lag_s), seconds * 10.0)
    c_theta = np.concatenate([pairs, pairs * np.exp(-lag_s / T_PER_S)])[None]
    sums = {"c_theta": c_theta, "search_bridged": np.array([[seconds, 0.0]])}
    return Sums([sums | histograms], lag_s=lag_s)


def angles(seed, seconds, lean=0.55):
    """ψ_b of a worm that turns round every 20 s, in blocks of time; its body sways slowly."""
    rng = np.random.default_rng(seed)
    blocks = BlockSums(len(ANGLE_EDGES) - 1)
    side, sway = 1.0, 0.0
    for second in range(int(seconds)):
        side = -side if rng.random() < 1 / T_PER_S else side
        sway += -sway / 5 + rng.normal(0, 0.06)
        told = side * (lean + sway) + rng.normal(0, 0.1, 10)
        row = blocks.row(second * 10**9)
        row += np.histogram(told, ANGLE_EDGES)[0]
    return blocks.rows()


def test_the_interval_of_a_peak_holds_the_truth():
    held = 0
    for seed in range(60):
        sums = trial_of(1800.0, psi_b=angles(seed, 1800.0))
        value, low, high = angle_peak("psi_b", 1)(sums)
        assert low <= value <= high
        held += low <= 0.55 <= high
    assert held >= 54


def test_a_peak_of_few_independent_stretches_is_refused():
    sums = trial_of(180.0, psi_b=angles(0, 180.0))
    with pytest.raises(NotEnoughData, match=r"9\.0 independent stretches of time, of 20 s each"):
        angle_peak("psi_b", 1)(sums)


def test_a_head_at_the_wall_has_its_peak_at_the_wall_and_not_beyond():
    """The noise puts half of the frames beyond it, where no head can be."""
    rng = np.random.default_rng(3)
    rows = np.stack(
        [
            np.histogram(1.0 + rng.normal(0, 0.01, 300), RADIUS_BINS, (0, 1.2))[0].astype(float)
            for _ in range(64)
        ]
    )
    value, low, _ = radius_peak("r_h")(trial_of(1800.0, r_h=rows))
    assert value == pytest.approx(1.0, abs=0.005)
    assert 0.98 < low < value
    assert within_wall(rows).sum() == rows.sum()


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_quantiles_lie_between_bins(part):
    """Bins are 2° wide; the interval holds the value of all data together."""
    values = np.random.default_rng(1).normal(0.3, 0.5, (64, 4000)).clip(-3.0, 3.0)
    rows = np.array([np.histogram(row, ANGLE_EDGES)[0] for row in values]).astype(float)
    value, low, high = angle_quantile("psi_b", part)(trial_of(1800.0, psi_b=rows))
    assert value == pytest.approx(np.quantile(values, part), abs=0.002)
    assert low < value < high
