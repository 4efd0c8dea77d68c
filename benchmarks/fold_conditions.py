"""Fold films in worse conditions than they were drawn in: what is told must not become wrong.

At half the frame rate; with 40 of every 100 pictures missing in a row; with every fifth picture the
one before (that frame should have no pose, so that 80 % are right at most); on a rig that vibrates;
out of focus; with more noise.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from benchmarks.fold_films import LINE_QUALITY, PER_FRAME, FoldFilm
from worm_model.simulator.film import encode
from worm_msgs_py.arrays import Floats, Picture

REPEATED_EVERY = 5
KNOWN_AFTER, GAP_EVERY, GAP = 200, 100, 40
"""Frames after which pictures are missing, and how many of how many in a row are."""
VIBRATES_PX, BLUR_PX, NOISE = 0.5, 2.0, 8.0
"""Standard deviations: of where the rig is in a picture (u and v each), of the blur, of the noise
in grey levels."""


def _half_rate(film: FoldFilm) -> FoldFilm:
    """Leave every other picture out."""
    return _of_frames(film, range(0, len(film), 2))


def _with_gaps(film: FoldFilm) -> FoldFilm:
    """Leave many pictures in a row out, again and again, once the worm is known."""
    kept = [k for k in range(len(film)) if k < KNOWN_AFTER or k % GAP_EVERY < GAP_EVERY - GAP]
    return _of_frames(film, kept)


def _of_frames(film: FoldFilm, frames: Sequence[int]) -> FoldFilm:
    """Return a film of some of its frames."""
    jpegs = [film.jpeg_of(frame) for frame in frames]
    rows = {name: getattr(film, name)[list(frames)] for name in PER_FRAME}
    ends = np.cumsum([len(jpeg) for jpeg in jpegs])
    return replace(film, jpeg=np.concatenate(jpegs), jpeg_end=ends, **rows)


def _repeated(film: FoldFilm) -> FoldFilm:
    """Show one picture in a few once more in place of the next one."""
    shown = [frame - (frame % REPEATED_EVERY == REPEATED_EVERY - 1) for frame in range(len(film))]
    jpegs = [film.jpeg_of(frame) for frame in shown]
    ends = np.cumsum([len(jpeg) for jpeg in jpegs])
    return replace(film, jpeg=np.concatenate(jpegs), jpeg_end=ends)


def _vibrating(film: FoldFilm) -> FoldFilm:
    """Shift each picture but the first; the truth lies where the worm is in the first one's rig."""
    shifts = np.random.default_rng(1).normal(0.0, VIBRATES_PX, (len(film), 2))
    shifts[0] = 0.0
    return _shown_as(film, lambda picture, frame: _moved(picture, shifts[frame]))


def _unfocused(film: FoldFilm) -> FoldFilm:
    return _shown_as(film, lambda picture, _: _as_grey(cv2.GaussianBlur(picture, (0, 0), BLUR_PX)))


def _noisy(film: FoldFilm) -> FoldFilm:
    return _shown_as(film, _with_noise)


CONDITIONS: dict[str, Callable[[FoldFilm], FoldFilm]] = {
    "half_rate": _half_rate,
    "gaps": _with_gaps,
    "repeated": _repeated,
    "vibrating": _vibrating,
    "unfocused": _unfocused,
    "noisy": _noisy,
}


def _shown_as(film: FoldFilm, shown: Callable[[Picture, int], Picture]) -> FoldFilm:
    """Return a film whose pictures are shown otherwise, and encoded anew."""
    jpegs = [
        np.frombuffer(encode(shown(film.picture(frame), frame), LINE_QUALITY), np.uint8)
        for frame in range(len(film))
    ]
    ends = np.cumsum([len(jpeg) for jpeg in jpegs])
    return replace(film, jpeg=np.concatenate(jpegs), jpeg_end=ends)


def _moved(picture: Picture, shift: Floats) -> Picture:
    motion = np.array([[1.0, 0.0, shift[0]], [0.0, 1.0, shift[1]]])
    size = picture.shape[1], picture.shape[0]
    return _as_grey(cv2.warpAffine(picture, motion, size, borderMode=cv2.BORDER_REPLICATE))


def _with_noise(picture: Picture, frame: int) -> Picture:
    noise = np.random.default_rng(frame).normal(0.0, NOISE, picture.shape)
    return _as_grey(np.clip(np.rint(picture + noise), 0, 255))


def _as_grey(picture: cv2.typing.MatLike) -> Picture:
    return np.asarray(picture, np.uint8)
