"""A film in another guise shows the same worm: what is told of it can be laid over the film."""

import numpy as np
import pytest
from benchmarks.guises import GUISES, Told, apart_px, compared, exchanged

SHAPE = (90, 140)
LINE = np.stack([np.linspace(20.0, 90.0, 65), 40 + 5 * np.sin(np.linspace(0, 6, 65))], axis=1)
WIDTH_PX = 10.0


@pytest.mark.parametrize("guise", GUISES)
@pytest.mark.parametrize("at", [(20, 30), (119, 77), (70, 11)])
def test_a_point_that_is_seen_in_a_guise_is_found_where_it_is(guise, at):
    u, v = at
    picture = np.full(SHAPE, 20, np.uint8)
    picture[v - 1 : v + 2, u - 1 : u + 2] = 250
    shown = GUISES[guise].picture(picture).astype(float)
    weight = np.where(shown > 100, shown - 20.0, 0.0)
    rows, columns = np.indices(shown.shape)
    seen = np.array([[(weight * columns).sum(), (weight * rows).sum()]]) / weight.sum()
    assert np.allclose(GUISES[guise].back(seen, SHAPE), [at], atol=0.1)


def test_midlines_are_as_far_apart_whichever_way_round_they_come():
    beside = LINE + np.array([0.0, 12.0])
    for other in (beside, beside[::-1]):
        assert apart_px(LINE, other) == pytest.approx(12.0, abs=0.5)


def test_only_midlines_that_both_tell_whole_and_for_certain_are_compared():
    part = LINE.copy()
    part[20:30] = np.nan
    one = {1: Told(LINE, 0.95), 2: Told(LINE, 0.95), 3: Told(LINE, 0.95), 4: Told(LINE, 0.95)}
    other = {1: Told(LINE, 0.95), 2: Told(LINE, 0.6), 3: Told(part, 0.95), 9: Told(LINE, 0.95)}
    assert compared(one, other) == [1]


def test_ends_that_change_places_from_a_frame_to_the_next_are_found():
    told = {k: Told(LINE[::-1] if k == 2 else LINE, 0.95) for k in range(5)}
    assert exchanged(told, WIDTH_PX) == [2, 3]
    told[2] = Told(LINE[::-1], 0.8)
    assert exchanged(told, WIDTH_PX) == []
    crawls = {k: Told(LINE + 2.0 * k, 0.95) for k in range(5)}
    assert exchanged(crawls, WIDTH_PX) == []
