"""Passages of the boundary walk from random states, with what was forecast for each of them."""

from collections.abc import Iterator
from math import pi

import numpy as np

from worm_model.boundary_walk.monte_carlo import simulate_walks
from worm_model.boundary_walk.parameters import WalkParameters
from worm_model.inference.forecast import Forecaster
from worm_msgs_py import Forecast, Observables, Where


def observables(theta_rad, direction, contact, where=Where.CHAMBER_A, stamp_ns=0, frame=0):
    """Return a frame of a head at θ that goes one way, in contact or not."""
    return Observables(
        frame, stamp_ns, where, theta_h_rad=theta_rad, theta_dot_rad_s=0.1 * direction,
        contact=contact,
    )  # fmt: skip


def passages(
    walk: WalkParameters, states: int, walks: int, seed: int
) -> Iterator[tuple[Forecast, object, np.ndarray]]:
    """Yield, for random states on the wall, the forecast, its law, and how long walks took."""
    random = np.random.default_rng(seed)
    forecaster = Forecaster(walk, ())
    edge_rad = 0.5 * walk.exit_arc_mm / walk.radius_mm
    for number in range(states):
        theta = random.uniform(edge_rad, 2 * pi - edge_rad)
        frame = observables(theta, random.choice([-1.0, 1.0]), bool(random.random() < 0.57))
        forecast, law = forecaster(frame)
        start = forecaster.state(theta, forecast.direction, forecast.contact)
        result = simulate_walks(walk, walks, seed + 1 + number, start=start)
        yield forecast, law, result.tau_h_s
