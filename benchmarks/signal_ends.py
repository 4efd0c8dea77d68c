"""How long `worm live` takes to end after each signal, at moments from its start into its trial.

`python -m benchmarks.signal_ends`: the simulated rig, recorded, and a camera that accepts and never
answers. The bar is two seconds. After the trial has begun a signal ends it with its report, which
takes as long as it takes; a second one leaves the report out.
"""

import signal
import socket
import subprocess
import sys
import tempfile
import time
from itertools import cycle
from pathlib import Path

WORM = [sys.executable, "-c", "from worm_bringup.cli import main; main()"]
BAR_S = 2.0
AT_S = (0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0)


def ended_after(camera: str, number: int, at_s: float, *, twice: bool) -> tuple[float, int, str]:
    """Return the seconds from the (last) signal to the end, the status, and what is there."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["live", "--camera", camera, "--private", "--out", "out", "--record", "record"]
        with subprocess.Popen(
            [*WORM, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            time.sleep(at_s)
            process.send_signal(number)
            if twice:
                time.sleep(1.0)
                process.send_signal(signal.SIGINT)
            began_s = time.monotonic()
            status = process.wait()
            took_s = time.monotonic() - began_s
        there = [item.name for item in Path(folder).iterdir() if item.is_dir()]
        report = "report" if (Path(folder) / "out" / "report.html").exists() else ""
        return took_s, status, " ".join(sorted([*there, report])).strip()


def main() -> None:
    """Send them, and print how long it took."""
    numbers = cycle((signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}/"
        for camera in ("sim", address):
            for at_s in AT_S:
                for twice in (False, True):
                    number = next(numbers)
                    took_s, status, there = ended_after(camera, number, at_s, twice=twice)
                    what = camera if camera == "sim" else "no answer"
                    name = number.name + (" and SIGINT" if twice else "")
                    late = "" if took_s <= BAR_S else "  LATE"
                    print(
                        f"{what:9} {at_s:4.1f} s {name:20} {took_s:5.2f} s, {status}, {there}{late}"
                    )


if __name__ == "__main__":
    main()
