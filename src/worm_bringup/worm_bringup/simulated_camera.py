"""Node `image_source` of a rig that is simulated: a camera in all but its pictures."""

import sys
import time
from collections.abc import Callable, Iterator
from math import inf

from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import frames
from worm_model.simulator.filming import Filming, film
from worm_model.simulator.rig import FilmedPicture, Optics
from worm_model.simulator.rig.views import one_chamber
from worm_msgs_py.arrays import Floats
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.limits import SEED
from worm_tracker.sources.camera_node import CameraNode
from worm_tracker.sources.source_node import run_source_alone

SIMULATED_PX_PER_MM, EXIT_WIDTH_MM, FRAMES_PER_S = 20.0, 2.0, 30.0
"""One chamber in 512² pixels: filmed while it is tracked, on a machine of two cores."""


class SimulatedCapture:
    """Films a crawling worm in real time; has those of OpenCV's methods that a camera needs.

    A machine that is too slow films fewer pictures of a worm that is as fast.

    Parameters
    ----------
    seed : int
        The same seed gives the same worm.

    Attributes
    ----------
    lost : int
        Frames that were left out because the machine was late by one.
    """

    def __init__(self, seed: int) -> None:
        worm = FilamentParameters()
        rig = FilamentRig(exit_width_mm=EXIT_WIDTH_MM)
        lines = frames(worm, rig, seed=seed, duration_s=inf, frames_per_s=FRAMES_PER_S)
        view = one_chamber(SIMULATED_PX_PER_MM, EXIT_WIDTH_MM, Optics(seed=seed))
        filming = Filming(frames_per_s=FRAMES_PER_S, body_width_mm=worm.width_mm)
        self.lost = 0
        self._film = film(self._in_time(lines), view, filming)
        self._frame = next(self._film)

    def _in_time(self, lines: Iterator[Floats]) -> Iterator[Floats]:
        """Yield each midline when it is due; those that are late by a frame are left out."""
        began_s = time.monotonic()
        for frame, line in enumerate(lines):
            wait_s = began_s + frame / FRAMES_PER_S - time.monotonic()
            if wait_s > -1.0 / FRAMES_PER_S:
                time.sleep(max(wait_s, 0.0))
                yield line
            else:
                self.lost += 1

    def get(self, _property: int) -> float:
        """Return the one property that is asked for: frames a second."""
        return FRAMES_PER_S

    def grab(self) -> bool:
        """Wait for the next picture."""
        self._frame = next(self._film)
        return True

    def retrieve(self) -> tuple[bool, FilmedPicture]:
        """Return the picture that was grabbed."""
        return True, self._frame.picture

    def release(self) -> None:
        """Do nothing: there is no device to let go of."""


class SimulatedCameraNode(CameraNode):
    """As `CameraNode`, of a rig that is simulated."""

    PARAMETERS = (
        *CameraNode.PARAMETERS,
        Declaration("seed", 0, "Of the worm: the same seed gives the same worm.", SEED),
    )

    def capture_instead(self) -> Callable[[], SimulatedCapture]:
        """Return what films."""
        seed = self.read_parameter("seed")
        return lambda: SimulatedCapture(seed)


def main(args: list[str] | None = None) -> int:
    """Run the node alone."""
    return run_source_alone(SimulatedCameraNode, args)


if __name__ == "__main__":
    sys.exit(main())
