"""The settings of the estimates, which hold for a trial and for a pool of trials alike."""

from dataclasses import dataclass

from worm_analysis.statistics.block_jackknife import JACKKNIFE, JackknifeSettings
from worm_analysis.statistics.penetration_law import PENETRATION, PenetrationSettings


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
    most_noise_for_rule, most_noise_for_states : float
        Noise of the head's radius, in thresholds of contact, beyond which numbers of contacts are
        refused: one threshold on noisy radii flickers; from two states d_c is 5 % off beyond.
    noise_error_of_one_contact : float
        Two standard errors of that noise, relative, where it is known from one contact.
    off_by_noise : float
        Relative error of numbers of contacts, times noise over threshold: what the laws of depth
        leave open, measured on hops of four shapes (docs/contact_noise.md). No longer trial mends
        it.
    most_hidden : float
        Part of the excursions that noise and pixels may hide. Of worms of the paper's laws half as
        many hide at most; where more do, d_nc is up to 11 % off.
    most_end_over_value : float
        An end of an interval that is so many times the value, or so small a part of it, is none.
    fold_rounds : int
        In which the number of folds that hide a reversal is solved for.
    least_kept_over_gap : float
        Of the direction over a gap, by chance, below which its two sides tell little of a fold.
    fewest_parts_at_lag : int
        Fewer parts with pairs at a lag of C_θ say nothing of the error there.
    tail_in_t_per : (float, float)
        Lags of the tail of C_θ, in t_per.
    shortest_tail_in_t_per : float
        How far it must reach.
    start_in_t_per : float
        Lags of the start of C_θ, in t_per: up to this one.
    fewest_pairs_in_tail : float
        Pairs that each of its lags needs, as a part of those at lag 0; it ends where there are
        fewer.
    slope_span : float
        The slope of C_θ where it is 1/e is that of the lags this part of the time around it.
    fewest_stretches : int
        Fewer independent stretches of time say nothing of how a peak would differ another time.
    resamples : int
        Of the blocks, for the interval of a peak.
    jackknife : JackknifeSettings
        How many parts tell an error.
    penetration : PenetrationSettings
        How F(x_p) is fitted.
    """

    minimum_n: int = 10
    fewest_for_p: int = 20
    fewest_for_decay: int = 20
    shortest_track_in_t_per: float = 5.0
    radius_smoothing_bins: float = 2.0
    angle_smoothing_bins: float = 4.0
    steps_a_group: float = 3.0
    most_noise_for_rule: float = 0.25
    most_noise_for_states: float = 0.4
    noise_error_of_one_contact: float = 0.6
    off_by_noise: float = 0.2
    most_hidden: float = 0.1
    most_end_over_value: float = 100.0
    fold_rounds: int = 30
    least_kept_over_gap: float = 0.2
    fewest_parts_at_lag: int = 5
    tail_in_t_per: tuple[float, float] = (1.5, 4.0)
    shortest_tail_in_t_per: float = 2.0
    start_in_t_per: float = 0.5
    fewest_pairs_in_tail: float = 0.1
    slope_span: float = 0.25
    fewest_stretches: int = 10
    resamples: int = 200
    jackknife: JackknifeSettings = JACKKNIFE
    penetration: PenetrationSettings = PENETRATION


DEFAULTS = EstimateSettings()
