"""The pictures of a bag one after the other, grey, for loops that need no ROS."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from worm_msgs_py.errors import BadInput, BadPicture
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.serialized_images import read_picture
from worm_tracker.sources.image_decoder import Grey, PictureDecoder


def pictures_of_bag(
    bag: str | Path,
    topic: str | None = None,
    *,
    start_offset_s: float = 0.0,
    playback_duration_s: float | None = None,
) -> Iterator[tuple[Grey, int]]:
    """Yield every picture of a bag and its stamp, as `worm replay` gives them to the tracker.

    Parameters
    ----------
    bag : str or Path
        A rosbag2 directory, an .mcap or a .db3 file.
    topic : str, optional
        The topic of the pictures; the only one where not given.
    start_offset_s, playback_duration_s : float
        A part of the bag, s of recording after its first picture.

    Yields
    ------
    picture : ndarray of uint8, shape (h, w)
        Grey levels. Empty, (0, 0), where a message cannot be read: to the tracker it is a frame
        with the status ``bad_image``, so that every message is a frame.
    stamp_ns : int
        Time of capture.

    Raises
    ------
    BadInput
        As `BagPictures`: no such bag, damaged, several topics of pictures.
    """
    with BagPictures(
        Path(bag), topic, start_offset_s=start_offset_s, playback_duration_s=playback_duration_s
    ) as pictures:
        yield from decoded(pictures)


def decoded(pictures: BagPictures) -> Iterator[tuple[Grey, int]]:
    """Yield every picture of an open bag and its stamp, as `pictures_of_bag` does."""
    decoder = PictureDecoder()
    for found in pictures:
        try:
            fields = read_picture(found.raw, pictures.message_type)
            picture = decoder.decode(fields)
        except (BadInput, BadPicture):
            picture = np.empty((0, 0), np.uint8)
        yield picture, found.stamp_ns
