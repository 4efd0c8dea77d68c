"""The synthetic rig: draws a worm into the back-lit chambers, and knows the truth of each frame."""

from worm_model.simulator.rig.body import Body
from worm_model.simulator.rig.drawing import clear_view, draw, expose, worm_coverage
from worm_model.simulator.rig.geometry import Rig
from worm_model.simulator.rig.optics import FilmedPicture, Optics
from worm_model.simulator.rig.truth import TruthRow, truth_of, write_truth

__all__ = [
    "Body",
    "FilmedPicture",
    "Optics",
    "Rig",
    "TruthRow",
    "clear_view",
    "draw",
    "expose",
    "truth_of",
    "worm_coverage",
    "write_truth",
]
