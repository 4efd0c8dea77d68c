"""Several trials as one: their sums added up, grouped by the exit's width; points for figures."""

from worm_analysis.pooling.pool import Pool, Pooled, group_widths_mm
from worm_analysis.pooling.pooled_trial import PooledTrial, pooled_trial
from worm_analysis.pooling.prediction import WalkPrediction

__all__ = [
    "Pool",
    "Pooled",
    "PooledTrial",
    "WalkPrediction",
    "group_widths_mm",
    "pooled_trial",
]
