"""How far a trial's tracks are from its truth: every figure with the number of its frames."""

from worm_model.evaluation.figures import CERTAIN, Evaluation, Figure, evaluate
from worm_model.evaluation.record import Circle, EvaluationError, Record
from worm_model.evaluation.tables import read_tracks, read_truth, record_of

__all__ = [
    "CERTAIN",
    "Circle",
    "Evaluation",
    "EvaluationError",
    "Figure",
    "Record",
    "evaluate",
    "read_tracks",
    "read_truth",
    "record_of",
]
