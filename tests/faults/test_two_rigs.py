"""Two rigs in two namespaces of one ROS domain do not touch each other."""

import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

from forked_commands import worm
from mjpeg_server import number_in
from result_files import TABLES

from worm_tracker.sources.bags.pictures import pictures_of_bag

BAGS = Path(__file__).parents[2] / "bags"
SUPPORT = Path(__file__).parents[1] / "support"
WORM = [sys.executable, "-c", "from worm_bringup.cli import main; main()"]
RESUME_BOTH = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger
rclpy.init(args=[])
node = Node("operator", start_parameter_services=False)
clients = [node.create_client(Trigger, f"/rig{k}/image_source/resume") for k in (1, 2)]
assert all(client.wait_for_service(timeout_sec=60) for client in clients)
for client in clients:
    for _ in range(10):  # DDS loses an answer to a client that is not discovered yet
        answer = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, answer, timeout_sec=6)
        if answer.done():
            assert answer.result().success
            break
        if not client.service_is_ready():
            break  # it has obeyed and run to its end, and only the answer was lost
    else:
        raise SystemExit(f"no answer from {client.srv_name}")
"""


def tables(out):
    return {name: (out / name).read_bytes() for name in (*TABLES, "summary.json")}


def test_two_replays_at_once_give_what_each_gives_alone(tmp_path, environment):
    replays = {1: (BAGS / "larva", "2"), 2: (BAGS / "trial", "3")}
    commands = {
        rig: ["replay", str(bag), "--playback-duration", seconds, "--namespace", f"/rig{rig}"]
        for rig, (bag, seconds) in replays.items()
    }
    at_once = ["--visible", "--start-paused"]
    with ExitStack() as stack:
        graphs = [
            stack.enter_context(
                subprocess.Popen(
                    [*WORM, *map(str, command), *at_once, "--out", tmp_path / f"rig{rig}"],
                    env=environment,
                )
            )
            for rig, command in commands.items()
        ]
        for graph in graphs:
            stack.callback(graph.kill)  # one that stays paused would be waited for
        subprocess.run([sys.executable, "-c", RESUME_BOTH], env=environment, check=True)
        assert [graph.wait() for graph in graphs] == [0, 0]
    for rig, command in commands.items():
        alone = tmp_path / f"alone{rig}"
        worm(*command, "--out", alone, env=environment).check_returncode()
        assert tables(tmp_path / f"rig{rig}") == tables(alone)


def test_two_cameras_at_once_film_each_its_own(tmp_path, environment):
    firsts = {1: 0, 2: 2000}
    with ExitStack() as stack:
        graphs = []
        for rig, first in firsts.items():
            topic = f"/rig{rig}/camera/image_raw"
            words = [SUPPORT / "driver.py", topic, "mono8", "best_effort", str(first)]
            driver = subprocess.Popen(
                [sys.executable, *words], stdin=subprocess.PIPE, text=True, env=environment
            )
            stack.enter_context(driver)
            stack.callback(driver.kill)
            print(400, file=driver.stdin, flush=True)
            outputs = ["--out", tmp_path / f"out{rig}", "--record", tmp_path / f"record{rig}"]
            live = ["live", "--topic", "camera/image_raw", "--namespace", f"/rig{rig}"]
            command = [*WORM, *live, "--no-chamber", "--reconnect-s", "0", *outputs]
            graphs.append(stack.enter_context(subprocess.Popen(command, env=environment)))
        assert [graph.wait() for graph in graphs] == [1, 1]  # the drivers have stopped
    for rig, first in firsts.items():
        numbers = [number_in(grey) for grey, _ in pictures_of_bag(tmp_path / f"record{rig}")]
        assert len(numbers) > 100
        assert set(numbers) <= set(range(first, first + 400))
        again = tmp_path / f"again{rig}"
        replay = ["replay", tmp_path / f"record{rig}", "--no-chamber", "--out", again]
        worm(*replay, env=environment)
        found, expected = tables(tmp_path / f"out{rig}"), tables(again)
        assert {name: found[name] for name in TABLES} == {name: expected[name] for name in TABLES}
