"""Some pictures of a rig, spread over a bag or over a few seconds of a camera."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from worm_msgs_py.arrays import Picture
from worm_msgs_py.errors import BadInput, BadPicture
from worm_msgs_py.ros.running import TICK_S
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.serialized_images import read_picture
from worm_tracker.sources.cameras.camera import Camera
from worm_tracker.sources.image_decoder import PictureDecoder

MOST_PICTURES = 16
"""Of one rig no more are needed: what they share does not become surer."""
CAMERA_STEP_NS = NS_PER_S // 4
"""Between two pictures of a camera a worm crawls half a millimetre."""


def pictures_of_recording(bag: Path, topic: str | None = None) -> list[Picture]:
    """Return pictures spread evenly over a bag, all of the size of the first.

    Raises
    ------
    BadInput
        As `BagPictures`; or no picture can be read.
    """
    pictures: list[Picture] = []
    with BagPictures(bag, topic) as found:
        step = max(1, found.expected // MOST_PICTURES)
        decoder = PictureDecoder()
        for index, item in enumerate(found):
            if index % step or item.why_bad:
                continue
            try:
                picture = decoder.decode(read_picture(item.raw, found.message_type))
            except (BadInput, BadPicture):
                continue
            if not pictures or picture.shape == pictures[0].shape:
                pictures.append(picture)
    if not pictures:
        raise BadInput(
            f"{bag}: none of its pictures can be read: name another --topic, or another bag"
        )
    return pictures[:MOST_PICTURES]


def pictures_of_camera(address: str, capture: Callable[[], Any] | None = None) -> list[Picture]:
    """Return pictures of a few seconds of a camera, or of what films instead of it.

    Raises
    ------
    BadInput
        It cannot be opened, or sends nothing.
    """
    came = threading.Event()
    camera = Camera(address, reconnect_s=0.0, on_change=came.set, capture=capture)
    camera.start()
    camera.begin()
    pictures: list[Picture] = []
    due_ns = 0
    try:
        while len(pictures) < MOST_PICTURES:
            came.clear()
            frame = camera.take()
            if frame is None and camera.ended:
                break
            if frame is None:
                came.wait(TICK_S)
            elif frame.stamp_ns >= due_ns and not frame.why_bad:
                due_ns = frame.stamp_ns + CAMERA_STEP_NS
                pictures.append(frame.picture)
    finally:
        camera.stop()
    if not pictures:
        raise BadInput(f"{camera.shown_address}: no frame has come: is the camera on?")
    return pictures
