"""What the worm does of itself: both strokes, the search of its head, and withdrawals."""

from math import exp, pi, sin
from typing import NamedTuple

from worm_msgs_py.arrays import Floats
from worm_msgs_py.compiled import compiled

PERISTALSIS_RAD, UNDULATION_RAD, HEAD_BEND, HEAD_AIM = range(4)
DRAWN_MM, DRAW_TO_MM, DRAWN_UNTIL_S, TIME_S = range(4, 8)
"""Places in the state of the activity: phases of the strokes at time 0, the curvature at rest that
the head adds (1/mm) and the one that it turns to, by how much the front is drawn back and by how
much it will be, until when, and the time."""
STATE_SIZE = 8
BEND_NOISE, TURN_NOISE, ONSET_NOISE, LENGTH_NOISE = range(4)
"""Places in the noise of a step: a normal, two uniform and an exponential one, of unit size."""
NOISE_SIZE = 4


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
    head_mm, head_bend : float
        Length that the head bends, and the standard deviation of the curvature.
    head_turns_per_s, lost_turns_per_s, head_turn_s : float
        Rates at which it turns to another one, in touch with a wall and out of it, and the time
        that it takes to.
    onset_per_s, withdrawal_s, withdrawal_mm, front_mm, most_drawn_mm : float
        Rate at which a touch ends in a withdrawal, its duration, the mean length by which the front
        of the body shortens then, the length of that front, and by how much it shortens at most.
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
    head_turns_per_s: float
    lost_turns_per_s: float
    head_turn_s: float
    onset_per_s: float
    withdrawal_s: float
    withdrawal_mm: float
    front_mm: float
    most_drawn_mm: float
    touch_mm: float


@compiled
def _decide(state: Floats, noise: Floats, head_gap_mm: float, strokes: Activity) -> None:
    """Let time pass: the head turns or is withdrawn where chance has it."""
    state[TIME_S] += strokes.step_s
    time = state[TIME_S]
    lost = head_gap_mm >= strokes.touch_mm
    turns_per_s = strokes.lost_turns_per_s if lost else strokes.head_turns_per_s
    if noise[TURN_NOISE] < turns_per_s * strokes.step_s:
        state[HEAD_AIM] = strokes.head_bend * noise[BEND_NOISE]
    keep = exp(-strokes.step_s / strokes.head_turn_s)
    state[HEAD_BEND] = state[HEAD_AIM] + keep * (state[HEAD_BEND] - state[HEAD_AIM])
    ready = not lost and time >= state[DRAWN_UNTIL_S]
    if ready and noise[ONSET_NOISE] < strokes.onset_per_s * strokes.step_s:
        state[DRAWN_UNTIL_S] = time + strokes.withdrawal_s
        drawn_mm = strokes.withdrawal_mm * noise[LENGTH_NOISE]
        state[DRAW_TO_MM] = min(drawn_mm, strokes.most_drawn_mm)
        state[HEAD_AIM] = strokes.head_bend * noise[BEND_NOISE]
    if time >= state[DRAWN_UNTIL_S]:
        state[DRAW_TO_MM] = 0.0
    keep = exp(-2.0 * strokes.step_s / strokes.withdrawal_s)
    state[DRAWN_MM] = state[DRAW_TO_MM] + keep * (state[DRAWN_MM] - state[DRAW_TO_MM])


@compiled
def act(
    state: Floats,
    noise: Floats,
    head_gap_mm: float,
    s_mm: Floats,
    strokes: Activity,
    curvature: Floats,
    rest: Floats,
) -> None:
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
    rest : ndarray, shape (n - 1,)
        Filled with the lengths of the segments at rest, mm.
    """
    _decide(state, noise, head_gap_mm, strokes)
    time = state[TIME_S]
    turn = 2.0 * pi
    for i in range(len(s_mm)):
        phase = turn * (time / strokes.wave_s - s_mm[i] / strokes.wave_mm)
        curvature[i] = strokes.wave * sin(phase + state[UNDULATION_RAD])
        if s_mm[i] < strokes.head_mm:
            curvature[i] += state[HEAD_BEND]
    stretch = 1.0 + strokes.stretch * sin(turn * time / strokes.stretch_s + state[PERISTALSIS_RAD])
    for i in range(len(s_mm) - 1):
        before_end = 1.0 - 0.5 * (s_mm[i] + s_mm[i + 1]) / strokes.front_mm
        drawn = 2.0 * state[DRAWN_MM] / strokes.front_mm * max(before_end, 0.0)
        rest[i] = (s_mm[i + 1] - s_mm[i]) * (stretch - drawn)
