"""Nothing outside of what is possible is told, however odd the track and however many trials."""

from dataclasses import asdict

import numpy as np
import pytest
from benchmarks.known_worm import Camera, KnownWorm, film
from benchmarks.ring_worm import GEOMETRY as RING
from benchmarks.ring_worm import WORMS, Noise, live
from benchmarks.ring_worm import film as film_of_ring
from hypothesis import given, settings
from hypothesis import strategies as st
from possible_values import impossible
from walked_tracks import GEOMETRY, rough_track

from worm_analysis.analysis import Analysis
from worm_analysis.summary.quantities import quantities
from worm_analysis.summary.sums import Sums

CAMERAS = {
    "still": Camera(),
    "noisy": Camera(jitter=4e-5),
    "wall outside, gaps": Camera(jitter=2e-5, wall_offset=5e-5, gaps_per_s=0.1, gap_s=2.0),
    "hopeless": Camera(jitter=3e-4, gaps_per_s=1.0, gap_s=3.0),
}


def analysed(states, geometry):
    analysis = Analysis()
    analysis.set_geometry(geometry)
    n = 0
    for state in states:
        analysis.push(state)
        n += 1
    analysis.finish()
    return analysis, n


def told(analysis, frames):
    """Return what a summary says of a trial."""
    curve = analysis.correlation()
    known = np.isfinite(curve.c)
    return {
        "quantities": {q.name: asdict(q) for q in analysis.summary()},
        "frames": {"read": frames},
        "correlation": {
            "c": curve.c[known].tolist(),
            "error": curve.error[np.isfinite(curve.error)].tolist(),
            "pairs": curve.pairs.tolist(),
        },
    }


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_of_any_track(seed, hops):
    analysis, frames = analysed(rough_track(seed, n=800, hops=hops).states(), GEOMETRY)
    assert impossible(told(analysis, frames)) == []


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
@pytest.mark.parametrize("seconds", [30.0, 240.0])
def test_of_a_worm_that_goes_through_the_rig(camera, seconds):
    worm = KnownWorm(emerges=True)
    analysis, frames = analysed(film(worm, 3, seconds, 20.0, camera), worm.geometry)
    assert impossible(told(analysis, frames)) == []


@pytest.mark.parametrize("worm", WORMS.values(), ids=WORMS)
def test_of_a_worm_that_finds_no_exit(worm):
    noise = Noise(3e-5, 0.1)
    states = film_of_ring(live(worm, 1, 120.0), noise, 1, 120.0)
    analysis, frames = analysed(states, RING)
    assert impossible(told(analysis, frames)) == []


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(0, 2**32 - 1), min_size=2, max_size=7))
def test_of_several_trials_together(seeds):
    trials = [analysed(rough_track(s, n=300, hops=s % 2 == 0).states(), GEOMETRY)[0] for s in seeds]
    sums = Sums([trial.sums() for trial in trials], 1.0, trials[0].correlation().lag_s)
    assert impossible({"quantities": {q.name: asdict(q) for q in quantities(sums)}}) == []


@pytest.mark.parametrize(
    ("name", "unit", "changed"),
    [
        ("r_h_over_R", "1", {"high": 1.2}),
        ("delta_r_h", "mm", {"high": 11.1}),
        ("d_c", "mm", {"low": -0.1}),
        ("success", "1", {"value": 1.1, "high": None}),
        ("psi_b_positive_peak", "deg", {"low": -4.0}),
        ("t_per", "s", {"low": 0.7}),
        ("t_per", "s", {"value": None}),
        ("contact_fraction", "1", {"n": 11}),
    ],
)
def test_what_is_impossible_is_found(name, unit, changed):
    entry = {"value": 0.5, "low": 0.4, "high": 0.6, "n": 9, "unit": unit, "why": ""}
    assert impossible({"quantities": {name: entry}, "frames": {"read": 10}}) == []
    assert impossible({"quantities": {name: entry | changed}, "frames": {"read": 10}})
