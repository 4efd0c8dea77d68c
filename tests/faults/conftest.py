"""What the tests of faults share."""

import os
import subprocess

import pytest

from worm_bringup.graph.ros_environment import free_domain


@pytest.fixture(scope="module")
def two_hosts():
    """Two network namespaces joined by a wire: as two machines of a subnet are to DDS."""
    names = [f"worm-{os.getpid()}-{side}" for side in "ab"]
    ends = [f"w{os.getpid()}{side}" for side in "ab"]
    made = []

    def ip(*words):
        subprocess.run(["ip", *words], check=True, capture_output=True, text=True)

    try:
        for name in names:
            ip("netns", "add", name)
            made.append(name)
        ip("link", "add", ends[0], "netns", names[0], "type", "veth",
           "peer", "name", ends[1], "netns", names[1])  # fmt: skip
        for host, (name, end) in enumerate(zip(names, ends, strict=True), start=1):
            ip("-n", name, "address", "add", f"10.99.0.{host}/24", "dev", end)
            ip("-n", name, "link", "set", end, "up")
            ip("-n", name, "link", "set", "lo", "up")
        yield [("ip", "netns", "exec", name) for name in names]
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"no network namespaces can be made here: {error}")
    finally:
        for name in made:
            subprocess.run(["ip", "netns", "del", name], check=False)


@pytest.fixture
def environment():
    """As of a shell of its own, in a ROS domain of the test's own."""
    plain = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS_AUTO", "FASTRTPS_", "SKIP_DEFAULT"))
    }
    with free_domain() as number:
        yield {**plain, "ROS_DOMAIN_ID": str(number)}
