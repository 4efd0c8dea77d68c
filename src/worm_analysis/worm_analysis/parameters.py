"""Everything that a user may tell the analysis, with its default."""

from dataclasses import dataclass
from math import isfinite


@dataclass(frozen=True, slots=True)
class AnalysisParameters:
    """Settings of an `Analysis`.

    Attributes
    ----------
    contact_factor : float
        The head touches the wall where R − r_h < contact_factor·d_w (paper: 0.3).
    release_factor : float
        Once in contact it stays so until R − r_h ≥ release_factor·d_w. Equal to `contact_factor`:
        no hysteresis, as in the paper.
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
        A frame less certain of which end is the head than this counts for nothing: 0.5 takes all.
    incidence_window_s : float
        The head's displacement over this time before a contact gives θ_h^i; one frame at least.
    max_gap_s : float
        A longer time without a head ends episodes and pairs of C_θ; a shorter one is bridged.
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
    ValueError
        Where a value is out of range or two contradict each other.
    """

    contact_factor: float = 0.3
    release_factor: float = 0.3
    body_width_m: float | None = None
    min_episode_s: float = 0.0
    theta_dot_window_s: float = 1.0
    mean_window_s: float = 12.0
    min_head_certainty: float = 0.9
    incidence_window_s: float = 0.1
    max_gap_s: float = 0.5
    max_lag_s: float = 120.0
    fine_lag_s: float = 10.0
    fine_step_s: float = 0.1
    coarse_step_s: float = 1.0
    stroke_window_s: float = 0.3
    minimum_n: int = 10
    summary_interval_s: float = 10.0

    def __post_init__(self) -> None:
        positive = (
            "contact_factor",
            "theta_dot_window_s",
            "mean_window_s",
            "incidence_window_s",
            "max_gap_s",
            "max_lag_s",
            "fine_step_s",
            "coarse_step_s",
            "stroke_window_s",
            "summary_interval_s",
        )
        for name in positive:
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ValueError(f"{name} is {value}: give a number above 0")
        if self.body_width_m is not None and not 0 < self.body_width_m < 0.01:
            raise ValueError(
                f"body_width_m is {self.body_width_m}: give metres, such as 0.0004, or nothing"
            )
        if not 0.5 <= self.min_head_certainty <= 1:
            raise ValueError(
                f"min_head_certainty is {self.min_head_certainty}: give a probability from 0.5 to 1"
            )
        if self.release_factor < self.contact_factor:
            raise ValueError(
                f"release_factor {self.release_factor} is below contact_factor "
                f"{self.contact_factor}: the head would let go before it touches"
            )
        if self.min_episode_s < 0 or self.minimum_n < 3:
            raise ValueError("min_episode_s must be 0 or more, minimum_n 3 or more")
        steps = self.coarse_step_s / self.fine_step_s
        if abs(steps - round(steps)) > 1e-9 or self.fine_lag_s > self.max_lag_s:
            raise ValueError(
                f"coarse_step_s {self.coarse_step_s} must be a multiple of fine_step_s "
                f"{self.fine_step_s}, and fine_lag_s at most max_lag_s"
            )
