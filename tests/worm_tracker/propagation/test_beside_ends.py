"""An end beside which the object is broader than the body is bent back there, unless it is pale."""

from dataclasses import replace

import numpy as np
import pytest
from body_searches import path_along, search_in
from drawn_folds import DARKENING, LEVEL, Drawn

from worm_tracker.propagation.beside_ends import broad_ends

WIDTH = 14.0


def broad_ends_of(drawn, curve, signal):
    """Return which ends of a body along a curve are too broad, in a picture with this signal."""
    path = path_along(curve, WIDTH)
    search = search_in(signal, curve, path, np.full(65, WIDTH), LEVEL, DARKENING)
    object_mask = np.where(signal > 0.15 * LEVEL, 255, 0).astype(np.uint8)
    search = replace(search, seen=replace(search.seen, mask=object_mask))
    found = search.scored(path, search.model.widths)
    return broad_ends(found, signal, search.levels, WIDTH, search.settings)


@pytest.mark.parametrize("darker", [True, False])
def test_an_end_bent_back_onto_its_flank_is_broad_where_its_bend_is_taken_for_the_end(darker):
    drawn = Drawn.of([(10.0, 0.0), (0.9, 3.5), (1.5, 0.0)], WIDTH, darker=darker)
    up_to_the_bend = drawn.at(np.linspace(0, 10.45 * WIDTH, 200))
    assert broad_ends_of(drawn, up_to_the_bend, drawn.signal) == (False, True)
    assert broad_ends_of(drawn, drawn.curve, drawn.signal) == (False, False)


@pytest.mark.parametrize(
    ("over_body_level", "is_broad"),
    [pytest.param(0.25, False, id="pale"), pytest.param(0.6, True, id="as dark as a body's edge")],
)
def test_what_lies_beside_an_end_makes_it_broad_where_it_is_as_dark_as_body(
    over_body_level, is_broad
):
    """A photographed tail has a pale rim, and ends where it was told to end."""
    drawn = Drawn.of([(10.0, 0.0)], WIDTH)
    tip = drawn.curve[-1]
    rows, columns = np.indices(drawn.signal.shape)
    rim = np.hypot(columns - tip.real + 0.5 * WIDTH, rows - tip.imag - 0.6 * WIDTH) < 0.6 * WIDTH
    lobe = np.where(rim, round(over_body_level * LEVEL), 0).astype(np.uint8)
    signal = np.maximum(drawn.signal, lobe)
    assert broad_ends_of(drawn, drawn.curve, signal) == (False, is_broad)
