"""The numbers that the paper gives, in the units in which people read them (docs/science.md)."""

from math import nan

PAPER = {
    "d_c": 1.95,
    "d_nc": 1.46,
    "delta_r_h": 1.14,
    "t_per": 27.0,
    "v_w": 2.02,
    "r_h_over_R": 1.0,
    "r_c_over_R": 0.6,
    "psi_b_negative_peak": -34.0,
    "psi_b_positive_peak": 30.0,
    "success": 0.60,
    "l_w": 20.0,
    "d_w": 0.1,
}
"""The paper's values that hold for every W, in the units of people."""

PAPER_BY_EXIT_MM = {
    "beta": {0.5: 0.60, 1.0: 0.50, 3.0: 0.42, 5.0: 0.36},
    "failures_in_elongation": {0.5: 0.93, 1.0: 0.87, 3.0: 0.53},
    "failures_touching_in_elongation": {0.5: 0.93, 1.0: 0.87, 3.0: 0.53},
    "failures_without_contact": {0.5: 0.02, 3.0: 0.20},
}
"""Those that it gives for a W."""

SAME_EXIT = 0.15
"""An exit within this fraction of one of the paper's is taken for the same."""


def paper_value(name: str, exit_width_m: float = nan) -> float | None:
    """Return the paper's value of a quantity; None where it gives none.

    Parameters
    ----------
    name : str
        As in the summary.
    exit_width_m : float
        W, for what depends on it: the value is that of the same W, if the paper has it.
    """
    if name in PAPER:
        return PAPER[name]
    for width_mm, value in PAPER_BY_EXIT_MM.get(name, {}).items():
        if abs(exit_width_m * 1e3 - width_mm) < SAME_EXIT * width_mm:
            return value
    return None
