"""Copies a bag's pictures beside the results, frame by frame, so that these replay as a whole."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from worm_msgs_py import topics
from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_reader import BagPicture, BagPictures
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB
from worm_tracker.sources.bags.serialized_images import with_frame_id
from worm_tracker.sources.image_decoder import IMAGE_TYPE, MAX_MEGAPIXELS
from worm_tracker.sources.playback import in_a_loop


class CopiedPictures:
    """The pictures that a player sends, read a second time.

    They are copied as they came, JPEG, PNG or bare pixels: so a replay of the results gives the
    same tracks. Only the frame in their header is that of `camera_info`. They come from the bag and
    not from the topic, so that a replay that goes on from a checkpoint has the earlier ones too.

    Parameters
    ----------
    player : mapping
        Parameters of the `ReplayNode` whose pictures they are.

    Attributes
    ----------
    topic, message_type : str
        Where they go in the results' bag.

    Raises
    ------
    BadInput
        No bag is named; or as `BagPictures`.
    """

    def __init__(self, player: Mapping[str, Any]) -> None:
        if not player.get("bag"):
            raise BadInput("node recorder: pictures names no bag: give the player's parameters")
        self._bag = BagPictures(
            Path(player["bag"]),
            player.get("topic") or None,
            start_offset_s=float(player.get("start_offset", 0.0)),
            playback_duration_s=player.get("playback_duration"),
            salvage=bool(player.get("salvage", False)),
            max_chunk_mib=float(player.get("max_chunk_mib", MAX_CHUNK_MIB)),
            max_megapixels=float(player.get("max_megapixels", MAX_MEGAPIXELS)),
        )
        self.message_type = self._bag.message_type
        is_bare = self.message_type == IMAGE_TYPE
        self.topic = topics.IMAGE if is_bare else topics.IMAGE_COMPRESSED
        looped = in_a_loop(self._bag) if player.get("loop") else self._bag
        self._pictures: Iterator[BagPicture] = iter(looped)

    def next_picture(self, stamp_ns: int) -> bytes:
        """Return the picture of the next frame.

        Raises
        ------
        BadInput
            The next picture is another one: the bag was changed meanwhile.
        """
        picture = next(self._pictures, None)
        if picture is None or picture.stamp_ns != stamp_ns:
            raise BadInput(
                f"{self._bag.path}: has no picture of {stamp_ns} ns where there was one: it was "
                "changed while it was replayed"
            )
        return with_frame_id(picture.raw, CAMERA)

    def close(self) -> None:
        """Close the bag."""
        self._bag.close()
