"""The look of two real *Lumbriculus*, to be laid along a simulated worm's midline."""

from pathlib import Path

import numpy as np

from worm_model.simulator.rig.strands import Skin
from worm_msgs_py.units import UM_PER_MM

SKINS_FILE = Path(__file__).with_name("lumbriculus_skins.npz")
"""Made by ``bags/build.py`` from a photograph; its source and licence stand in bags/README.md."""
TRANSMISSION_STEPS = 200.0


def read_skins(path: Path = SKINS_FILE) -> dict[str, Skin]:
    """Read real skins, by name: `w4` with a pale tail, and `w5`."""
    with np.load(path) as data:
        names = sorted(key.removeprefix("width_um_") for key in data if key.startswith("width"))
        return {
            name: Skin(
                transmission=data[f"transmission_{name}"] / TRANSMISSION_STEPS,
                first_s_mm=float(data[f"first_s_mm_{name}"]),
                per_mm=float(data["per_mm"]),
                length_mm=float(data[f"length_mm_{name}"]),
                width_mm=data[f"width_um_{name}"] / UM_PER_MM,
            )
            for name in names
        }
