"""Another ROS program with settings of its own: hears a topic, and ends. Run as a process.

    python other_program.py TYPE TOPIC SECONDS

Prints ``heard`` once it has a message; ``silence`` where none came.
"""

import sys
import time
from importlib import import_module

import rclpy
from rclpy.node import Node


def main():
    kind, topic, seconds = sys.argv[1:]
    module, _, name = kind.rpartition(".")
    rclpy.init(args=[])
    node = Node("other_program", start_parameter_services=False)
    heard = []
    node.create_subscription(getattr(import_module(module), name), topic, heard.append, 10)
    until_s = time.monotonic() + float(seconds)
    while not heard and time.monotonic() < until_s:
        rclpy.spin_once(node, timeout_sec=0.1)
    print("heard" if heard else "silence")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
