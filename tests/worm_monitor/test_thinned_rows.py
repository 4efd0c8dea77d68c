"""The whole trial stays in view, in bounded memory."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from worm_monitor.thinned_rows import ThinnedRows

STEPS = st.lists(st.floats(0.0, 5.0), max_size=400)


def times(steps):
    """Return times that grow by these steps."""
    found, now = [], 0.0
    for step in steps:
        now += step
        found.append(now)
    return found


@given(STEPS, st.integers(2, 40))
def test_rows_are_bounded_apart_and_from_beginning_to_end(steps, most):
    thinned = ThinnedRows(most=most, spacing_s=0.1)
    given_s = times(steps)
    for time_s in given_s:
        thinned.add([time_s])
    kept = [row[0] for row in thinned.rows]
    assert len(kept) <= most
    assert all(after - before > 0.99 * thinned.spacing_s for before, after in pairwise(kept))
    if given_s:
        assert kept[0] == given_s[0]
        assert set(kept) <= set(given_s)


@given(STEPS, st.integers(2, 40), st.integers(1, 30))
def test_whoever_puts_the_news_together_has_all_rows(steps, most, every):
    thinned, page = ThinnedRows(most=most), []
    for k, time_s in enumerate(times(steps)):
        thinned.add([time_s])
        if k % every == 0:
            anew, rows = thinned.news()
            page = rows if anew else page + rows
    anew, rows = thinned.news()
    assert (rows if anew else page + rows) == thinned.rows


def test_a_row_that_is_due_by_rounding_is_kept():
    thinned = ThinnedRows()
    for k in range(50):
        thinned.add([round(0.1 * k, 6)])
    assert len(thinned.rows) == 50
