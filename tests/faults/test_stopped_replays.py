"""A replay that was stopped goes on to the same bytes; whatever stands in the way is said."""

import json
import os
import random
import resource
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from picture_bags import TYPESTORE, storage_file
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from stopped_replays import differing, replay, results, trial_of

from worm_bringup.checkpoints import CheckpointFolder
from worm_bringup.cli import main
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.nodes import NODES
from worm_bringup.trial import Incomplete
from worm_model.simulator.film import write_film
from worm_model.simulator.scenes import Take, bumped_camera, coil
from worm_msgs_py.errors import BadInput

BAGS = Path(__file__).parents[2] / "bags"
SUPPORT = Path(__file__).parents[1] / "support"


@pytest.fixture(scope="session")
def film(tmp_path_factory):
    """A short film; its camera is bumped in the middle."""
    path = tmp_path_factory.mktemp("film") / "film"
    write_film(path, bumped_camera(Take(px_per_mm=14.0, frames=24)))
    return path


@pytest.fixture(scope="session")
def whole(film, tmp_path_factory):
    """What the replay of `film` gives that nobody stops."""
    out = tmp_path_factory.mktemp("whole") / "out"
    assert replay(trial_of(film), out) == []
    return results(out)


def left(out):
    """Return what lies beside a results directory, and in its checkpoint."""
    beside = {item.name for item in out.parent.iterdir() if item.name != "film"}
    path = CheckpointFolder(out).path
    return beside, {item.name for item in path.iterdir()} if path.exists() else set()


def test_a_replay_that_is_stopped_at_any_frame_gives_the_same_results(film, whole, tmp_path):
    out, trial = tmp_path / "out", trial_of(film)
    stops = [1, 2, 7, 12, 13, 23, 24]  # in the hold-back, about the bump, before the end's word
    for k, stop in enumerate(stops):
        said = replay(trial, out, stop_at=stop, resume=k > 0)
        assert said == ([f"going on after {stops[k - 1]} of 24 frames"] if k else [])
        assert left(out)[0] == {".out.checkpoint"}
    assert replay(trial, out, resume=True) == ["going on after 24 of 24 frames"]
    assert differing(results(out), whole) == []
    assert left(out) == ({"out"}, set())


@pytest.mark.parametrize(
    ("bag", "options", "stops"),
    [
        pytest.param("larva", {"playback_duration": 3.5}, [20, 45], id="a chamber"),
        pytest.param(
            "wormtracer",
            {
                "start_offset": 18.0,
                "playback_duration": 2.0,
                "tracker": {"no_chamber": True, "polarity": "bright"},
            },
            [15, 40],
            id="a real worm that coils",
        ),
    ],
)
def test_a_real_bag_gives_the_same_results(bag, options, stops, tmp_path):
    trial = trial_of(BAGS / bag, **options)
    replay(trial, tmp_path / "whole")
    for k, stop in enumerate(stops):
        replay(trial, tmp_path / "out", stop_at=stop, resume=k > 0)
    replay(trial, tmp_path / "out", resume=True)
    assert differing(results(tmp_path / "out"), results(tmp_path / "whole")) == []


def test_a_coil_gives_the_same_results(tmp_path):
    write_film(tmp_path / "film", coil(Take(px_per_mm=12.0, frames=30)))
    trial = trial_of(tmp_path / "film")
    replay(trial, tmp_path / "whole")
    replay(trial, tmp_path / "out", stop_at=23)  # the coil waits for the frame that tells it
    replay(trial, tmp_path / "out", resume=True)
    assert differing(results(tmp_path / "out"), results(tmp_path / "whole")) == []


def damaged(film, path):
    """Write a film anew with three messages that are cut, and cut the file behind its middle."""
    with Reader(film) as reader, Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        topic = None
        for number, (read, stamp_ns, raw) in enumerate(reader.messages()):
            topic = topic or bag.add_connection(read.topic, read.msgtype, typestore=TYPESTORE)
            bag.write(topic, stamp_ns, raw[: len(raw) // 2] if number in (7, 8, 9) else raw)
    file = storage_file(path)
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 4 // 5])
    return file


def test_a_salvaged_bag_with_bad_messages_gives_the_same_results(film, tmp_path):
    trial = trial_of(damaged(film, tmp_path / "bag"), salvage=True)
    replay(trial, tmp_path / "whole")
    whole = results(tmp_path / "whole")
    kinds = {event["kind"] for event in json.loads(whole["summary.json"])["source_events"]}
    assert {"bad_message", "lost"} <= kinds
    for stop in (3, 8, 9, 14):  # before, within and after the bad ones
        replay(trial, tmp_path / "out", stop_at=stop, resume=stop > 3)
    replay(trial, tmp_path / "out", resume=True)
    assert differing(results(tmp_path / "out"), whole) == []


def test_who_looks_on_may_be_others_the_second_time(film, whole, tmp_path):
    looked_at = replace(trial_of(film), viewers=(NodeSpec(NODES["overlay"], "overlay"),))
    for name, first, second in (
        ("with", trial_of(film), looked_at),
        ("without", looked_at, trial_of(film)),
    ):
        replay(first, tmp_path / name, stop_at=4)
        replay(second, tmp_path / name, resume=True)
        assert differing(results(tmp_path / name), whole) == []


KILLED = """
import sys
from pathlib import Path
from stopped_replays import replay, trial_of
replay(
    trial_of(Path(sys.argv[1])), Path(sys.argv[2]), resume=True, interval_s=0.0,
    say=lambda line: print(line, flush=True), watch=lambda sent: print(sent, flush=True),
)
"""


def test_a_replay_that_is_killed_at_random_moments_gives_the_same_results(film, whole, tmp_path):
    out, rng = tmp_path / "out", random.Random(0)
    environment = {**os.environ, "PYTHONPATH": str(SUPPORT)}
    reached = 0
    for _ in range(3):
        with subprocess.Popen(
            [sys.executable, "-c", KILLED, film, out],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        ) as process:
            said = process.stdout.readline().strip()
            until = reached + rng.randrange(2, 7)
            for line in process.stdout:  # it makes a checkpoint at each of them
                if int(line) >= until:
                    break
            process.send_signal(signal.SIGKILL)
        resumed = int(said.split()[3]) if said.startswith("going on") else 0
        assert resumed >= reached - 1  # what it lost is what came since the last checkpoint
        reached = until
    assert replay(trial_of(film), out, resume=True)[0].startswith("going on after ")
    assert differing(results(out), whole) == []


def test_a_stop_while_a_replay_is_set_up_again_costs_nothing(film, whole, tmp_path):
    out, trial = tmp_path / "out", trial_of(film)
    replay(trial, out, stop_at=8)
    before = left(out)

    def stop_at_once(line):
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(Incomplete):
        replay(trial, out, resume=True, say=stop_at_once)
    assert left(out) == before
    assert replay(trial, out, resume=True) == ["going on after 8 of 24 frames"]
    assert differing(results(out), whole) == []


def test_what_a_killed_run_left_half_written_is_passed_over(film, whole, tmp_path):
    out, trial = tmp_path / "out", trial_of(film)
    replay(trial, out, stop_at=8)
    place = CheckpointFolder(out).path
    for name in ("state-000001.pickle.new", "messages-000001.z", "manifest.json.new"):
        (place / name).write_bytes(b"half")
    replay(trial, out, stop_at=16, resume=True)
    assert left(out)[1] == {
        "manifest.json",
        "state-000002.pickle",
        "messages-000000.z",
        "messages-000002.z",
    }
    replay(trial, out, resume=True)
    assert differing(results(out), whole) == []
    assert left(out) == ({"out"}, set())


def test_a_run_without_resume_says_what_is_there_and_begins_anew(film, whole, tmp_path):
    out, trial = tmp_path / "out", trial_of(film)
    replay(trial, out, stop_at=8)
    (line,) = replay(trial, out, stop_at=5)
    assert line.startswith(
        "a replay into this directory was stopped after 8 of 24 frames; --resume"
    )
    assert CheckpointFolder(out).manifest().frames == 5
    replay(trial, out)
    assert differing(results(out), whole) == []
    assert left(out) == ({"out"}, set())


def test_where_there_is_nothing_to_resume_it_says_so_and_begins(film, whole, tmp_path):
    (line,) = replay(trial_of(film), tmp_path / "out", resume=True)
    assert line == "there is no checkpoint to go on from: the replay starts at the beginning"
    assert differing(results(tmp_path / "out"), whole) == []


@pytest.mark.parametrize(
    ("other", "line"),
    [
        ({"tracker": {"radius_m": 0.02}}, r"parameters\.tracker\.radius_m was 0\.01, and is 0\.02"),
        (
            {"playback_duration": 1.0},
            r"parameters\.player\.playback_duration was None, and is 1\.0",
        ),
    ],
)
def test_the_checkpoint_of_another_replay_is_not_resumed(film, tmp_path, other, line):
    out = tmp_path / "out"
    replay(trial_of(film), out, stop_at=5)
    before = left(out)
    with pytest.raises(BadInput, match=rf"another replay \({line}\).*--resume") as caught:
        replay(trial_of(film, **other), out, resume=True)
    assert "\n" not in str(caught.value)
    assert left(out) == before


def test_a_short_replay_leaves_the_checkpoint_of_another_alone(film, tmp_path):
    out = tmp_path / "out"
    replay(trial_of(film), out, stop_at=20)
    replay(trial_of(film, playback_duration=0.3), out)
    assert left(out)[0] == {"out", ".out.checkpoint"}
    assert CheckpointFolder(out).manifest().frames == 20


@pytest.mark.parametrize("name", ["state-000000.pickle", "messages-000000.z", "manifest.json"])
@pytest.mark.parametrize("harm", ["cut", "gone"])
def test_a_damaged_checkpoint_is_refused_in_one_line(film, tmp_path, name, harm):
    out = tmp_path / "out"
    replay(trial_of(film), out, stop_at=5)
    file = CheckpointFolder(out).path / name
    file.write_bytes(file.read_bytes()[:-20])
    if harm == "gone" and name != "manifest.json":
        file.unlink()
    with pytest.raises(
        BadInput, match=r"^\S+: this checkpoint .*leave out --resume to begin anew$"
    ) as caught:
        replay(trial_of(film), out, resume=True)
    assert "\n" not in str(caught.value)


def open_to_others(place):
    place.chmod(0o755)


def a_link(place):
    place.rename(place.with_name("elsewhere"))
    place.symlink_to("elsewhere")


def of_another_user(place):
    os.chown(place, 12345, -1)


@pytest.mark.parametrize("change", [open_to_others, a_link, of_another_user])
def test_a_checkpoint_that_others_could_have_written_is_never_read(film, tmp_path, change):
    if change is of_another_user and os.geteuid() != 0:
        pytest.skip("only root gives files away")
    out = tmp_path / "out"
    replay(trial_of(film), out, stop_at=5)
    change(CheckpointFolder(out).path)
    with pytest.raises(BadInput, match=r"^\S+: is not a folder of yours alone"):
        replay(trial_of(film), out, resume=True)


def test_a_checkpoint_is_for_its_user_alone(film, tmp_path):
    replay(trial_of(film), tmp_path / "out", stop_at=5)
    assert CheckpointFolder(tmp_path / "out").path.stat().st_mode & 0o777 == 0o700


def test_a_file_of_the_users_in_the_folder_is_left_there(film, tmp_path):
    out = tmp_path / "out"
    replay(trial_of(film), out, stop_at=5)
    (CheckpointFolder(out).path / "notes.txt").write_text("mine")
    replay(trial_of(film), out, resume=True)
    assert left(out) == ({"out", ".out.checkpoint"}, {"notes.txt"})


@pytest.fixture
def no_large_files():
    """No file may grow beyond 2 MB: the results are smaller, the state of the tracker is not."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_replay_goes_on_where_no_checkpoint_can_be_written(film, whole, tmp_path, no_large_files):
    out = tmp_path / "out"
    (line,) = replay(trial_of(film), out, interval_s=0.0)
    assert line.startswith("no checkpoint can be made any more, the replay goes on: ")
    assert differing(results(out), whole) == []
    assert left(out) == ({"out"}, set())


def test_the_last_checkpoint_holds_where_the_next_cannot_be_written(
    film, whole, tmp_path, no_large_files
):
    out = tmp_path / "out"
    with_room = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (with_room[1], with_room[1]))
    replay(trial_of(film), out, stop_at=8)
    before = left(out)
    resource.setrlimit(resource.RLIMIT_FSIZE, with_room)
    said = replay(trial_of(film), out, stop_at=16, resume=True)
    assert said[1].startswith("no checkpoint can be made any more")
    assert left(out) == before
    replay(trial_of(film), out, resume=True)
    assert differing(results(out), whole) == []


def test_what_a_run_left_that_was_killed_in_its_first_checkpoint_is_removed(film, tmp_path):
    out = tmp_path / "out"
    place = CheckpointFolder(out).path
    place.mkdir(mode=0o700)
    (place / "messages-000000.z").write_bytes(b"half")
    replay(trial_of(film), out)
    assert left(out) == ({"out"}, set())


def test_a_replay_shorter_than_the_interval_writes_no_checkpoint(film, tmp_path):
    seen = []
    replay(
        trial_of(film),
        tmp_path / "out",
        interval_s=10.0,
        watch=lambda sent: seen.append(CheckpointFolder(tmp_path / "out").path.exists()),
    )
    assert not any(seen)


def worm(monkeypatch, *words):
    """Run the command in this process; return its exit status."""
    monkeypatch.setattr(sys, "argv", ["worm", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        main()
    return ended.value.code


def test_the_last_line_of_a_stopped_replay_tells_how_to_go_on(
    film, tmp_path, monkeypatch, capfd, whole
):
    class Bar:
        def __init__(self, name):
            pass

        def __enter__(self):
            return lambda sent, expected: sent == 9 and os.kill(os.getpid(), signal.SIGTERM)

        def __exit__(self, *error):
            pass

    out = tmp_path / "a b"
    with monkeypatch.context() as patch:
        patch.setattr("worm_bringup.cli.replay.progress_bar", Bar)
        assert worm(patch, "replay", film, "--out", out) == 130
    last = capfd.readouterr().err.splitlines()[-1]
    assert last == (
        f"worm: stopped after 9 of 24 frames; go on with: worm replay {film} --out '{out}' --resume"
    )
    assert worm(monkeypatch, "replay", film, "--out", out, "--resume") == 0
    assert "worm: going on after 9 of 24 frames" in capfd.readouterr().err
    tracks = "tracks.parquet"
    assert (out / tracks).read_bytes() == whole[tracks]
    assert json.loads((out / "summary.json").read_text())["complete"] is True


@pytest.mark.parametrize("option", ["--processes", "--loop"])
def test_resume_is_refused_where_no_checkpoints_are_made(
    film, tmp_path, monkeypatch, capfd, option
):
    assert worm(monkeypatch, "replay", film, "--out", tmp_path / "out", "--resume", option) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert "--resume" in line
    assert option in line
