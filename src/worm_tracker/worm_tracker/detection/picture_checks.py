"""Whether what was given is a picture that the tracker can take, and shows anything."""

from dataclasses import dataclass

import numpy as np

from worm_msgs_py.arrays import Picture


@dataclass(frozen=True, slots=True)
class PictureCheckSettings:
    """What a picture must have."""

    least_side_px: int = 16
    """A smaller picture holds no worm."""
    stride_px: int = 32
    """A picture is judged good or bad by every so many-th pixel of every so many-th row."""
    black_grey: int = 3
    saturated_grey: int = 252
    """Pictures that are nowhere brighter than the one, or darker than the other, show nothing."""


def is_informative(picture: Picture, settings: PictureCheckSettings) -> bool:
    """Tell whether a picture is neither black, nor saturated, nor of one grey level.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        Neither side shorter than `least_side_px`.
    settings : PictureCheckSettings
    """
    stride = min(picture.shape) // settings.least_side_px
    stride = max(1, min(settings.stride_px, stride))
    sparse = picture[::stride, ::stride]
    low, high = int(sparse.min()), int(sparse.max())
    return high > low and high > settings.black_grey and low < settings.saturated_grey


def why_no_picture(picture: object) -> str:
    """Say why what was given cannot be a picture, and what to do; empty where it can."""
    if not isinstance(picture, np.ndarray):
        return (
            f"the picture is {type(picture).__name__}, no array (OpenCV gives None where it "
            "cannot read one): give grey levels, an array of uint8 of shape (h, w)"
        )
    if picture.ndim != 2:
        cure = "cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) makes it grey"
        return f"the picture has the shape {picture.shape}, not (h, w): {cure}"
    if picture.dtype != np.uint8:
        return (
            f"the picture holds {picture.dtype}, not uint8: scale its grey levels to 0 to 255 by "
            "one factor for all pictures, and give picture.astype(np.uint8)"
        )
    return ""
