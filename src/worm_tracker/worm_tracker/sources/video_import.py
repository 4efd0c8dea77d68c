"""Reads films that are no bags, video files and sequences of pictures, and writes them as a bag."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.whole_files import new_folder, refuse_existing
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bag_writer import PictureRecorder
from worm_tracker.sources.bags.compressed_message import compressed_message
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE

GreyPicture = NDArray[np.uint8] | NDArray[np.uint16]

STILLS = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff")
"""Files that a folder's sequence is made of."""
STACKS = (".tif", ".tiff")
_READ_GREY = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION


@dataclass(frozen=True, slots=True)
class Film:
    """A film to be read.

    Attributes
    ----------
    path : Path
        A video, a stack of pictures in one TIFF file, or a folder of pictures.
    frames : int
        Pictures that it says it has; 0 where it does not say.
    fps : float
        Pictures a second by the file; NaN where it does not say.
    """

    path: Path
    frames: int
    fps: float


@dataclass(frozen=True, slots=True)
class Imported:
    """What was written: the number of pictures, and of seconds from the first to the last."""

    frames: int
    duration_s: float


def open_film(path: Path) -> Film:
    """Look at a film before it is read.

    Raises
    ------
    BadInput
        It is not there, is empty, or is nothing that can be read.
    """
    if path.is_dir():
        return Film(path, len(_stills(path)), math.nan)
    if not path.is_file():
        raise BadInput(f"{path}: no such file or folder; give a video or a folder of pictures")
    if path.suffix.lower() in STACKS:
        count = cv2.imcount(str(path))
        if count < 1:
            raise BadInput(f"{path}: cannot be read as a TIFF file; is it whole?")
        return Film(path, count, math.nan)
    capture = _capture(path)
    frames, fps = capture.get(cv2.CAP_PROP_FRAME_COUNT), capture.get(cv2.CAP_PROP_FPS)
    capture.release()
    return Film(path, max(0, int(frames)), fps if 0 < fps < math.inf else math.nan)


def import_film(
    film: Film,
    out: Path,
    *,
    fps: float | None = None,
    start_ns: int = 0,
    jpeg_quality: int | None = None,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Imported:
    """Write a film as a rosbag2 folder (mcap), whole or not at all.

    Parameters
    ----------
    film : Film
    out : Path
        The folder to make.
    fps : float, optional
        Pictures a second; otherwise a video's own times are kept.
    start_ns : int
        Stamp of the first picture.
    jpeg_quality : int, optional
        0 to 100; without it nothing is lost (PNG).
    progress : callable
        Told how many of how many pictures are written.

    Returns
    -------
    Imported

    Raises
    ------
    BadInput
        Where `out` is there, the film has no times and `fps` is not given, its times do not
        increase, or its pictures cannot be read or differ in size.
    """
    refuse_existing(out)
    if fps is None and not math.isfinite(film.fps):
        raise BadInput(f"{film.path}: has no times of its own; give its rate with --fps")
    with new_folder(out) as folder:
        recorder = PictureRecorder(folder, f"/{topics.IMAGE_COMPRESSED}", COMPRESSED_TYPE)
        try:
            first_ns, last_ns = _write_pictures(
                film, recorder, fps, start_ns, jpeg_quality, progress
            )
        finally:
            recorder.close()
    return Imported(recorder.count, (last_ns - first_ns) / NS_PER_S)


def _write_pictures(
    film: Film,
    recorder: PictureRecorder,
    fps: float | None,
    start_ns: int,
    jpeg_quality: int | None,
    progress: Callable[[int, int], None],
) -> tuple[int, int]:
    """Write the pictures; return the first stamp and the last."""
    first_ns, last_ns, shape = None, start_ns, None
    for number, (picture, time_ns) in enumerate(_timed_pictures(film)):
        if shape not in (None, picture.shape):
            raise BadInput(
                f"{film.path}: picture {number} is of {_size_in_px(picture.shape)} pixels "
                f"and those before of {_size_in_px(shape)}; a trial has one size"
            )
        shape = picture.shape
        offset_ns = time_ns if fps is None else round(number * NS_PER_S / fps)
        if first_ns is None:
            first_ns = offset_ns
        elif start_ns + offset_ns - first_ns <= last_ns:
            raise BadInput(f"{film.path}: its times do not increase (picture {number}); give --fps")
        last_ns = start_ns + offset_ns - first_ns
        recorder.write(last_ns, compressed_message(picture, last_ns, jpeg_quality))
        progress(recorder.count, max(film.frames, recorder.count))
    if not recorder.count:
        raise BadInput(f"{film.path}: no picture in it can be read; does a player show it?")
    return start_ns, last_ns


def _timed_pictures(film: Film) -> Iterator[tuple[GreyPicture, int]]:
    """Give the pictures in order, each with its time by the file, nanoseconds (0: none)."""
    if film.path.is_dir():
        for still in _stills(film.path):
            yield _read_still(still), 0
    elif film.path.suffix.lower() in STACKS:
        for k in range(film.frames):
            done, pages = cv2.imreadmulti(str(film.path), k, 1, flags=_READ_GREY)
            if not done:
                raise BadInput(f"{film.path}: picture {k} cannot be read; is the file whole?")
            yield _of_a_depth_that_is_read(np.asarray(pages[0]), film.path), 0
    else:
        yield from _read_frames(film)


def _read_frames(film: Film) -> Iterator[tuple[GreyPicture, int]]:
    capture = _capture(film.path)
    try:
        while capture.grab():
            done, picture = capture.retrieve()
            if not done:
                return
            time_ns = round(capture.get(cv2.CAP_PROP_POS_MSEC) * 1e6)
            yield _grey(np.asarray(picture)), time_ns
    finally:
        capture.release()


def _capture(path: Path) -> Any:
    quiet = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    finally:
        cv2.utils.logging.setLogLevel(quiet)
    if not capture.isOpened():
        raise BadInput(
            f"{path}: cannot be read as a video; give one that FFmpeg reads, a TIFF stack, "
            "or a folder of pictures"
        )
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)  # coordinates are those of the sensor
    return capture


def _stills(folder: Path) -> list[Path]:
    """Return the pictures of a folder, 2 before 10."""
    found = [file for file in folder.iterdir() if file.suffix.lower() in STILLS]
    if not found:
        raise BadInput(
            f"{folder}: holds no pictures ({', '.join(STILLS)}); give a folder that does"
        )
    return sorted(found, key=_natural)


def _natural(file: Path) -> list[tuple[int, str]]:
    parts = re.split(r"(\d+)", file.name)
    return [(int(part), "") if part.isdigit() else (0, part) for part in parts]


def _read_still(still: Path) -> GreyPicture:
    picture = cv2.imread(str(still), _READ_GREY)
    if picture is None:
        raise BadInput(f"{still}: cannot be read as a picture; remove it or mend it")
    return _of_a_depth_that_is_read(np.asarray(picture), still)


def _of_a_depth_that_is_read(picture: NDArray[Any], path: Path) -> GreyPicture:
    if picture.dtype not in (np.uint8, np.uint16):
        raise BadInput(f"{path}: pixels are {picture.dtype}; convert them to 8 or 16 bits")
    return picture if picture.ndim == 2 else _grey(picture)


def _grey(picture: NDArray[Any]) -> GreyPicture:
    if picture.ndim == 2:
        return picture
    grey: GreyPicture = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)  # type: ignore[assignment]
    return grey


def _size_in_px(shape: tuple[int, ...]) -> str:
    return f"{shape[1]} × {shape[0]}"
