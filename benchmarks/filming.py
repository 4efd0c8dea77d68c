"""How many frames a second the simulated rig films, by the processor time of one core.

`python -m benchmarks.filming`

One chamber in 1024 × 1024 pixels, of a crawling filament, as `worm simulate` films it: first with
read noise alone, then with all that the rig has. Writing the bag is not in it.
"""

import argparse
from dataclasses import replace
from statistics import median
from time import process_time

import cv2

from worm_bringup.freed_memory import keep_freed_memory
from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig
from worm_model.filament.trial import simulate
from worm_model.simulator.filming import Filming, film
from worm_model.simulator.rig import Optics
from worm_model.simulator.rig.skins import read_skins
from worm_model.simulator.rig.views import one_chamber

FRAMES_PER_S, PX_PER_MM, EXIT_WIDTH_MM = 30.0, 40.0, 2.0
BLOCK = 30
"""Frames that are timed at once."""
PLAIN = Filming(FRAMES_PER_S, FilamentParameters().width_mm)
ALL = replace(
    PLAIN, exposure_s=0.01, flicker=0.02, debris=20, bubbles=5, glare=3, drift_mm_per_min=(1.0, 0.5)
)
NOISY = Optics(noise=2.0, shot_noise=0.02)
CASES = {
    "read noise": (replace(NOISY, shot_noise=0.0), PLAIN),
    "everything": (NOISY, ALL),
    "everything, 16 bits": (replace(NOISY, bits=16), ALL),
    "everything, a real skin": (NOISY, replace(ALL, skin=read_skins()["w5"])),
}


def main() -> None:
    """Print a row for each way of filming."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blocks", type=int, default=5, help=f"of {BLOCK} frames each")
    blocks = parser.parse_args().blocks
    cv2.setNumThreads(1)
    keep_freed_memory()
    lines = simulate(
        FilamentParameters(),
        FilamentRig(exit_width_mm=EXIT_WIDTH_MM),
        seed=1,
        duration_s=(blocks + 1) * BLOCK / FRAMES_PER_S,
        frames_per_s=FRAMES_PER_S,
    ).midline_mm
    print("| filmed with | ms a frame: median, slowest block | frames/s |\n|---|---|---|")
    for name, (optics, filming) in CASES.items():
        frames = film(lines, one_chamber(PX_PER_MM, EXIT_WIDTH_MM, optics), filming)
        took_ms = []
        for _ in range(blocks + 1):
            begin = process_time()
            for _ in range(BLOCK):
                next(frames)
            took_ms.append(1e3 * (process_time() - begin) / BLOCK)
        middle, slowest = median(took_ms[1:]), max(took_ms[1:])  # the first block compiles
        print(f"| {name} | {middle:.1f}, {slowest:.1f} | {1e3 / middle:.0f} |")


if __name__ == "__main__":
    main()
