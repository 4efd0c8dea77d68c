"""Everything that a user may tell the analysis, with its default."""

from dataclasses import dataclass

from worm_msgs_py import limits, paper
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.declarations import declare, first_refusal_of
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit

_SPAN = Limit(1e-3, 86_400.0, "s")
MOST_LAGS = 100_000
"""Of C_θ: each takes memory and time at every frame."""


@dataclass(frozen=True, slots=True)
class AnalysisParameters:
    """Settings of an `Analysis`.

    Raises
    ------
    BadInput
        Where a value is out of range or two contradict each other.
    """

    contact_factor: float = declare(
        paper.CONTACT_DISTANCE_WIDTHS,
        "The head touches the wall where R − r_h < contact_factor·d_w without noise (paper: 0.3).",
        limits.CONTACT_FACTOR,
    )
    release_factor: float = declare(
        0.0,
        "Of the threshold rules that stand beside: once in contact the head stays so until "
        "R − r_h ≥ release_factor·d_w.",
        limits.CONTACT_FACTOR,
        or_else=0.0,
        means="as contact_factor: no hysteresis, as in the paper",
    )
    body_width_m: float | None = declare(
        None,
        "The worm's width d_w.",
        limits.BODY_WIDTH,
        or_else=0.0,
        means="the running median of the measured widths",
    )
    min_episode_s: float = declare(
        0.0,
        "A contact, or an excursion, shorter than this does not end the episode around it. 0: "
        "every frame counts, as in the paper.",
        Limit(0.0, 600.0, "s"),
    )
    theta_dot_window_s: float = declare(
        paper.THETA_DOT_WINDOW_S,
        "Time Δt over which the angular speed Δθ_h/Δt is taken (paper: 1 s).",
        _SPAN,
    )
    mean_window_s: float = declare(
        paper.UNDULATION_S,
        "v_b and ψ_b are averaged over this time for v_b = v_w sin⟨ψ_b⟩: one undulatory stroke "
        "(the paper's T_T = 12 s), which sways the body.",
        _SPAN,
    )
    min_head_certainty: float = declare(
        SURE_HEAD_CERTAINTY,
        "A frame less certain of which end is the head is excluded from every estimate: 0.5 "
        "takes all.",
        Limit(0.5, 1.0),
    )
    incidence_window_s: float = declare(
        0.1,
        "The head's displacement over this time before a contact gives the angle of incidence; "
        "one frame at least.",
        _SPAN,
    )
    max_gap_s: float = declare(
        0.5,
        "A longer time without a head ends episodes and the angular speed; over a shorter one "
        "both go on.",
        _SPAN,
    )
    # The body takes 10 s to pass a turn: 20 mm at 2 mm/s.
    max_bridged_s: float = declare(
        10.0,
        "Over a time without a head up to this, a fold of the body, the direction along the wall "
        "is followed: a reversal counts where the angular speed has another sign after it.",
        _SPAN,
    )
    max_lag_s: float = declare(120.0, "Longest lag of C_θ(t).", _SPAN)
    fine_lag_s: float = declare(10.0, "Lags of C_θ(t) are fine up to this one.", _SPAN)
    fine_step_s: float = declare(0.1, "Step of the fine lags.", _SPAN)
    coarse_step_s: float = declare(
        1.0, "Step of the lags beyond, a multiple of the fine one.", _SPAN
    )
    stroke_window_s: float = declare(
        paper.PERISTALSIS_S / 2,
        "The body's length over this time before the head turns back gives the phase of the "
        "peristaltic stroke (half of the paper's T_L = 0.6 s).",
        _SPAN,
    )
    minimum_n: int = declare(
        10, "Fewer items than this are not enough data.", Limit(3, 1e6, "items")
    )
    summary_interval_s: float = declare(
        10.0, "Time of the frames' stamps between two publications of the estimates.", _SPAN
    )

    def __post_init__(self) -> None:
        wrong = first_refusal_of(self)
        if wrong:
            raise BadInput(wrong)
        object.__setattr__(self, "release_factor", self.release_factor or self.contact_factor)
        object.__setattr__(self, "body_width_m", self.body_width_m or None)
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
