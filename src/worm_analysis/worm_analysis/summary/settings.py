"""The settings of the estimates, which hold for a trial and for a pool of trials alike."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EstimateSettings:
    """How numbers follow from sums, and how much data they need.

    Attributes
    ----------
    minimum_n : int
        Items that every number needs; as in `AnalysisParameters`.
    fewest_for_p : int
        Items that the test of an exponential law needs: fewer fit any law.
    fewest_for_decay : int
        Failures that F(x_p) needs: fewer fit a decay and a constant alike.
    shortest_track_in_t_per : float
        Time with a direction that t_per needs, in units of t_per: a shorter track holds too few
        reversals to average over.
    radius_smoothing_bins, angle_smoothing_bins : float
        Widths of the Gaussians that P(r) and P(ψ_b) are smoothed with before their peaks are
        taken, in bins (R/50 and 8°): wide enough that counting noise makes no peak.
    steps_a_group : float
        Lengths come in the head's steps from frame to frame; the test of their law looks at them
        in bins of so many steps.
    """

    minimum_n: int = 10
    fewest_for_p: int = 20
    fewest_for_decay: int = 20
    shortest_track_in_t_per: float = 5.0
    radius_smoothing_bins: float = 2.0
    angle_smoothing_bins: float = 4.0
    steps_a_group: float = 3.0


DEFAULTS = EstimateSettings()
