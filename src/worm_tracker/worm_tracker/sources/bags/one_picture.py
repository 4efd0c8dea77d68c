"""Reads the one picture of a bag that was taken at a given time."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bag_reader import BagPicture, BagPictures
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB
from worm_tracker.sources.bags.serialized_images import read_picture
from worm_tracker.sources.image_decoder import MAX_MEGAPIXELS, Grey, PictureDecoder

LATE_S = (0.2, 5.0)
"""A picture is recorded so much before or after its stamp, nearly always; at most; else all of the
bag is read. Most of the time goes into unpacking those that are recorded meanwhile."""

OpenBag = Callable[[float, float | None], AbstractContextManager[BagPictures]]
"""Opens the bag from an offset on, for so long (None: to the end), s of recording."""


def open_bag_of(
    bag: Path, source: Mapping[str, Any], start_s: float, duration_s: float | None
) -> BagPictures:
    """Open the bag that a source played, or recorded, as it was opened then.

    Parameters
    ----------
    source : mapping
        Parameters of the node that sent the pictures.
    start_s, duration_s : float
        Which part of it, as `OpenBag`.

    Raises
    ------
    BadInput
        As `BagPictures`.
    """
    topic = source.get("topic") or None
    return BagPictures(
        bag,
        topic if source.get("bag") else None,  # a live one's is its driver's
        start_offset_s=start_s,
        playback_duration_s=duration_s,
        salvage=bool(source.get("salvage", False)),
        max_chunk_mib=float(source.get("max_chunk_mib", MAX_CHUNK_MIB)),
        max_megapixels=float(source.get("max_megapixels", MAX_MEGAPIXELS)),
    )


def picture_at(
    open_bag: OpenBag, stamp_ns: int, after_s: float, max_megapixels: float = MAX_MEGAPIXELS
) -> Grey:
    """Return the picture with a stamp.

    Parameters
    ----------
    open_bag : callable
        Opens the bag; `BagPictures.part` of one that is open, where several pictures are wanted.
    stamp_ns : int
        The stamp, as its replay gave it.
    after_s : float
        How long after the bag's first picture it was taken.
    max_megapixels : float
        As for the replay.

    Raises
    ------
    BadInput
        There is no such picture, or it cannot be read; or as `BagPictures`.
    BadPicture
        Its data are damaged.
    """
    for start_s, duration_s in (*((max(0.0, after_s - s), 2 * s) for s in LATE_S), (0.0, None)):
        try:
            bag = open_bag(start_s, duration_s)
        except BadInput:
            if start_s == 0.0:
                raise
            continue  # the recording ends before
        with bag as pictures:
            found = next(_taken_at(pictures, stamp_ns), None)
            if found is not None:
                fields = read_picture(found.raw, pictures.message_type)
                return PictureDecoder(max_megapixels).decode(fields)
    raise BadInput(f"no picture of the bag was taken at {stamp_ns / NS_PER_S:.6f} s")


def _taken_at(pictures: BagPictures, stamp_ns: int) -> Iterator[BagPicture]:
    return (item for item in pictures if item.stamp_ns == stamp_ns and not item.why_bad)
