"""Several trials as one: additive sums of each, pooled by exit width, with intervals by trial."""

from worm_analysis.pooling.pool import Pool, group_width_mm
from worm_analysis.pooling.prediction import WalkPrediction
from worm_analysis.pooling.trial_sums import TrialSums, trial_sums

__all__ = ["Pool", "TrialSums", "WalkPrediction", "group_width_mm", "trial_sums"]
