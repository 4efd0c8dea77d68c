"""Everything that a user may tell the analysis, with its default."""

from dataclasses import dataclass

from worm_msgs_py import limits, paper
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit

_SPAN = Limit(1e-3, 86_400.0, "s")
ANALYSIS_LIMITS = {
    "contact_factor": limits.CONTACT_FACTOR,
    "release_factor": limits.CONTACT_FACTOR,
    "body_width_m": limits.BODY_WIDTH,
    "min_episode_s": Limit(0.0, 600.0, "s"),
    "theta_dot_window_s": _SPAN,
    "mean_window_s": _SPAN,
    "min_head_certainty": Limit(0.5, 1.0),
    "incidence_window_s": _SPAN,
    "max_gap_s": _SPAN,
    "max_bridged_s": _SPAN,
    "max_lag_s": _SPAN,
    "fine_lag_s": _SPAN,
    "fine_step_s": _SPAN,
    "coarse_step_s": _SPAN,
    "stroke_window_s": _SPAN,
    "minimum_n": Limit(3, 1e6),
    "summary_interval_s": _SPAN,
}
MOST_LAGS = 100_000
"""Of C_θ: each takes memory and time at every frame."""


@dataclass(frozen=True, slots=True)
class AnalysisParameters:
    """Settings of an `Analysis`.

    Attributes
    ----------
    contact_factor : float
        The head touches the wall where R − r_h < contact_factor·d_w without noise (paper: 0.3).
    release_factor : float
        Of the threshold rules that stand beside: once in contact the head stays so until
        R − r_h ≥ release_factor·d_w. Equal to `contact_factor`: no hysteresis, as in the paper.
    body_width_m : float or None
        d_w, where it is given; None: the running median of the states' own widths.
    min_episode_s : float
        A contact, or an excursion, shorter than this does not end the episode around it. 0: every
        frame counts, as in the paper.
    theta_dot_window_s : float
        Δt of θ̇_h = Δθ_h/Δt (paper: 1 s).
    mean_window_s : float
        v_b and ψ_b are averaged over this time for v_b = v_w sin⟨ψ_b⟩: one undulatory stroke (the
        paper's T_T = 12 s), which sways the body.
    min_head_certainty : float
        A frame less certain of which end is the head is excluded from every estimate: 0.5 takes
        all.
    incidence_window_s : float
        The head's displacement over this time before a contact gives θ_h^i; one frame at least.
    max_gap_s : float
        A longer time without a head ends episodes and the angular speed; over a shorter one both
        go on.
    max_bridged_s : float
        Over a time without a head up to this, a fold of the body, the direction along the wall is
        followed: a reversal counts where θ̇_h has another sign after it than before. The body
        takes 10 s to pass a turn (20 mm at 2 mm/s).
    max_lag_s, fine_lag_s : float
        C_θ(t) is computed up to `max_lag_s`: in steps of `fine_step_s` up to `fine_lag_s`, in steps
        of `coarse_step_s` beyond.
    fine_step_s, coarse_step_s : float
        Steps of the lags; the coarse one is a multiple of the fine one.
    stroke_window_s : float
        The body's length over this time before the head turns back gives the phase of the
        peristaltic stroke (half of the paper's T_L = 0.6 s).
    minimum_n : int
        Fewer items than this are not enough data.
    summary_interval_s : float
        Time (of the frames' stamps) between two publications of the estimates.

    Raises
    ------
    BadInput
        Where a value is out of range or two contradict each other.
    """

    contact_factor: float = paper.CONTACT_DISTANCE_WIDTHS
    release_factor: float = paper.CONTACT_DISTANCE_WIDTHS
    body_width_m: float | None = None
    min_episode_s: float = 0.0
    theta_dot_window_s: float = paper.THETA_DOT_WINDOW_S
    mean_window_s: float = paper.UNDULATION_S
    min_head_certainty: float = 0.9
    incidence_window_s: float = 0.1
    max_gap_s: float = 0.5
    max_bridged_s: float = 10.0
    max_lag_s: float = 120.0
    fine_lag_s: float = 10.0
    fine_step_s: float = 0.1
    coarse_step_s: float = 1.0
    stroke_window_s: float = paper.PERISTALSIS_S / 2
    minimum_n: int = 10
    summary_interval_s: float = 10.0

    def __post_init__(self) -> None:
        wrong = limits.first_refusal(self, ANALYSIS_LIMITS, may_lack=("body_width_m",))
        if wrong:
            raise BadInput(wrong)
        if self.release_factor < self.contact_factor:
            raise BadInput(
                f"release_factor {self.release_factor} is below contact_factor "
                f"{self.contact_factor}: the head would let go before it touches"
            )
        steps = self.coarse_step_s / self.fine_step_s
        if abs(steps - round(steps)) > 1e-9 or self.fine_lag_s > self.max_lag_s:
            raise BadInput(
                f"coarse_step_s {self.coarse_step_s} must be a multiple of fine_step_s "
                f"{self.fine_step_s}, and fine_lag_s at most max_lag_s"
            )
        lags = self.fine_lag_s / self.fine_step_s + self.max_lag_s / self.coarse_step_s
        if lags > MOST_LAGS:
            raise BadInput(
                f"max_lag_s, fine_lag_s and their steps make {lags:.0f} lags: give larger steps, "
                f"for {MOST_LAGS} at most"
            )
