"""Keeps a few pictures of a live trial, evenly spread over it: a report can choose among them."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2

from worm_msgs_py.files.frame_pictures import frame_picture_path
from worm_msgs_py.files.whole_files import whole_file
from worm_tracker.sources.image_decoder import Grey

MOST_SAMPLED, FIRST_STEP = 32, 32
"""Pictures that are there at most, and frames from one to the next at the start."""
FASTEST = [cv2.IMWRITE_PNG_COMPRESSION, 1]


class SampledPictures:
    """Writes every n-th picture; n doubles, and every other one is removed, as often as it takes.

    A long trial has between 16 and 32 of them. They are written by a thread: to compress a picture
    takes as long as a frame lasts. Where one cannot be written no other is: the trial is as good
    without.

    Parameters
    ----------
    directory : Path
        Where they are written.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._step = FIRST_STEP
        self._frames: list[int] = []
        self._works = True
        self._writer = ThreadPoolExecutor(1, "sampled_pictures")

    def take(self, frame: int, picture: Grey) -> None:
        """Keep the picture of a frame, if it is one of those that are kept; it must not change."""
        if frame % self._step == 0 and self._works:
            self._writer.submit(self._keep, frame, picture)

    def close(self) -> None:
        """Wait until all are written."""
        self._writer.shutdown()

    def _keep(self, frame: int, picture: Grey) -> None:
        if frame % self._step or not self._works:  # it has changed while this one waited
            return
        try:
            data = cv2.imencode(".png", picture, FASTEST)[1].tobytes()
            with whole_file(frame_picture_path(self._directory, frame)) as unfinished:
                unfinished.write_bytes(data)
            self._frames.append(frame)
            if len(self._frames) > MOST_SAMPLED:
                self._step *= 2
                self._drop([kept for kept in self._frames if kept % self._step])
        except OSError:
            self._works = False

    def _drop(self, frames: list[int]) -> None:
        for frame in frames:
            frame_picture_path(self._directory, frame).unlink(missing_ok=True)
            self._frames.remove(frame)
