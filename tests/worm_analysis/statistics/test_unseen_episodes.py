"""What sampling in frames hides is undone, against samples of known laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_analysis.statistics.unseen_episodes import (
    per_true_cycle,
    unmerged_means,
)

NS = 10**9


def test_sampling_in_frames_is_undone():
    """Runs of a two-state process that is looked at once a step, against its true means."""
    rng = np.random.default_rng(2)
    true, step, n = (1.95, 1.46), 0.3, 200_000
    edges = np.cumsum(rng.exponential(np.tile(true, n // 2)))
    seen = np.searchsorted(edges, np.arange(0, edges[-1], step)) % 2
    change = np.flatnonzero(np.diff(seen)) + 1
    runs = np.diff(change) * step
    state = seen[change[:-1]]
    excess = [(runs[state == k] - 1.5 * step)[runs[state == k] > 1.5 * step] for k in (0, 1)]
    naive = [item.mean() for item in excess]
    assert naive[0] > 1.02 * true[0]
    assert unmerged_means(*naive, step) == pytest.approx(true, rel=0.01)


@given(st.floats(0, 0.49), st.integers(1, 6))
def test_the_reversals_of_unseen_cycles_are_undone(chance, cycles):
    """A head that turns round with a chance after each cycle, looked at after every few cycles."""
    goes_on = 1.0
    for _ in range(cycles):
        goes_on = goes_on * (1 - chance) + (1 - goes_on) * chance
    assert per_true_cycle(1 - goes_on, cycles) == pytest.approx(chance, abs=1e-6)
