"""Reads serialised pictures without copying them, and sets what their headers say."""

import struct
from dataclasses import dataclass

from worm_msgs_py.units import NS_PER_S
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE

# Encapsulation (4 bytes, the second one tells the byte order), then std_msgs/Header begins with
# its stamp: int32 seconds, uint32 nanoseconds. Both picture messages begin with a Header.
_STAMP_AT = 4
_STAMP_ENDS = 12
_PADDING = 8
"""Most bytes that writers leave after the last field."""


def _format(raw: bytes) -> str:
    return "<iI" if raw[1] & 1 else ">iI"


def stamp_of(raw: bytes) -> int:
    """Return the header's stamp in nanoseconds.

    Parameters
    ----------
    raw : bytes
        The CDR form of a message whose first field is a `std_msgs/Header`.

    Raises
    ------
    ValueError
        Too short to hold a stamp.
    """
    if len(raw) < _STAMP_ENDS:
        raise ValueError(f"a message of {len(raw)} bytes holds no header")
    seconds, nanoseconds = struct.unpack_from(_format(raw), raw, _STAMP_AT)
    return int(seconds) * NS_PER_S + int(nanoseconds)


def with_stamp(raw: bytes, stamp_ns: int) -> bytes:
    """Return the message with this stamp in its header; the same object where it has it already."""
    if stamp_of(raw) == stamp_ns:
        return raw
    stamp = struct.pack(_format(raw), *divmod(stamp_ns, NS_PER_S))
    return b"".join((raw[:_STAMP_AT], stamp, memoryview(raw)[_STAMP_ENDS:]))


def with_frame_id(raw: bytes, frame_id: str) -> bytes:
    """Return the message with this frame in its header; the same object where it has it already.

    The fields after the header of both picture messages are aligned to 4 bytes at most, so what
    follows need not be written anew.
    """
    fields = _Fields(raw)
    fields.number("i", "stamp")
    fields.number("I", "stamp")
    if fields.text("frame_id") == frame_id:
        return raw
    name = frame_id.encode() + b"\0"
    size = struct.pack(_format(raw)[0] + "I", len(name))
    rest = memoryview(raw)[fields.aligned(4) :]
    return b"".join((raw[:_STAMP_ENDS], size, name, bytes(-len(name) % 4), rest))


@dataclass(frozen=True, slots=True)
class RawPicture:
    """A `sensor_msgs/Image` as it lies in a bag; `data` shares the message's memory."""

    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: memoryview


@dataclass(frozen=True, slots=True)
class CompressedPicture:
    """A `sensor_msgs/CompressedImage` as it lies in a bag."""

    format: str
    data: memoryview


class _Fields:
    """Reads one field after another, each aligned to its size."""

    def __init__(self, raw: bytes) -> None:
        if len(raw) < 4 or raw[0] != 0 or raw[1] > 1:
            raise ValueError("it is not in CDR form" if len(raw) else "it is empty")
        self._raw = memoryview(raw)
        self._order = "<" if raw[1] else ">"
        self._at = 4

    def number(self, kind: str, what: str) -> int:
        size = struct.calcsize(kind)
        self._at = self.aligned(size)
        try:
            (value,) = struct.unpack_from(self._order + kind, self._raw, self._at)
        except struct.error:
            raise ValueError(f"it ends in its {what}") from None
        self._at += size
        return int(value)

    def bytes(self, what: str) -> memoryview:
        count = self.number("I", what)
        if count > len(self._raw) - self._at:
            raise ValueError(f"it ends in its {what}")
        self._at += count
        return self._raw[self._at - count : self._at]

    def text(self, what: str) -> str:
        letters = bytes(self.bytes(what))
        if letters and not letters.endswith(b"\0"):
            raise ValueError(f"its {what} is damaged")
        return letters[:-1].decode("utf-8", "replace")

    def aligned(self, size: int) -> int:
        """Return where a field that is aligned to so many bytes comes next."""
        return self._at + -(self._at - 4) % size

    def end(self) -> None:
        if len(self._raw) - self._at > _PADDING:
            raise ValueError("it goes on after its last field")


def read_picture(raw: bytes, message_type: str) -> RawPicture | CompressedPicture:
    """Return the fields of a picture.

    Parameters
    ----------
    raw : bytes
        The message in CDR form.
    message_type : str
        `IMAGE_TYPE` or `COMPRESSED_TYPE`.

    Raises
    ------
    ValueError
        The message is cut or damaged; a reader of ROS would fail on it, or take it for another.
    """
    fields = _Fields(raw)
    fields.number("i", "stamp")
    fields.number("I", "stamp")
    fields.text("frame_id")
    if message_type == COMPRESSED_TYPE:
        compressed = CompressedPicture(fields.text("format"), fields.bytes("data"))
        fields.end()
        return compressed
    height, width = fields.number("I", "height"), fields.number("I", "width")
    encoding = fields.text("encoding")
    is_bigendian, step = fields.number("B", "byte order"), fields.number("I", "step")
    picture = RawPicture(height, width, encoding, is_bigendian, step, fields.bytes("data"))
    fields.end()
    return picture


def empty_picture(stamp_ns: int, message_type: str) -> bytes:
    """Return a whole message without a pixel: what stands for one that cannot be read."""
    header = struct.pack("<4xiII", *divmod(stamp_ns, NS_PER_S), 1)
    header = b"\x00\x01" + header[2:] + b"\0"
    if message_type == COMPRESSED_TYPE:
        # frame_id, padding, an empty format, padding, no data
        return header + struct.pack("<3xI1s3xI", 1, b"\0", 0)
    # frame_id, padding, height, width, an empty encoding, byte order, padding, step, no data
    return header + struct.pack("<3xIII1sB2xII", 0, 0, 1, b"\0", 0, 0, 0)
