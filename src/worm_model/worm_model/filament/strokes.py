"""What the worm does of itself: both strokes, the search of its head, and withdrawals."""

from math import exp, pi, sin, sqrt
from typing import NamedTuple

from worm_model.filament.compiled import compiled
from worm_msgs_py.arrays import Floats

PERISTALSIS_RAD, UNDULATION_RAD, HEAD_BEND, WITHDRAWN_UNTIL_S, TIME_S = range(5)
"""Places in the state of the activity: phases of the strokes at time 0, the curvature at rest that
the head adds (1/mm), the end of the last withdrawal, the time."""
STATE_SIZE = 5
BEND_NOISE, ONSET_NOISE, LENGTH_NOISE = range(3)
"""Places in the noise of a step: normal, uniform and exponential, of unit size."""
NOISE_SIZE = 3


class Activity(NamedTuple):
    """The strokes as the compiled loops take them: `FilamentParameters` has the meanings.

    Attributes
    ----------
    step_s : float
        Time step.
    speed : float
        Propulsion over the drag, mm/s.
    stretch, stretch_s : float
        Amplitude of the length over the mean length, and period.
    wave, wave_s, wave_mm : float
        Amplitude of the curvature at rest, 1/mm, period and length of the wave.
    head_mm, head_bend, head_bend_s : float
        Length that the head bends, standard deviation of the curvature, correlation time.
    onset_per_s, withdrawal_s : float
        Rate at which a touch ends in a withdrawal, and the mean duration of one.
    touch_mm : float
        Distance from the wall that is a touch.
    """

    step_s: float
    speed: float
    stretch: float
    stretch_s: float
    wave: float
    wave_s: float
    wave_mm: float
    head_mm: float
    head_bend: float
    head_bend_s: float
    onset_per_s: float
    withdrawal_s: float
    touch_mm: float


@compiled
def act(
    state: Floats,
    noise: Floats,
    head_gap_mm: float,
    s_mm: Floats,
    strokes: Activity,
    curvature: Floats,
) -> tuple[float, float]:
    """Move the activity on by a step.

    Parameters
    ----------
    state : ndarray, shape (STATE_SIZE,)
        Of the activity; changed in place.
    noise : ndarray, shape (NOISE_SIZE,)
        Of this step.
    head_gap_mm : float
        Distance of the head tip from the wall.
    s_mm : ndarray, shape (n,)
        Arc length of the points from the head tip.
    strokes : Activity
        The strokes.
    curvature : ndarray, shape (n,)
        Filled with the curvature at rest, 1/mm.

    Returns
    -------
    drive_mm_s : float
        Propulsion towards the head.
    stretch : float
        Length at rest over its mean.
    """
    state[TIME_S] += strokes.step_s
    time = state[TIME_S]
    keep = exp(-strokes.step_s / strokes.head_bend_s)
    state[HEAD_BEND] *= keep
    state[HEAD_BEND] += strokes.head_bend * sqrt(1.0 - keep * keep) * noise[BEND_NOISE]
    touching = head_gap_mm < strokes.touch_mm and time >= state[WITHDRAWN_UNTIL_S]
    if touching and noise[ONSET_NOISE] < strokes.onset_per_s * strokes.step_s:
        state[WITHDRAWN_UNTIL_S] = time + strokes.withdrawal_s * noise[LENGTH_NOISE]
    turn = 2.0 * pi
    for i in range(len(s_mm)):
        phase = turn * (time / strokes.wave_s - s_mm[i] / strokes.wave_mm)
        curvature[i] = strokes.wave * sin(phase + state[UNDULATION_RAD])
        if s_mm[i] < strokes.head_mm:
            curvature[i] += state[HEAD_BEND]
    stretch = 1.0 + strokes.stretch * sin(turn * time / strokes.stretch_s + state[PERISTALSIS_RAD])
    return (-strokes.speed if time < state[WITHDRAWN_UNTIL_S] else strokes.speed), stretch
