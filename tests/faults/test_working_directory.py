"""Nothing that lies in the working directory is imported by the command or by its processes."""

import subprocess
import sys
from pathlib import Path

import pytest
from picture_bags import write_bag

WORM = Path(sys.executable).with_name("worm")


@pytest.mark.parametrize("how", [[], ["--processes"]], ids=["one process", "a process each"])
def test_modules_in_the_working_directory_are_not_imported(tmp_path, how):
    bag = write_bag(tmp_path / "bag", 5)
    for name in ("worm_bringup", "worm_msgs_py", "json", "numpy", "rclpy", "sitecustomize"):
        (tmp_path / f"{name}.py").write_text("open('imported', 'w').close(); raise SystemExit(3)")
    done = subprocess.run(
        [WORM, "replay", "bag", "--no-chamber", "--out", "out", *how],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    assert "not one of 5 frames has a pose" in done.stderr
    assert (tmp_path / "out" / "summary.json").exists()
    assert not (tmp_path / "imported").exists()
    assert bag.exists()
