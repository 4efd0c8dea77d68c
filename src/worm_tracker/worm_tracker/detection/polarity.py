"""How the worm looks against its surroundings; all stages see it dark on bright."""

from enum import StrEnum

import cv2
import numpy as np

from worm_msgs_py.arrays import Picture


class Polarity(StrEnum):
    """How the worm looks against its surroundings."""

    DARK = "dark"
    BRIGHT = "bright"


def dark_on_bright(picture: Picture, polarity: Polarity) -> Picture:
    """Return the picture as the stages need it: worm and walls darker than the water."""
    if polarity is Polarity.BRIGHT:
        return np.asarray(cv2.bitwise_not(picture), np.uint8)
    return picture
