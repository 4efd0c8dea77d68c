"""How far a graph can be heard: by default nothing of it leaves this machine."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from ipaddress import ip_address
from pathlib import Path

from worm_msgs_py.errors import BadInput

LOOPBACK = "127.0.0.1"
_PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"


class Reach(Enum):
    """Who can hear a graph."""

    OWN = "own"
    """The nodes of its own context."""
    MACHINE = "machine"
    """Every program on this machine."""
    NETWORK = "network"
    """Whoever the environment lets hear it: by default every machine on the subnet."""


@contextmanager
def environment(**values: str) -> Iterator[None]:
    """Set environment variables for as long as the block runs."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def dds_settings(reach: Reach, *, heed_profile: bool = False) -> dict[str, str]:
    """Return the environment variables that rclpy is to be started with.

    The discovery range of ROS is not enough: with LOCALHOST the sockets are bound on every
    interface all the same. A Fast DDS profile lets them be bound on 127.0.0.1 alone, and nothing is
    multicast.

    Parameters
    ----------
    heed_profile : bool
        Leave a Fast DDS profile that the user has set in its place, and keep discovery to this
        machine; what is bound is then the profile's affair.

    Raises
    ------
    BadInput
        The network is asked for, and the environment forbids it.
    """
    if reach is Reach.NETWORK:
        _refuse_contradiction()
        return {}
    if reach is Reach.OWN:
        return {_PROFILES: _profile_file("own_context"), _RANGE: "OFF", **_alone()}
    if (heed_profile and os.environ.get(_PROFILES)) or not _is_fast_dds():
        return {_RANGE: "LOCALHOST", **_alone()}
    # The profile says all of it: with LOCALHOST, rmw_fastrtps adds a transport of its own.
    return {_PROFILES: _profile_file("this_machine"), _RANGE: "SYSTEM_DEFAULT", **_alone()}


def reach_of_a_lone_node() -> Reach:
    """Return who can hear a node that is started by itself: as far as its environment says.

    That is this machine, unless ROS_AUTOMATIC_DISCOVERY_RANGE is there to say otherwise.
    """
    asked = os.environ.get(_RANGE, "").upper()
    wider = {"OFF": Reach.OWN, "SUBNET": Reach.NETWORK, "SYSTEM_DEFAULT": Reach.NETWORK}
    return wider.get(asked, Reach.MACHINE)


def _alone() -> dict[str, str]:
    alone = {
        "ROS_STATIC_PEERS": "",
        "SKIP_DEFAULT_XML_FILE": "1",  # Fast DDS takes a profile out of the working directory
    }
    if os.environ.get(_LOCALHOST_ONLY):  # the older word, which would overrule the range
        alone[_LOCALHOST_ONLY] = "0"
    return alone


def _profile_file(name: str) -> str:
    return str(Path(__file__).with_name(f"{name}.xml"))


def _is_fast_dds() -> bool:
    return os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp").startswith("rmw_fastrtps")


def _refuse_contradiction() -> None:
    forbids = {name: os.environ.get(name, "") for name in (_RANGE, _LOCALHOST_ONLY)}
    for name, value in forbids.items():
        if value.upper() in ("OFF", "LOCALHOST", "1"):
            raise BadInput(f"--network: {name}={value} forbids it; unset that, or leave it out")


def is_loopback(host: str) -> bool:
    """Tell whether an address is reached from this machine alone."""
    return is_ip_address(host) and ip_address(host).is_loopback


def is_ip_address(host: str) -> bool:
    """Tell whether this is an address by number, not by name."""
    try:
        ip_address(host)
    except ValueError:
        return False
    return True
