"""How the worm that follows the wall moves: the constants of its head and of its body's chain."""

from dataclasses import dataclass
from math import radians


@dataclass(frozen=True, slots=True)
class GaitSettings:
    """What a `Walker` does not say; chosen so that films look like the paper's worm.

    Attributes
    ----------
    clearance_mm : float
        The worm keeps so far off all walls.
    deepest_hop_radii : float
        The deepest excursion: the head does not cross the middle.
    slowest_psi_b_rad : float
        The head never goes slower than with such a ψ_b: it does not stand still.
    mean_psi_b_s : float
        Time over which ψ_b is averaged: v_b = v_w sin⟨ψ_b⟩ is a law of means.
    turn_rad_s : float
        How fast the head swings round, where it turns back and where it turns into the exit.
    psi_b_rad : float
        About ψ_b of its way along the wall: to there a worm that turns back swings its body.
    lean_rad, lean_sd_rad, lean_s : float
        Angle ψ_h between the wall's normal and the head, while it moves along the wall: mean,
        standard deviation and the time in which it changes.
    lean_within_rad : (float, float)
        Smallest and largest such angle.
    links : int
        Of the body's chain.
    largest_step_s : float
        Time step at most.
    settles_s : float
        Time before the first frame, in which the body finds its shape.
    sharpest_bend_rad : float
        Between two links; with links of half a millimetre a bend's radius stays above 1.4 mm.
    largest_pace_mm_s : float
        Of a link: where a push from the head would flip one over, the body gives way in time.
    swing_rad_s : float
        How fast the body swings round where the worm turns back.
    inward_s, inner_radius_radii : float
        Time in which the body drifts away from the wall, and the radius that its rear drifts to.
    rear_mm : float
        Length of the body over which that place of the rear is come to.
    """

    clearance_mm: float = 0.02
    deepest_hop_radii: float = 0.8
    slowest_psi_b_rad: float = radians(5.0)
    mean_psi_b_s: float = 6.0
    turn_rad_s: float = 1.0
    psi_b_rad: float = radians(28.0)
    lean_rad: float = radians(38.0)
    lean_sd_rad: float = radians(5.0)
    lean_s: float = 2.0
    lean_within_rad: tuple[float, float] = (radians(28.0), radians(55.0))
    links: int = 40
    largest_step_s: float = 0.02
    settles_s: float = 8.0
    sharpest_bend_rad: float = radians(20.0)
    largest_pace_mm_s: float = 12.0
    swing_rad_s: float = 0.5
    inward_s: float = 3.0
    inner_radius_radii: float = 0.55
    rear_mm: float = 5.0


GAIT = GaitSettings()
