"""Not a frame is lost, whatever the speed of the tracker and however the nodes are spread."""

import os
import signal
import subprocess
import sys
import threading
import zlib
from pathlib import Path

import pytest
from picture_bags import compressed, numbered_picture, stamps, storage_file, write_bag

from worm_bringup.graph import supervisor as processes
from worm_bringup.graph.in_process import run_in_process
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import run_in_processes
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_repair import repair_bag

WAYS = [
    pytest.param(run_in_process, id="one process"),
    pytest.param(run_in_processes, id="a process each"),
]


@pytest.fixture(autouse=True)
def stand_ins_can_be_imported(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2] / "support"))


def graph(bag, out, source=None, **tracker):
    """A source, a stand-in for the tracker, and a recorder of checksums."""
    return (
        NodeSpec(
            "worm_tracker.sources.replay_node", "image_source", {"bag": bag, **(source or {})}
        ),
        [
            NodeSpec("standin_tracker_node", "tracker", tracker),
            NodeSpec("standin_recorder_node", "recorder", {"out": out}),
        ],
    )


def truth(count, shape=(48, 64)):
    """What a recorder writes that has seen every picture, whole and in order."""
    return "\n".join(
        f"{frame} {stamp} {zlib.crc32(numbered_picture(frame, shape).tobytes())}"
        for frame, stamp in enumerate(stamps(count))
    )


@pytest.fixture
def shared_memory_left(monkeypatch):
    """A function that lists what is left of the shared memory which the processes of a run used.

    Other graphs of this machine come and go meanwhile, and share the ports with ours.
    """
    used = set()
    tidy = processes._tidy_shared_memory

    def spy(segments):
        used.update(segments)
        tidy(segments)

    monkeypatch.setattr(processes, "_tidy_shared_memory", spy)

    def left():
        own = [Path(segment) for segment in used if "port" not in segment]
        assert own, "no shared memory was used"
        return [
            file.name
            for segment in own
            for file in (segment, segment.with_name(segment.name + "_el"))
            if file.exists()
        ]

    return left


@pytest.mark.parametrize("run", WAYS)
@pytest.mark.parametrize(
    ("delay_s", "hold"),
    [pytest.param(0.0, 40, id="holds back"), pytest.param(0.02, 0, id="a tenth of the speed")],
)
def test_every_frame_arrives_once_in_order_and_intact(tmp_path, run, delay_s, hold):
    bag = write_bag(tmp_path / "bag", 100)
    seen = []
    result = run(
        *graph(bag, tmp_path / "out", delay_s=delay_s, hold=hold),
        lambda sent, expected: seen.append((sent, expected)),
    )
    assert result.complete
    assert not result.interrupted
    assert result.missing == ""
    assert result.frames == 100
    assert (tmp_path / "out").read_text() == truth(100)
    assert seen[-1] == (100, 100)
    assert seen == sorted(seen)


@pytest.mark.parametrize("run", WAYS)
def test_a_burst_of_held_frames_is_not_lost(tmp_path, run):
    bag = write_bag(tmp_path / "bag", 300, shape=(8, 8))
    assert run(*graph(bag, tmp_path / "out", hold=256)).complete
    assert (tmp_path / "out").read_text() == truth(300, (8, 8))


def test_pictures_of_a_megabyte_pass_between_processes(tmp_path):
    bag = write_bag(tmp_path / "bag", 40, shape=(1024, 1024))
    assert run_in_processes(*graph(bag, tmp_path / "out", delay_s=0.01)).complete
    assert (tmp_path / "out").read_text() == truth(40, (1024, 1024))


def test_compressed_pictures_take_the_same_way(tmp_path):
    bag = write_bag(tmp_path / "bag", 30, make=compressed)
    assert run_in_process(*graph(bag, tmp_path / "out")).complete
    assert (tmp_path / "out").read_text() == truth(30)


def test_the_rate_changes_no_result(tmp_path):
    bag = write_bag(tmp_path / "bag", 10)
    assert run_in_process(*graph(bag, tmp_path / "out", {"rate": 20.0})).complete
    assert (tmp_path / "out").read_text() == truth(10)


def test_time_is_told_by_node(tmp_path):
    bag = write_bag(tmp_path / "bag", 20)
    result = run_in_process(*graph(bag, tmp_path / "out", delay_s=0.002))
    assert set(result.spent_s) == {"image_source", "tracker", "recorder"}
    assert result.spent_s["tracker"] >= 20 * 0.002
    assert sum(result.spent_s.values()) <= result.elapsed_s * 1.5


@pytest.mark.parametrize("run", WAYS)
def test_a_node_that_refuses_its_input_ends_the_run_with_its_line(
    tmp_path, run, shared_memory_left
):
    bag = write_bag(tmp_path / "bag", 30)
    with pytest.raises(BadInput, match=r"^frame 3: no chamber is found; try --no-chamber$"):
        run(*graph(bag, tmp_path / "out", fail_at=3))
    assert not (tmp_path / "out").exists()
    assert run is run_in_process or not shared_memory_left()


@pytest.mark.parametrize("run", WAYS)
def test_a_bad_bag_ends_the_run_with_its_line(tmp_path, run):
    with pytest.raises(BadInput, match="no such bag") as caught:
        run(*graph(tmp_path / "nowhere", tmp_path / "out"))
    assert "\n" not in str(caught.value)


def test_damage_in_the_middle_is_not_the_end(tmp_path):
    with_checksums = tmp_path / "checked.mcap"
    repair_bag(storage_file(write_bag(tmp_path / "bag", 600)), with_checksums)
    data = bytearray(with_checksums.read_bytes())
    data[len(data) * 3 // 4] ^= 1
    with_checksums.write_bytes(data)
    seen = []
    with pytest.raises(BadInput, match=r"damaged.*checksum.*worm repair"):
        run_in_process(*graph(with_checksums, tmp_path / "out"), lambda *sent: seen.append(sent))
    assert 0 < seen[-1][0] < 600
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("source", "line"),
    [
        ({"rat": 1.0}, r"node image_source has no parameter 'rat': did you mean 'rate'"),
        ({"rate": "fast"}, r"node image_source: .*rate"),
        ({"rate": -1.0}, r"node image_source: rate is -1"),
        ({"rate": float("nan")}, r"node image_source: rate is nan"),
    ],
)
def test_a_wrong_parameter_is_named(tmp_path, source, line):
    bag = write_bag(tmp_path / "bag", 3)
    with pytest.raises(BadInput, match=line):
        run_in_process(*graph(bag, tmp_path / "out", source))


def test_what_is_missing_is_said(tmp_path):
    bag = write_bag(tmp_path / "bag", 5)
    source, nodes = graph(bag, tmp_path / "out")
    result = run_in_process(source, nodes[1:])
    assert not result.complete
    assert result.missing == "0 of 5 frames are recorded"


def signal_after(frames, number):
    """Return a progress function that signals this process once, and what it was signalled at."""
    signalled = []

    def progress(sent, expected):
        if sent > frames and not signalled:
            signalled.append(sent)
            os.kill(os.getpid(), number)

    return progress


@pytest.mark.parametrize("run", WAYS)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_replay_incomplete(tmp_path, run, number, shared_memory_left):
    bag = write_bag(tmp_path / "bag", 2000)
    before = signal.getsignal(number)
    progress = signal_after(25, number)
    result = run(*graph(bag, tmp_path / "out", delay_s=0.001), progress)
    assert result.interrupted
    assert not result.complete
    assert 25 < result.frames < 2000
    assert signal.getsignal(number) is before
    assert run is run_in_process or not shared_memory_left()
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("run", WAYS)
def test_a_signal_ends_a_loop_whole(tmp_path, run):
    bag = write_bag(tmp_path / "bag", 10)
    progress = signal_after(25, signal.SIGINT)
    result = run(*graph(bag, tmp_path / "out", {"loop": True}, delay_s=0.001), progress)
    assert result.complete
    assert result.frames > 25
    assert len((tmp_path / "out").read_text().splitlines()) == result.frames


def test_a_process_that_is_killed_ends_the_run_and_leaves_nothing(tmp_path, shared_memory_left):
    bag = write_bag(tmp_path / "bag", 10)

    def children():
        listed = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text()
        return {
            child: Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            for child in listed.split()
        }

    def progress(sent, expected):
        for child, command in children().items():
            if sent > 5 and b"standin_tracker_node" in command:
                os.kill(int(child), signal.SIGKILL)

    with pytest.raises(RuntimeError, match="node tracker ended with status -9"):
        run_in_processes(*graph(bag, tmp_path / "out", {"loop": True}), progress)
    assert not shared_memory_left()
    assert not [
        command for command in children().values() if b"worm_bringup.graph.child_process" in command
    ]


def test_two_graphs_at_once_do_not_hear_each_other(tmp_path):
    bag = write_bag(tmp_path / "bag", 40)
    runs = [
        threading.Thread(
            target=run_in_processes, args=graph(bag, tmp_path / f"out{k}", delay_s=0.002 * k)
        )
        for k in (0, 1)
    ]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert (tmp_path / "out0").read_text() == (tmp_path / "out1").read_text() == truth(40)


def test_nothing_is_left_in_the_home_directory(tmp_path):
    bag = write_bag(tmp_path / "bag", 3)
    script = (
        "import sys; from worm_bringup.graph.in_process import run_in_process;"
        "from worm_bringup.graph.node_spec import NodeSpec as N;"
        "run_in_process(N('worm_tracker.sources.replay_node','image_source',{'bag':sys.argv[1]}),[])"
    )
    environment = {**os.environ, "HOME": str(tmp_path / "home")}
    environment.pop("ROS_LOG_DIR")
    subprocess.run([sys.executable, "-c", script, str(bag)], check=True, env=environment)
    assert not (tmp_path / "home").exists()
