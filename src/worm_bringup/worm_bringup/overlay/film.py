"""A film of a result: every picture with what was found drawn over it, as MP4."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState, PointCloud2

from worm_analysis.results.summary import read_summary
from worm_bringup.overlay.drawing import draw_over
from worm_bringup.overlay.frame_join import FrameJoin, JoinedFrame
from worm_bringup.overlay.shapes import shapes_of
from worm_msgs_py import convert, topics
from worm_msgs_py.arrays import Picture
from worm_msgs_py.errors import BadInput, MalformedMessage
from worm_msgs_py.files.whole_files import new_file
from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.bag_sources import SoundBag
from worm_tracker.sources.bags.pictures import decoded
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB
from worm_tracker.sources.image_decoder import Grey

_CODEC = "mp4v"
_LONE_FPS = 25.0
"""Of a film of one frame."""
_LEAST_FPS, _MOST_FPS = 1.0, 240.0

Report = Callable[[int, int | None], None]


@dataclass(frozen=True, slots=True)
class _Source:
    """Where the pictures of a result are."""

    bag: Path
    topic: str | None
    start_offset_s: float
    playback_duration_s: float | None
    salvage: bool


def write_overlay_film(results: Path, out: Path, bag: Path | None, progress: Report) -> int:
    """Write every frame of a result with its overlay; frame n of the film is frame n of the tracks.

    It plays at the trial's usual rate: the median of the time between frames, 1 to 240 a second.

    Parameters
    ----------
    results : Path
        A results directory with its bag.
    out : Path
        The MP4 file to make.
    bag : Path, optional
        The bag that was replayed or recorded; None: the results' own bag holds the pictures.
    progress : callable
        Told how many frames of how many are written.

    Returns
    -------
    int
        How many frames were written.

    Raises
    ------
    BadInput
        There is no such result, it has no bag or no pictures, the bag is another one, `out` is
        there, or it cannot be written. One line each.
    ReportError
        `results` is no result.
    """
    summary = read_summary(results / "summary.json")
    own = results / "bag"
    if not own.is_dir():
        raise BadInput(f"{results}: has no bag/ with the midlines: replay the trial again")
    source = _film_source(results, own, bag, summary)
    stamps = [
        convert.stamp_to_ns(msg.header.stamp) for msg in _messages_of_topic(own, topics.WORM_STATE)
    ]
    with new_file(out) as unfinished:
        film = unfinished.with_name(unfinished.name + out.suffix)  # which OpenCV goes by
        try:
            count = _write_film(film, _fps(stamps), _drawn(own, source), len(stamps), progress)
            film.replace(unfinished)
        finally:
            film.unlink(missing_ok=True)
    return count


def _film_source(results: Path, own: Path, bag: Path | None, summary: Mapping[str, Any]) -> _Source:
    if bag is None:
        with closing(SoundBag(own, MAX_CHUNK_MIB)) as found:
            names = {name.lstrip("/") for name, _ in found.counts}
        if not names & {topics.IMAGE, topics.IMAGE_COMPRESSED}:
            raise BadInput(
                f"{results}: its bag holds no pictures: name the bag that was replayed or recorded "
                "with --bag, or replay it with --with-pictures"
            )
        return _Source(own, None, 0.0, None, False)
    origin = summary["provenance"].get("source")
    origin = origin if isinstance(origin, dict) else {}
    return _Source(
        bag,
        origin.get("topic") if origin.get("bag") else None,
        float(origin.get("start_offset_s") or 0.0),
        origin.get("playback_duration_s"),
        "salvaged" in origin,
    )


def _messages_of_topic(bag: Path, topic: str) -> Iterator[Any]:
    kind = PointCloud2 if topic == topics.WORM_MIDLINE else JointState
    with closing(SoundBag(bag, MAX_CHUNK_MIB)) as found:
        for message in found.found("/" + topic, None):
            yield deserialize_message(message.data, kind)


def _frames_of_bag(bag: Path) -> Iterator[JoinedFrame]:
    """Yield every frame of a result's bag."""
    join = FrameJoin()
    try:
        for msg in _messages_of_topic(bag, topics.CHAMBER_GEOMETRY):
            yield from join.add_geometry(convert.geometry_from_msg(msg))
        states = _messages_of_topic(bag, topics.WORM_STATE)
        midlines = _messages_of_topic(bag, topics.WORM_MIDLINE)
        for state, midline in zip(states, midlines, strict=True):
            yield from join.add_state(convert.body_state_from_msg(state))
            yield from join.add_midline(convert.midline_from_msg(midline))
        yield from join.finish()
    except (MalformedMessage, ValueError) as error:
        why = f"is no whole bag of results ({error}): replay the trial again"
        raise BadInput(f"{bag}: {why}") from error


def _pictures_of_bag(source: _Source) -> Iterator[tuple[Grey, int]]:
    """Yield picture and stamp of every message; an empty picture where it cannot be read."""
    with BagPictures(
        source.bag,
        source.topic,
        start_offset_s=source.start_offset_s,
        playback_duration_s=source.playback_duration_s,
        salvage=source.salvage,
    ) as pictures:
        yield from decoded(pictures)


def _drawn(bag: Path, source: _Source) -> Iterator[Picture]:
    """Yield every frame of the film; a picture that cannot be used is black, and says so."""
    first = next((grey for grey, _ in _pictures_of_bag(source) if grey.size), None)
    if first is None:
        raise BadInput(f"{source.bag}: not one picture can be read")
    pictures, blank = _pictures_of_bag(source), np.zeros_like(first)
    for frame in _frames_of_bag(bag):
        grey, stamp_ns = next(pictures, (blank, None))
        if stamp_ns != frame.state.stamp_ns:
            raise BadInput(
                f"{source.bag}: is not the bag of these results: their frame {frame.state.frame} "
                f"was taken at {frame.state.stamp_ns} ns, its picture at {stamp_ns}"
            )
        usable = grey if grey.shape == blank.shape else blank
        yield draw_over(usable, shapes_of(frame.state, frame.midline, frame.geometry))


def _fps(stamps: list[int]) -> float:
    if len(stamps) < 2:
        return _LONE_FPS
    between_s = float(np.median(np.diff(stamps))) / NS_PER_S
    return float(np.clip(1.0 / between_s if between_s > 0 else _LONE_FPS, _LEAST_FPS, _MOST_FPS))


def _write_film(
    film: Path, fps: float, frames: Iterator[Picture], expected: int, told: Report
) -> int:
    """Write a film; BadInput where OpenCV cannot, which says so by what it has left out."""
    count = 0
    with ExitStack() as stack:
        writer: Any = None
        for frame in map(_even, frames):
            if writer is None:
                height, width = frame.shape[:2]
                code = cv2.VideoWriter.fourcc(*_CODEC)
                writer = cv2.VideoWriter(str(film), code, fps, (width, height))
                stack.callback(writer.release)
            writer.write(frame)
            count += 1
            told(count, expected)
    if count != expected or not count or _frames_in(film) != count:
        raise BadInput(
            f"the film cannot be written: {_frames_in(film)} of {expected} frames are in it: make "
            "room on the disk, or name another --out"
        )
    return count


def _even(frame: Picture) -> Picture:
    """Return a frame with an even number of rows and columns, as the codec wants, black ones added.

    OpenCV would leave the last ones out.
    """
    height, width = frame.shape[:2]
    edges = (0, height % 2, 0, width % 2)
    return np.asarray(cv2.copyMakeBorder(frame, *edges, cv2.BORDER_CONSTANT), np.uint8)


def _frames_in(film: Path) -> int:
    capture = cv2.VideoCapture(str(film))
    try:
        return int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if capture.isOpened() else 0
    finally:
        capture.release()
