"""Every number that the paper gives, once: Biswas & Kudrolli, arXiv 2303.00647 (docs/science.md).

In the units in which people read them: mm, s, degrees. An interval is value, low and high.
"""

from math import inf, nan

# The rig and the worm: section on the experiment, Fig. 1a.
RADIUS_MM, DEPTH_MM, PASSAGE_LENGTH_MM = 10.0, 1.5, 35.0
"""R, h and L."""
EXIT_WIDTHS_MM = (0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
"""W."""
TRIAL_S = 1800.0
"""A trial is 30 min; n_s is counted in this time (Fig. 6b)."""
LENGTH_MM, WIDTH_MM = 20.0, 0.1
"""l_w and d_w."""
PERISTALSIS_S, UNDULATION_S = 0.6, 12.0
"""Periods T_L and T_T of the two strokes."""

# What is measured along the wall: sections on Figs 2 to 4 and 7.
CONTACT_DISTANCE_WIDTHS = 0.3
"""The head touches the wall where R − r_h < 0.3 d_w (section on Fig. 3)."""
THETA_DOT_WINDOW_S = 1.0
"""Δt of θ̇_h = Δθ_h/Δt (section on Fig. 4)."""
SLIDE_MM, HOP_MM, EXCURSION_MM = 1.95, 1.46, 1.14
"""⟨d_c⟩, ⟨d_nc⟩ and ⟨Δr_h⟩ (Fig. 3)."""
SPEED_MM_S = 2.02
"""v_w (Fig. 4c)."""
BODY_ANGLE_DEG = 32.0
"""The mean of both peaks of |ψ_b| (Fig. 1e)."""
T_PER_S = (27.0, 26.5, 27.5)
"""Fig. 7a. The paper gives no interval: half of the last digit."""
ROUND_S = 40.0
"""One round along the wall, as the text estimates it at v_w = 3 mm/s and ψ_b = 32°."""

# The search and the escape: sections on Figs 5, 6 and 8.
REVERSAL = (0.30, 0.25, 0.35)
"""Text: "approximately 30% of the times"; the interval is what rounds to it."""
REVERSAL_OF_FIG_6 = (0.45, 0.35, 0.55)
"""Caption of Fig. 6, with its shaded region; taken for reversals per slide and hop."""
WALK_SLIDE_MM, WALK_HOP_MM = 1.96, 1.47
"""⟨d_c⟩ and ⟨d_nc⟩ of the simulated walk: caption of Fig. 6."""
TAU_H_OF_THE_TEXT_S = (nan, ROUND_S, inf)
"""Text: longer than the time in which the worm moves once around the chamber."""
SUCCESS = 0.60
"""Of the head's entries, for every W (Fig. 8)."""
ESCAPE_RATIO = (nan, 1.0 / SUCCESS, 2.0)
"""Text: "nearly twice as long as compared to ⟨τ_h⟩"; 1/0.6 if every search took as long."""

_VALUES = {
    "r_h_over_R": 1.0,  # Fig. 1d
    "r_c_over_R": 0.6,
    "psi_b_negative_peak": -34.0,  # Fig. 1e
    "psi_b_positive_peak": 30.0,
    "d_c": SLIDE_MM,
    "d_nc": HOP_MM,
    "delta_r_h": EXCURSION_MM,
    "v_w": SPEED_MM_S,
    "t_per": T_PER_S[0],
    "success": SUCCESS,
    "l_w": LENGTH_MM,
    "d_w": WIDTH_MM,
}
"""Quantities of the summary that hold for every W."""

_BY_EXIT_MM = {
    "beta": {0.5: 0.60, 1.0: 0.50, 3.0: 0.42, 5.0: 0.36},  # Fig. 9
    "failures_in_elongation": {0.5: 0.93, 1.0: 0.87, 3.0: 0.53},  # section on Fig. 9
    "failures_touching_in_elongation": {0.5: 0.93, 1.0: 0.87, 3.0: 0.53},
    "failures_without_contact": {0.5: 0.02, 3.0: 0.20},
}
"""Those that the paper gives for a W."""

SAME_WIDTH = 0.08
"""A calibration gives W to a pixel: widths that differ by less than this part are of one exit."""


def paper_value(name: str, exit_width_mm: float = nan) -> float | None:
    """Return the paper's value of a quantity; None where it gives none.

    Parameters
    ----------
    name : str
        As in the summary.
    exit_width_mm : float
        W, for what depends on it: the value is that of the same W, if the paper has it.
    """
    if name in _VALUES:
        return _VALUES[name]
    for width_mm, value in _BY_EXIT_MM.get(name, {}).items():
        if abs(exit_width_mm - width_mm) < SAME_WIDTH * width_mm:
            return value
    return None


def paper_number(name: str) -> float:
    """Return a number that the paper gives for every W; KeyError where it does not."""
    return _VALUES[name]
