"""Reads the size of a JPEG or PNG out of its bytes and tells whether it is whole, undecoded."""

import struct
from binascii import crc32

from worm_msgs_py.errors import BadPicture

JPEG = b"\xff\xd8\xff"
PNG = b"\x89PNG\r\n\x1a\n"

Bytes = bytes | memoryview

# Markers that begin a frame and so say its size: all of SOF0 to SOF15 but DHT, JPG and DAC.
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_ALONE = frozenset(range(0xD0, 0xD9)) | {0x01}
_SCAN, _END = 0xDA, b"\xff\xd9"


def size_of_whole(data: Bytes) -> tuple[int, int]:
    """Return the width and height of a JPEG or PNG that is there to its end.

    Raises
    ------
    BadPicture
        It is neither, or is cut or damaged.
    """
    head = bytes(data[:8])
    if head.startswith(JPEG):
        return _jpeg(data)
    if head == PNG:
        return _png(data)
    raise BadPicture("it begins neither as a JPEG nor as a PNG does")


def _jpeg(data: Bytes) -> tuple[int, int]:
    size, at = None, 2
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            raise BadPicture("its JPEG header is damaged")
        marker = data[at + 1]
        if marker == 0xFF:  # a byte of padding
            at += 1
            continue
        if marker in _ALONE:
            at += 2
            continue
        length = data[at + 2] << 8 | data[at + 3]
        if marker in _FRAMES and at + 9 <= len(data):
            height, width = struct.unpack_from(">HH", data, at + 5)
            size = width, height
        if marker == _SCAN:
            break
        at += 2 + length
    if size is None or at + 4 > len(data):
        raise BadPicture("its JPEG header is cut short")
    # In the scan 0xff stands only before markers, so that this is its end and nothing else.
    if bytes(data[at:]).rfind(_END) < 0:
        raise BadPicture("the JPEG is cut short: its end is missing")
    return size


def _png(data: Bytes) -> tuple[int, int]:
    size, at = None, len(PNG)
    while at + 12 <= len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + 12 + length
        if end > len(data):
            break
        (crc,) = struct.unpack_from(">I", data, end - 4)
        if crc32(data[at + 4 : end - 4]) != crc:
            raise BadPicture("the PNG is damaged: a checksum in it fails")
        if kind == b"IHDR" and length == 13:
            size = struct.unpack_from(">II", data, at + 8)
        if kind == b"IEND":
            if size is None:
                break
            return int(size[0]), int(size[1])
        at = end
    raise BadPicture("the PNG is cut short: its end is missing")
