"""How the camera stands over the rig: one chamber fills the picture, or both are in view."""

from math import radians

from worm_model.simulator.rig.geometry import Rig
from worm_model.simulator.rig.optics import Optics
from worm_msgs_py import paper

ONE_EXIT_RAD, BOTH_EXIT_RAD = radians(27.0), radians(1.5)
"""Direction of chamber a's exit in the picture: no camera stands quite straight."""
SIDE_R, WIDTH_R, HEIGHT_R = 2.56, 8.0, 2.8
"""Sides of the pictures, in units of R; with both chambers, where the passage is 3.5 R long."""


def one_chamber(px_per_mm: float, exit_width_mm: float, optics: Optics) -> Rig:
    """Return a view of chamber a alone, 25.6 mm wide and high: 1024² pixels at 40 px/mm.

    The passage and chamber b are there, out of the picture.
    """
    side = round(SIDE_R * paper.RADIUS_MM * px_per_mm)
    return Rig(
        width_px=side,
        height_px=side,
        px_per_mm=px_per_mm,
        centre_px=(0.4867 * side + 0.13, 0.5054 * side - 0.21),
        exit_rad=ONE_EXIT_RAD,
        exit_width_mm=exit_width_mm,
        chamber_b=True,
        optics=optics,
    )


def both_chambers(px_per_mm: float, exit_width_mm: float, optics: Optics) -> Rig:
    """Return a view of the whole rig, 80 mm wide and 28 mm high: 1600 × 560 pixels at 20 px/mm."""
    scale = px_per_mm * paper.RADIUS_MM
    return Rig(
        width_px=round(WIDTH_R * scale),
        height_px=round(HEIGHT_R * scale),
        px_per_mm=px_per_mm,
        centre_px=(1.25 * scale + 0.3, 1.472 * scale - 0.4),
        exit_rad=BOTH_EXIT_RAD,
        exit_width_mm=exit_width_mm,
        chamber_b=True,
        optics=optics,
    )
