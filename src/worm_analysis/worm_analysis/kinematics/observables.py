"""The symbols of the paper as functions of positions: for one frame, or for arrays of frames."""

from math import atan2, hypot, pi

import numpy as np

from worm_msgs_py.contract.chamber import Real


def wrap_angle(angle_rad: Real) -> Real:
    """Return the same direction in (−π, π]; NaN stays NaN."""
    return pi - (pi - angle_rad) % (2 * pi)


def radial_distance(x_m: Real, y_m: Real) -> Real:
    """Return r, the distance from the chamber's centre, m.

    Parameters
    ----------
    x_m, y_m : float or ndarray
        Coordinates in the chamber's frame (origin at its centre), m.
    """
    if isinstance(x_m, float):  # ten times as fast as an array of one
        return hypot(x_m, y_m)
    distance: Real = np.hypot(x_m, y_m)
    return distance


def polar_angle(x_m: Real, y_m: Real) -> Real:
    """Return θ in [−π, π], counter-clockwise from the middle of the exit (paper, Fig. 1a)."""
    if isinstance(x_m, float):
        return atan2(y_m, x_m)
    angle: Real = np.arctan2(y_m, x_m)
    return angle


def body_angle(head_x_m: Real, head_y_m: Real, centroid_x_m: Real, centroid_y_m: Real) -> Real:
    """Return ψ_b, the body's orientation relative to the wall's normal at the head.

    Parameters
    ----------
    head_x_m, head_y_m, centroid_x_m, centroid_y_m : float or ndarray
        Head tip and centroid in the chamber's frame, m.

    Returns
    -------
    float or ndarray
        Signed angle in (−π, π] from the outward normal at θ_h to the vector head − centroid,
        counter-clockwise positive: ψ_b > 0 ⇔ the body points counter-clockwise along the wall, so
        that v_b = v_w sin ψ_b with v_w > 0 (paper, Fig. 4c).
    """
    direction = polar_angle(head_x_m - centroid_x_m, head_y_m - centroid_y_m)
    return wrap_angle(direction - polar_angle(head_x_m, head_y_m))


def head_angle(head_x_m: Real, head_y_m: Real, head_yaw_rad: Real) -> Real:
    """Return ψ_h in (−π, π]: as `body_angle`, with the head's own direction."""
    return wrap_angle(head_yaw_rad - polar_angle(head_x_m, head_y_m))


def incidence_angle(
    before_x_m: Real, before_y_m: Real, contact_x_m: Real, contact_y_m: Real
) -> Real:
    """Return θ_h^i in (−π, π], from the normal at the point of contact to the displacement to it.

    Parameters
    ----------
    before_x_m, before_y_m : float or ndarray
        The head shortly before the contact, m.
    contact_x_m, contact_y_m : float or ndarray
        The head at the first frame of the contact, m.
    """
    return body_angle(contact_x_m, contact_y_m, before_x_m, before_y_m)
