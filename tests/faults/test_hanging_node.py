"""A node that hangs is noticed, named and ended; the others end in order, what is done is kept."""

from pathlib import Path

import pytest
from mjpeg_server import mjpeg_server
from picture_bags import write_bag

from worm_bringup.graph.in_process import run_in_process
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import run_in_processes
from worm_msgs_py.errors import NodeFailed
from worm_msgs_py.ros.watchdog import watchdog
from worm_tracker.sources.bags.bag_reader import BagPictures

WAYS = [
    pytest.param(run_in_process, id="one process"),
    pytest.param(run_in_processes, id="a process each"),
]
HANGS = ["asleep", "busy", "locked"]
TRACKER = "hanging_tracker_node"


@pytest.fixture(autouse=True)
def stand_ins_can_be_imported(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1] / "support"))


@pytest.mark.parametrize("run", WAYS)
@pytest.mark.parametrize("way", HANGS)
def test_a_node_that_hangs_is_named_and_ended(tmp_path, run, way, capfd):
    bag = write_bag(tmp_path / "bag", 10)
    source = NodeSpec("worm_tracker.sources.replay_node", "image_source", {"bag": bag})
    patience_s = 0.3 if run is run_in_process else 3.0  # children tell once a second
    with pytest.raises(NodeFailed, match="node tracker hangs"):
        run(source, [NodeSpec(TRACKER, "tracker", {"way": way})], patience_s=patience_s)
    assert "in on_picture" in capfd.readouterr().err  # its traceback


@pytest.mark.parametrize("run", WAYS)
def test_the_record_of_a_live_trial_is_whole_where_a_node_hangs(tmp_path, run):
    with mjpeg_server(None, pause_s=0.005) as address:
        source = NodeSpec(
            "worm_tracker.sources.camera_node",
            "image_source",
            {"camera": address, "record": tmp_path / "record"},
        )
        with pytest.raises(NodeFailed, match="node tracker hangs"):
            run(source, [NodeSpec(TRACKER, "tracker", {"way": "locked"})], patience_s=3.0)
    with BagPictures(tmp_path / "record") as bag:
        assert len(list(bag)) == 3


def test_what_comes_back_in_time_is_left_alone():
    with watchdog(patience_s=30.0) as watch:
        for _ in range(1000):
            watch.enter("tracker")
            watch.leave()
