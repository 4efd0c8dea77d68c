"""A worm that bends sharply stays one worm: no part of it is taken for dirt or for background."""

import numpy as np

from worm_model.simulator.rig import Optics, Rig
from worm_model.simulator.worm import Walker, simulate_film
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker


def test_the_corner_that_a_midline_cuts_is_not_taken_for_dirt():
    """Where it bends by more than a right angle within a width its midline lies off its middle."""
    rig = Rig(exit_width_mm=2.0, optics=Optics(noise=2.0, seed=0))
    tracker, given, lengths = Tracker(TrackerParameters()), [], []
    for frame in simulate_film(rig, Walker(seed=0), 1.5, 30.0):
        lengths.append(frame.truth.length_mm)
        given += tracker.push(frame.picture, frame.stamp_ns)
    given += tracker.finish()
    found = np.array([tracked.state.length_m * 1e3 for tracked in given])
    seen = np.isfinite(found)
    assert seen.mean() > 0.95
    assert np.abs(found / np.array(lengths) - 1.0)[seen].max() < 0.12
