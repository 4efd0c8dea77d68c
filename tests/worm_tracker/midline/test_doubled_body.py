"""A body laid double is told by its step; one whose skin varies and that tapers is not."""

import numpy as np
import pytest
from drawn_folds import HEADINGS, LEVEL, WIDTHS, Drawn, as_rows
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_model.simulator.folded_worms import (
    LOOKS,
    FoldedWorm,
    film_worm,
    rig_for,
)
from worm_model.simulator.rig.skins import read_skins
from worm_tracker.midline.doubled_body import DoubledBodySettings, looks_doubled
from worm_tracker.midline.refine import RefinedMidline, RefineSettings, refine

SETTINGS = DoubledBodySettings()
PART = np.linspace(0.0, 1.0, 65)


def body(widths, levels):
    points = np.c_[150.0 * PART, np.zeros(65)]
    return RefinedMidline(
        points, widths, 10.0, levels, float(np.median(levels)), 1.0, 1500.0, 75.0, 0.0
    )


def tapered(width, taper):
    """Return widths that fall over a part of either end's length."""
    inside = np.clip(1 - np.minimum(PART, 1 - PART) / taper, 0.0, 1.0)
    return width * np.sqrt(1 - inside**2)


SCATTER = st.floats(0.0, 0.03)
SEEDS = st.integers(0, 2**16)


@given(
    first=st.floats(0.2, 0.35),
    long=st.floats(0.12, 0.5),
    step=st.floats(0.25, 1.0),
    scatter=SCATTER,
    seed=SEEDS,
    broader=st.booleans(),
)
def test_an_even_step_is_told_wherever_it_is(first, long, step, scatter, seed, broader):
    noise = 1 + scatter * np.random.default_rng(seed).normal(size=65)
    there = np.abs(PART - first - long / 2) < long / 2
    double = np.where(there, 1 + step, 1.0) * noise
    even = np.ones(65)
    widths, levels = (double, even) if broader else (even, double)
    assert looks_doubled(body(10.0 * widths * tapered(1.0, 0.1), 100.0 * levels), SETTINGS)


@given(bend=st.floats(-0.4, 0.4), width=WIDTHS, heading=HEADINGS, seed=SEEDS)
@settings(max_examples=15)
def test_a_drawn_open_body_is_not(bend, width, heading, seed):
    drawn = Drawn.of([(6.0, bend), (7.0, -bend)], width, heading, noise=3.0)
    found = refine(drawn.signal, (0, 0), as_rows(drawn.curve), width, RefineSettings())
    assert not looks_doubled(found, SETTINGS), seed


@pytest.mark.parametrize("back_widths", [3.0, 5.0, 7.0])
@pytest.mark.parametrize("width", [8.0, 12.0, 16.0])
def test_a_drawn_body_that_lies_exactly_on_itself_is(width, back_widths):
    """Its last widths lie back along it: what is seen is a body shorter by these, partly darker."""
    there = np.arange(0.0, 13.0, 1 / 16)
    back = there[-1] - np.arange(1 / 16, back_widths, 1 / 16)
    curve = (np.r_[there, back] * np.exp(0.4j) + 4 + 4j) * width
    drawn = Drawn(curve, width, noise=3.0)
    seen = as_rows(curve[: len(there)])
    found = refine(drawn.signal, (0, 0), seen, width, RefineSettings())
    assert found.levels.max() > 1.3 * LEVEL
    assert looks_doubled(found, SETTINGS)


PALE_TAIL = pytest.mark.xfail(strict=True, reason="its tail is paler within a width or so")


@pytest.mark.parametrize(
    ("name", "turn_per_mm"),
    [
        ("w4", 0.13),
        ("w4", 0.16),
        ("w4", 0.2),
        pytest.param("w5", 0.13, marks=PALE_TAIL),
        ("w5", 0.16),
        ("w5", 0.2),
    ],
)
def test_a_real_skin_on_an_open_body_is_not(name, turn_per_mm):
    skin, look = read_skins()[name], LOOKS[f"skin_{name}"]
    s = np.linspace(0.0, skin.length_mm, 201)
    z = np.r_[0.0, np.cumsum(np.exp(1j * turn_per_mm * s[:-1]) * np.diff(s))]
    z -= complex(z.real.max() + z.real.min(), z.imag.max() + z.imag.min()) / 2
    rig = rig_for(look)
    frame, true = next(film_worm(rig, FoldedWorm(as_rows(z)[None], np.ones(201), 10.0), look, skin))
    light = rig.optics.light_field(rig.width_px, rig.height_px)
    signal = np.clip(np.rint(light - frame.picture), 0, 255).astype(np.uint8)
    found = refine(signal, (0, 0), true.points_px, true.mean_width_px, RefineSettings())
    assert found.edges_found == 1.0
    assert not looks_doubled(found, SETTINGS)
