"""What the tests of faults share."""

import os
import subprocess

import pytest


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
