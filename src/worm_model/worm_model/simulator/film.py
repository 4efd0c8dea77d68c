"""Writes a film as a rosbag2 folder, with the truth of its frames beside it."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from worm_model.simulator.rig import FilmedPicture, TruthRow, write_truth
from worm_msgs_py import topics
from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.files.whole_files import new_file, new_folder
from worm_msgs_py.units import NS_PER_S

_TYPES = get_typestore(Stores.ROS2_JAZZY)
_COMPRESSED = "sensor_msgs/msg/CompressedImage"
_PNG = b"\x89PNG"


class FilmFrame(NamedTuple):
    """One frame of a synthetic film.

    Attributes
    ----------
    stamp_ns : int
        Time of capture; the film starts at 0.
    picture : ndarray of uint8 or uint16, shape (height, width)
        Grey levels.
    truth : TruthRow
        What is true of it.
    """

    stamp_ns: int
    picture: FilmedPicture
    truth: TruthRow


def frame_stamp_ns(frame: int, fps: float) -> int:
    """Return the stamp of a frame in nanoseconds, rounded from the exact time."""
    return round(frame * NS_PER_S / fps)


def truth_path(bag: Path) -> Path:
    """Return where the truth of this bag lies: ``<bag>_truth.parquet`` beside it."""
    return bag.with_name(bag.name + "_truth.parquet")


def write_film(path: Path, film: Iterable[FilmFrame], *, jpeg_quality: int = 90) -> Path:
    """Write a film and its truth, whole or not at all.

    Parameters
    ----------
    path : Path
        The rosbag2 folder (mcap) to make.
    film : iterable of FilmFrame
        Its frames in time order.
    jpeg_quality : int
        0 to 100, of pictures of 8 bits; those of 16 are PNG.

    Returns
    -------
    Path
        The truth table, ``<path>_truth.parquet``.

    Raises
    ------
    BadInput
        Where the bag, or the truth of one, is there already, or cannot be written.
    """
    truth = truth_path(path)
    rows: list[TruthRow] = []

    def encoded() -> Iterator[tuple[int, bytes]]:
        for frame in film:
            rows.append(frame.truth)
            yield frame.stamp_ns, encode(frame.picture, jpeg_quality)

    with new_file(truth) as unfinished, new_folder(path) as folder:
        _write_bag(folder, encoded())
        write_truth(rows, unfinished)
    return truth


def encode(picture: FilmedPicture, jpeg_quality: int) -> bytes:
    """Encode a mono picture, as JPEG or, of 16 bits, as PNG; the same gives the same bytes."""
    options = [cv2.IMWRITE_JPEG_QUALITY, jpeg_quality, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
    done, data = (
        cv2.imencode(".jpg", picture, options)
        if picture.dtype == np.uint8
        else cv2.imencode(".png", picture)
    )
    if not done:
        raise ValueError(f"OpenCV could not encode a picture of {picture.shape}, {picture.dtype}")
    return data.tobytes()


def write_picture_bag(path: Path, frames: Iterable[tuple[int, bytes]]) -> None:
    """Write JPEG or PNG files as they are, as CompressedImage messages on ``image_raw/compressed``.

    The bag is written in a hidden folder beside `path` and moved in place when it is whole.

    Parameters
    ----------
    path : Path
        The rosbag2 folder (mcap) to make.
    frames : iterable of (int, bytes)
        Stamp in nanoseconds, and the file.

    Raises
    ------
    BadInput
        Where `path` is there already, or cannot be written.
    """
    with new_folder(path) as folder:
        _write_bag(folder, frames)


def _write_bag(folder: Path, frames: Iterable[tuple[int, bytes]]) -> None:
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection(topics.IMAGE_COMPRESSED, _COMPRESSED, typestore=_TYPES)
        for stamp_ns, data in frames:
            message = _compressed_image(stamp_ns, data)
            writer.write(connection, stamp_ns, _TYPES.serialize_cdr(message, _COMPRESSED))


def _compressed_image(stamp_ns: int, data: bytes) -> object:
    time = _TYPES.types["builtin_interfaces/msg/Time"]
    header = _TYPES.types["std_msgs/msg/Header"]
    seconds, nanoseconds = divmod(stamp_ns, NS_PER_S)
    return _TYPES.types[_COMPRESSED](
        header=header(stamp=time(sec=seconds, nanosec=nanoseconds), frame_id=CAMERA),
        format="mono16; png compressed" if data.startswith(_PNG) else "jpeg",
        data=np.frombuffer(data, dtype=np.uint8),
    )
