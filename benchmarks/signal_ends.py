"""How long `worm live` takes to end after each signal, at moments from its start into its trial.

`python -m benchmarks.signal_ends`: the simulated rig, recorded, and a camera that accepts and never
answers. The bar is two seconds. In a trial it is held against the results, which are in place
before their report is drawn: after Ctrl-C that takes its time, and a second one leaves it out.
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


def ended_after(
    camera: str, number: int, at_s: float, *, twice: bool
) -> tuple[float, float, int, str]:
    """Return the seconds from the (last) signal to whole results, and to the end; what is there.

    Without results the former are those to the end.
    """
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
            in_place_s = None
            while process.poll() is None:
                time.sleep(0.01)
                if in_place_s is None and (Path(folder) / "out").exists():
                    in_place_s = time.monotonic() - began_s
            took_s = time.monotonic() - began_s
        there = [item.name for item in Path(folder).iterdir() if item.is_dir()]
        report = "report" if (Path(folder) / "out" / "report.html").exists() else ""
        whole_s = took_s if in_place_s is None else in_place_s
        return whole_s, took_s, process.returncode, " ".join(sorted([*there, report])).strip()


def main() -> None:
    """Send them, and print how long it took."""
    numbers = cycle((signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}/"
        for camera in ("sim", address):
            for at_s in AT_S:
                for twice in (False, True):
                    number = next(numbers)
                    whole_s, took_s, status, there = ended_after(camera, number, at_s, twice=twice)
                    what = camera if camera == "sim" else "no answer"
                    name = number.name + (" and SIGINT" if twice else "")
                    late = "" if whole_s <= BAR_S else "  LATE"
                    print(
                        f"{what:9} {at_s:4.1f} s {name:20} whole {whole_s:5.2f} s, "
                        f"ended {took_s:5.2f} s, {status}, {there}{late}"
                    )


if __name__ == "__main__":
    main()
