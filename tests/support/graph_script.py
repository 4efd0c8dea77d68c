"""A graph with stand-ins for tracker and recorder, run as a process until it is told to end.

    python graph_script.py REACH|PROCESSES BAG OUT

Prints a line once frames are going round; ends in good order at SIGTERM (the bag is looped).
"""

import sys
from functools import partial

from worm_bringup.graph.in_process import run_in_process
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.supervisor import run_in_processes
from worm_msgs_py.ros.network import Reach


def main():
    how, bag, out = sys.argv[1:]
    run = run_in_processes if how == "PROCESSES" else partial(run_in_process, reach=Reach[how])
    said = []

    def progress(sent, expected):
        if sent > 5 and not said:
            said.append(sent)
            print("going", flush=True)

    source = {"bag": bag, "loop": True, "rate": 5.0}
    run(
        NodeSpec("worm_tracker.sources.replay_node", "image_source", source),
        [
            NodeSpec("standin_tracker_node", "tracker", {}),
            NodeSpec("standin_recorder_node", "recorder", {"out": out}),
        ],
        progress,
    )


if __name__ == "__main__":
    main()
