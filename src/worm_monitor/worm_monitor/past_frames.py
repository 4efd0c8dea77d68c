"""Frames of a recording that have been tracked: poses as they were given, pictures from its bag."""

import json
import zlib
from bisect import bisect_left
from collections import deque
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any

from worm_monitor.pictures import shown_jpeg, with_head
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.one_picture import open_bag_of, picture_at
from worm_tracker.sources.image_decoder import MAX_MEGAPIXELS

MOST_PAST_FRAMES = 60_000
"""Half an hour at thirty frames a second, in some 30 MB; of a longer recording the last ones."""


class PastFrames:
    """Remembers each pose, and gives the frame that is next to a time.

    One thread may remember while another one asks.

    Parameters
    ----------
    player : str
        Parameters of the `ReplayNode` that plays the recording, as JSON.

    Raises
    ------
    BadInput
        They name no bag.
    """

    def __init__(self, player: str, most: int = MOST_PAST_FRAMES) -> None:
        try:
            self._player: dict[str, Any] = json.loads(player)
            self._bag = Path(self._player["bag"])
        except (ValueError, KeyError, TypeError):
            raise BadInput(
                "node monitor: player names no bag: give the player's parameters as JSON"
            ) from None
        self._most = most
        self._times: deque[tuple[float, int]] = deque()
        self._poses: dict[int, bytes] = {}
        self._lock = Lock()

    def remember(self, time_s: float, stamp_ns: int, pose: Mapping[str, Any]) -> None:
        """Keep the pose of a frame, as it is drawn.

        Parameters
        ----------
        time_s : float
            Seconds after the first frame; ascending.
        """
        packed = zlib.compress(json.dumps(pose, allow_nan=False).encode(), 1)
        with self._lock:
            self._times.append((time_s, stamp_ns))
            self._poses[stamp_ns] = packed
            if len(self._times) > self._most:
                del self._poses[self._times.popleft()[1]]

    def frame_at(self, time_s: float) -> bytes:
        """Return picture and pose of the frame that is next to a time, as pages take them.

        Raises
        ------
        BadInput
            No frame is remembered, or the bag does not give its picture.
        BadPicture
            Its data are damaged.
        """
        after_s, stamp_ns, packed = self._next_to(time_s)
        grey = picture_at(
            partial(open_bag_of, self._bag, self._player),
            stamp_ns,
            after_s + float(self._player.get("start_offset") or 0.0),
            float(self._player.get("max_megapixels", MAX_MEGAPIXELS)),
        )
        jpeg, scale = shown_jpeg(grey)
        pose = json.loads(zlib.decompress(packed))
        return with_head({"t": after_s, "scale": scale, "pose": pose}, jpeg)

    def _next_to(self, time_s: float) -> tuple[float, int, bytes]:
        with self._lock:
            times = tuple(self._times)
            if not times:
                raise BadInput("no frame has been tracked yet")
            k = bisect_left(times, (time_s, 0))
            found = min(times[max(0, k - 1) : k + 1], key=lambda near: abs(near[0] - time_s))
            return (*found, self._poses[found[1]])
