"""What a camera's address leads to, and how it is shown to people: never with its secrets."""

import re
from enum import Enum
from pathlib import Path

from worm_msgs_py.errors import BadInput


class Kind(Enum):
    """What an address leads to."""

    DEVICE = "device"
    STREAM = "stream"
    FILE = "file"


HIDDEN = "…"
_STREAMS = ("http", "https", "rtsp", "rtsps")
_URL = re.compile(r"(?P<scheme>[A-Za-z][\w+.-]*)://(?P<place>[^/?#]*)(?P<path>[^?#]*)(?P<rest>.*)")
_HOST = re.compile(r"(\[[0-9A-Fa-f:.%]+\]|[^:\[\]@]+)(:\d*)?")
_LIKE_A_KEY = re.compile(r"(?=.*\d)(?=.*[A-Za-z])[\w-]{12,}")


def kind_of(address: str) -> Kind:
    """Tell what an address leads to; BadInput where it leads nowhere."""
    if address.isdecimal() or address.startswith("/dev/video"):
        return Kind.DEVICE
    if address.partition("://")[0].lower() in _STREAMS and "://" in address:
        return Kind.STREAM
    if "\0" not in address and Path(address).is_file():
        return Kind.FILE
    raise BadInput(
        f"{shown_address(address)}: no such camera; give a device (/dev/video0), an http or rtsp "
        "address, or a video file"
    )


def shown_address(address: str) -> str:
    """Return the address as it may be shown, logged and written into results.

    User and password, the query, and parts of the path that look like a key are left out: cameras
    take their password in all of these places. Where an ``@`` stands beyond the host's name (a
    password with a ``/``, ``?`` or ``#`` that is not percent-encoded) it cannot be told what is
    secret, and nothing is shown.
    """
    url = _URL.fullmatch(address)
    if url is None:
        return _shown_words(address)
    scheme, place, path, rest = url.group("scheme", "place", "path", "rest")
    login, at, host = place.rpartition("@")
    if "@" in path + rest or not _HOST.fullmatch(host):
        return f"{scheme}://{HIDDEN}"
    shown = "/".join(HIDDEN if _is_secret(part) else part for part in path.split("/"))
    return f"{scheme}://{HIDDEN + at if at else login}{host}{shown}{_hidden_rest(rest)}"


def _shown_words(address: str) -> str:
    """Return what may be shown of something that is no address of a stream."""
    if "@" in address and not Path(address.replace("\0", "")).exists():
        return HIDDEN  # an address whose scheme was forgotten
    name, mark, _ = address.partition("?")
    return name + mark + HIDDEN if mark else address


def _is_secret(part: str) -> bool:
    return any(mark in part for mark in "=&;") or bool(_LIKE_A_KEY.fullmatch(part))


def _hidden_rest(rest: str) -> str:
    return rest[0] + HIDDEN if rest else ""
