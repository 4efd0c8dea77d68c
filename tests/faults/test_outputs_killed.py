"""A process that is killed leaves the whole earlier result or the whole new one, and a way on."""

import subprocess
import sys
from contextlib import suppress

import kill_points
import pytest
from benchmarks.kill_runs import killed_replays
from result_files import result_text

from worm_bringup.outputs.results_directory import results_directory


@pytest.mark.parametrize("way", ["exchange", "renames"])
def test_killed_before_any_change_to_the_disk_a_result_is_the_earlier_or_the_new(tmp_path, way):
    command = [sys.executable, kill_points.__file__, tmp_path, way]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    changes = int(done.stdout)
    seen = set()
    for number in range(changes):
        out = tmp_path / str(number) / "out"
        if way == "exchange":  # otherwise it may be away between the two renames
            seen.add(result_text(out))
        with suppress(InterruptedError), results_directory(out):
            raise InterruptedError  # a run that fails, to set right what is there
        seen.add(result_text(out))
        kill_points.replace_result(out, "next")
        assert result_text(out) == "next"
        for other in {*out.parent.iterdir()} - {out}:
            assert result_text(other) in ("earlier", "new")
            assert not other.name.startswith(".")
    assert seen == {"earlier", "new"}


def test_a_replay_killed_at_any_moment_leaves_a_whole_result_and_its_bag():
    states = [state for _, state in killed_replays(runs=4, seed=1)]
    assert set(states) <= {"earlier", "new"}
    assert len(states) == 4
