"""A frame's numbers and C_θ(t) as plain JSON, named with their units, for plots of any program."""

from collections.abc import Mapping
from math import degrees, isfinite, nan
from typing import Any

import numpy as np

from worm_msgs_py import Correlation, Observables
from worm_msgs_py.units import MM_PER_M

NUMBERS_TOPIC, CORRELATION_TOPIC = "analysis/numbers", "analysis/C_theta"
_NUMBER, _NUMBERS = {"type": "number"}, {"type": "array", "items": {"type": "number"}}


def numbers_of(observables: Observables) -> dict[str, float]:
    """Return what is known of a frame; a number that is not is left out."""
    return {name: value for name, value in _all(observables).items() if isfinite(value)}


def _all(observables: Observables) -> dict[str, float]:
    contact = observables.contact
    return {
        "frame": float(observables.frame),
        "r_h_mm": observables.r_h_m * MM_PER_M,
        "r_c_mm": observables.r_c_m * MM_PER_M,
        "r_t_mm": observables.r_t_m * MM_PER_M,
        "theta_h_deg": degrees(observables.theta_h_rad),
        "psi_b_deg": degrees(observables.psi_b_rad),
        "psi_h_deg": degrees(observables.psi_h_rad),
        "theta_dot_h_deg_per_s": degrees(observables.theta_dot_rad_s),
        "v_b_mm_per_s": observables.v_b_m_s * MM_PER_M,
        "contact": nan if contact is None else float(contact),
    }


def curve_of(correlation: Correlation) -> dict[str, list[float]]:
    """Return the points of C_θ(t) that are known."""
    known = np.isfinite(correlation.c)
    return {
        "lag_s": np.asarray(correlation.lag_s)[known].tolist(),
        "C_theta": np.asarray(correlation.c)[known].tolist(),
    }


SCHEMAS: Mapping[str, Mapping[str, Any]] = {
    NUMBERS_TOPIC: {
        "type": "object",
        "title": "worm.Numbers",
        "properties": dict.fromkeys(_all(Observables(0, 0)), _NUMBER),
    },
    CORRELATION_TOPIC: {
        "type": "object",
        "title": "worm.Correlation",
        "properties": {"lag_s": _NUMBERS, "C_theta": _NUMBERS},
    },
}
"""JSON schema of each topic."""
