"""Layers are told by what one layer looks like at each place of a body, marks and all."""

import numpy as np
import pytest
from drawn_folds import DARKENING, LEVEL, NODES_PER_WIDTH, Drawn, as_rows, rounded_widths

from worm_tracker.midline.body_residual import (
    BodyResidualSettings,
    ObjectMasks,
    dark_places,
    unexplained,
)
from worm_tracker.midline.body_shade import (
    ACROSS,
    BodyShade,
    ShadedObject,
    marks_of,
    shade_along,
)
from worm_tracker.midline.curve import as_complex

SETTINGS = BodyResidualSettings()
WIDTH = 12.0
LENGTH_WIDTHS = 24.0
OPEN = [(LENGTH_WIDTHS, 0.03)]
LOOP = [(7.0, 0.0), (10.0, 0.55), (7.0, 0.0)]
MARKED = 1.45
"""Signal in a mark over that beside it: as dark as an overlap."""


def with_mark(drawn):
    """Return a signal in which a mark on the body, clear of the loop's crossing, is darker."""
    at = drawn.curve[10 * NODES_PER_WIDTH : 13 * NODES_PER_WIDTH : 4]
    v, u = np.indices(drawn.signal.shape)
    near = np.abs(u + 1j * v - at[:, None, None]).min(axis=0) < 0.75 * WIDTH
    return np.where(near, MARKED * drawn.signal, drawn.signal)


def picture(arcs, marked):
    drawn = Drawn.of(arcs, WIDTH)
    signal = with_mark(drawn) if marked else drawn.signal
    return drawn, np.clip(signal, 0, 255).astype(np.uint8)


def learned(marked):
    """Return what an open body's pictures tell of one layer."""
    drawn, signal = picture(OPEN, marked)
    points, widths = drawn.claimed()
    seen = shade_along(signal, as_complex(points), widths)
    return BodyShade.of(seen).updated(seen, 0.02)


def overlap_of(arcs, marked, by_place, claimed=None):
    """Return what a body leaves unexplained of a picture's layers: the true one by default."""
    drawn, signal = picture(arcs, marked)
    points, widths = drawn.claimed() if claimed is None else claimed(drawn)
    shaded = ShadedObject(signal, learned(marked), DARKENING) if by_place else None
    dark = dark_places(signal, LEVEL, DARKENING, SETTINGS)
    seen = ObjectMasks(drawn.mask, dark, WIDTH, SETTINGS, shaded)
    return unexplained(seen, points, widths).overlap


def along(s_widths, drawn):
    """Return a body that passes these places of a drawn one, one after the other."""
    s = np.asarray(s_widths) * WIDTH
    passed = np.r_[0.0, np.cumsum(np.abs(np.diff(s)))]
    return as_rows(drawn.at(s)), rounded_widths(passed, WIDTH)


def cut_short(drawn):
    return along(np.linspace(0.0, 13.0, 65), drawn)


def laid_back(drawn):
    return along(np.r_[np.linspace(0.0, 16.0, 50), np.linspace(15.7, 9.0, 20)], drawn)


@pytest.mark.parametrize("arcs", [OPEN, LOOP], ids=["open", "across itself"])
@pytest.mark.parametrize("marked", [False, True])
def test_a_true_body_has_the_layers_of_its_picture(arcs, marked):
    assert overlap_of(arcs, marked, by_place=True) < 0.1


def test_without_its_places_a_mark_is_an_overlap():
    assert overlap_of(OPEN, marked=True, by_place=False) > SETTINGS.most_overlap


@pytest.mark.parametrize("marked", [False, True])
@pytest.mark.parametrize(
    ("arcs", "claimed"),
    [
        pytest.param(LOOP, cut_short, id="once where the picture is of two"),
        pytest.param([(LENGTH_WIDTHS, 0.0)], laid_back, id="twice where it is of one"),
    ],
)
def test_a_body_that_has_other_layers_than_its_picture_is_found(arcs, claimed, marked):
    assert overlap_of(arcs, marked, True, claimed) > SETTINGS.most_overlap


def test_marks_are_how_far_the_signal_differs_along_a_body():
    plain, marked = (learned(m).mean[:, len(ACROSS) // 2] for m in (False, True))
    assert marks_of(plain) < 0.02
    assert marks_of(marked) > 0.1


def test_a_shade_turned_round_is_what_is_seen_from_the_other_end_on():
    drawn, signal = picture(LOOP, marked=True)
    points, widths = drawn.claimed()
    line, sides = as_complex(points), np.arange(signal.shape[1]) % 40 + 100
    signal = np.broadcast_to(sides, signal.shape).astype(np.uint8)
    shade = BodyShade.of(shade_along(signal, line, widths)).turned_round()
    seen = shade_along(signal, line[::-1], widths[::-1])
    assert shade.mean == pytest.approx(seen)
    assert not np.allclose(shade.mean, shade.mean[:, ::-1])
