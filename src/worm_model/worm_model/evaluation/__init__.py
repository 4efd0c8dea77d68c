"""How far a trial's tracks are from its truth: every figure with the number of its frames."""

from worm_model.evaluation.frame_table import ChamberCircle, FrameTable
from worm_model.evaluation.tables import frame_table_of, read_tracks, read_truth
from worm_model.evaluation.track_errors import Evaluation, Figure, evaluate_tracks

__all__ = [
    "ChamberCircle",
    "Evaluation",
    "Figure",
    "FrameTable",
    "evaluate_tracks",
    "frame_table_of",
    "read_tracks",
    "read_truth",
]
