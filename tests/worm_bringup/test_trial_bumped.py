"""A trial whose camera is bumped says so in its summary, and until when the old rig held."""

import json

import pytest
from forked_commands import worm

from worm_model.simulator.film import write_film
from worm_model.simulator.scenes import Take, bumped, bumped_camera


def test_a_summary_tells_each_geometry_and_from_when_it_held(tmp_path):
    take = Take(px_per_mm=16.0, frames=24)
    write_film(tmp_path / "film", bumped_camera(take))
    worm("replay", "film", "--out", "out", cwd=tmp_path).check_returncode()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    (earlier,) = summary["earlier_geometries"]
    assert (earlier["version"], earlier["stamp_ns"]) == (1, 0)
    before, after = take.chamber.chambers[0], bumped(take.chamber).chambers[0]
    for found, true in ((earlier, before), (summary["geometry"], after)):
        chamber = found["chamber_a"]
        assert chamber["centre_u_px"] == pytest.approx(true.centre_u_px, abs=0.15)
        assert chamber["centre_v_px"] == pytest.approx(true.centre_v_px, abs=0.15)
        assert 0.0 < chamber["exit_width_sd_mm"] < 0.05
