"""Takes folded poses back whose length no stroke explains: an end was told on another strand."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from statistics import median

from worm_msgs_py.contract.body import BodyState, TrackedFrame
from worm_msgs_py.contract.status import Status
from worm_tracker.waiting.frame_state import taken_back


@dataclass(frozen=True, slots=True)
class SuddenLengthSettings:
    """How much a body may have stretched or contracted within a moment."""

    moment_s: float = 0.5
    most_log_length: float = 0.12
    """How far the length of a folded body may be from the median of those told a moment before:
    of 16 000 right ones in 76 films of worms with strokes 5 were farther off, and all five midlines
    of a real worm whose tail had been lost beneath another strand."""
    least_lengths: int = 4
    """Fewer tell nothing."""


class SuddenLengths:
    """Takes frames in their order and gives each, its pose taken back where its length is sudden.

    An open body is never asked: its contour shows both ends, and a startled worm contracts by a
    fifth in a twentieth of a second.

    Parameters
    ----------
    settings : SuddenLengthSettings
    """

    def __init__(self, settings: SuddenLengthSettings) -> None:
        self._settings = settings
        self._told: deque[tuple[int, float]] = deque()

    def push(self, frames: Sequence[TrackedFrame]) -> list[TrackedFrame]:
        """Return the next frames."""
        return [taken_back(frame) if self._is_sudden(frame.state) else frame for frame in frames]

    def _is_sudden(self, state: BodyState) -> bool:
        """Tell whether a pose is so, and remember its length where it is not."""
        settings, told = self._settings, self._told
        if not state.length_px > 0:  # NaN where an end is hidden
            return False
        while told and state.stamp_ns - told[0][0] > 1e9 * settings.moment_s:
            told.popleft()
        lengths = [length for _, length in told]
        if state.status is Status.FOLDED and len(lengths) >= settings.least_lengths:
            is_sudden = abs(log(state.length_px / median(lengths))) > settings.most_log_length
        else:
            is_sudden = False
        if not is_sudden:
            told.append((state.stamp_ns, state.length_px))
        return is_sudden
