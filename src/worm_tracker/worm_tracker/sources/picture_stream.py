"""The pictures of one source as the tracker can use them, and which of them it cannot."""

from typing import Any

import numpy as np

from worm_msgs_py import SourceEvent
from worm_msgs_py.errors import BadInput, BadPicture
from worm_tracker.sources.bags.bad_messages import BadMessages
from worm_tracker.sources.image_decoder import Grey, PictureDecoder


class PictureStream:
    """Decodes the messages of one source, all of one form and one size.

    Parameters
    ----------
    max_megapixels : float
        Larger pictures are bad ones.
    """

    def __init__(self, max_megapixels: float) -> None:
        self._decoder = PictureDecoder(max_megapixels)
        self._bad = BadMessages()
        self._kind: type | None = None
        self._any_decoded = False

    def is_mine(self, message: Any) -> bool:
        """Whether a message is of the form, raw or compressed, that the first one had.

        A camera that offers both forms sends each frame twice.
        """
        self._kind = self._kind or type(message)
        return type(message) is self._kind

    def read(
        self, message: Any, frame: int, stamp_ns: int, shape: tuple[int, ...] | None
    ) -> tuple[Grey, list[SourceEvent]]:
        """Return the picture of a message, and what is to be told of bad ones by now.

        Parameters
        ----------
        message : sensor_msgs.msg.Image or sensor_msgs.msg.CompressedImage
            As for `PictureDecoder.decode`.
        frame, stamp_ns : int
            The frame's number and stamp.
        shape : tuple of int or None
            The only shape that can be used; None while any can.

        Returns
        -------
        ndarray of uint8, shape (h, w)
            Empty where the message cannot be used.
        list of SourceEvent
            Bad pictures that follow each other for one reason are one event.

        Raises
        ------
        BadInput
            No picture of this source was of an encoding that is read.
        """
        picture, why_bad = self._decode(message, shape)
        told = self._bad.bad(frame, stamp_ns, why_bad) if why_bad else self._bad.good()
        return picture, told

    def end(self) -> list[SourceEvent]:
        """Return what has not been told yet; nothing comes any more."""
        return self._bad.end()

    def _decode(self, message: Any, shape: tuple[int, ...] | None) -> tuple[Grey, str]:
        """Return the picture of a message, and why it cannot be used; empty where it can."""
        nothing = np.empty((0, 0), np.uint8)
        try:
            picture = self._decoder.decode(message)
        except BadPicture as error:
            return nothing, str(error)
        except BadInput as error:
            if not self._any_decoded and len(message.data):
                raise  # no picture of this source is of an encoding that is read
            # An empty message stands for one that the source could not read, and has told of.
            return nothing, str(error) if len(message.data) else ""
        self._any_decoded = True
        if shape not in (None, picture.shape):
            (height, width), (first_height, first_width) = picture.shape, shape
            return nothing, (
                f"it has {width} × {height} pixels, those before it {first_width} × "
                f"{first_height}: the rig's place is known for that size alone; it is not rescaled"
            )
        return picture, ""
