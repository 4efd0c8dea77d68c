"""An end that lies along its own body is found by the marks of a skin, not by darkness alone."""

import numpy as np
import pytest
from drawn_folds import LEVEL, NODES_PER_WIDTH, laid
from marked_skins import PLACES, marks_from

from worm_tracker.midline.expected_body import ExpectedBody
from worm_tracker.midline.node_odds import level_below
from worm_tracker.midline.path import BodyPath, evenly, nodes_for
from worm_tracker.midline.path_following import PathFollowingSettings, slide_along_path
from worm_tracker.midline.self_cover import SelfCoverSettings

WIDTH, DARKENING, OVER_WIDTHS = 14.0, 0.3, 4.0


def ring_with_end_on_it():
    """Return a body that runs round a ring, and on over its own beginning, and its window."""
    curve = laid([(5.0, 0.0), (6 * np.pi + OVER_WIDTHS, 1 / 3)], WIDTH)
    curve -= complex(curve.real.min(), curve.imag.min()) - 4 * WIDTH * (1 + 1j)
    return curve, (int(curve.imag.max() + 4 * WIDTH), int(curve.real.max() + 4 * WIDTH))


def layer(part, curve, marks, shape):
    """Return the signal of one layer of a part of a body; 0 where it is not."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    at = np.arange(len(curve))[part][::2]
    away = np.abs((u + 1j * v)[..., None] - curve[at])
    level = LEVEL * np.interp(at / (len(curve) - 1), np.linspace(0, 1, PLACES), marks)
    return np.where(away.min(axis=2) < WIDTH / 2, level[away.argmin(axis=2)], 0.0)


def end_off_widths(seed, *, is_marked):
    """Return how far along the ring the end is found from where it is, and its deviation."""
    rng, marks = np.random.default_rng(seed), marks_from(seed)
    curve, shape = ring_with_end_on_it()
    half, cap = len(curve) // 2, NODES_PER_WIDTH // 2  # each end is half a circle
    first, second = (
        layer(part, curve, marks, shape) for part in (np.s_[cap:half], np.s_[half:-cap])
    )
    signal = np.where(first > 0, first + DARKENING * second, second)
    signal = np.clip(np.rint(signal + rng.normal(0.0, 2.0, shape)), 0, 255).astype(np.uint8)
    lag = round(rng.uniform(0.0, 0.6) * len(curve) * WIDTH / np.abs(np.diff(curve)).sum())
    before = curve[: len(curve) - lag]
    length = float(np.abs(np.diff(curve)).sum())
    levels = LEVEL * marks
    body = ExpectedBody(
        np.full(PLACES, WIDTH), levels, length, 0.04 * length, DARKENING, is_marked=is_marked
    )
    nodes = nodes_for(float(np.abs(np.diff(before)).sum()), WIDTH)
    path = BodyPath(evenly(before, nodes))
    slid = slide_along_path(signal, path, (0.0, 0.0), body, 1, PathFollowingSettings())
    assert slid is not None
    return abs(slid.path.curve[-1] - curve[-1]) / WIDTH, slid.ends[1].sd / WIDTH


@pytest.fixture(scope="module")
def found():
    return {
        is_marked: np.array([end_off_widths(seed, is_marked=is_marked) for seed in range(24)])
        for is_marked in (True, False)
    }


def test_marks_tell_where_an_end_lies_along_its_own_body(found):
    off, _ = found[True].T
    assert np.median(off) < 0.2
    assert (off < 0.35).all()


def test_by_darkness_alone_some_such_ends_are_half_a_width_off(found):
    by_marks, by_darkness = found[True][:, 0], found[False][:, 0]
    assert by_marks.mean() < 0.9 * by_darkness.mean()
    assert by_marks.max() < 0.6 * by_darkness.max()


def test_such_an_end_is_as_sure_as_it_is_near(found):
    off, sd = found[True].T
    assert (off < 2 * sd).mean() > 0.95


def test_the_part_below_is_the_nearest_that_is_not_the_same_and_is_there():
    line = np.r_[np.arange(0.0, 100.0), np.arange(98.0, -1.0, -1.0)] + 0j
    level = np.arange(float(len(line))) + 1
    covered = np.ones(len(line), bool)
    cover = SelfCoverSettings()
    assert level_below(line, covered, level, 1.0, 4.0, cover)[150] == level[48]
    level[45:52] = 0.0  # the body is not there
    assert level_below(line, covered, level, 1.0, 4.0, cover)[150] == level[44]
    covered[150] = False
    assert level_below(line, covered, level, 1.0, 4.0, cover)[150] == 0.0
