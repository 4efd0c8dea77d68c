"""Reads and sets the time stamp of a serialised message without touching the rest of it."""

import struct

# Encapsulation (4 bytes, the second one tells the byte order), then std_msgs/Header begins with
# its stamp: int32 seconds, uint32 nanoseconds. Both picture messages begin with a Header.
_STAMP_AT = 4
_STAMP_ENDS = 12


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
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


def with_stamp(raw: bytes, stamp_ns: int) -> bytes:
    """Return the message with this stamp in its header; the same object where it has it already."""
    if stamp_of(raw) == stamp_ns:
        return raw
    stamp = struct.pack(_format(raw), *divmod(stamp_ns, 1_000_000_000))
    return b"".join((raw[:_STAMP_AT], stamp, memoryview(raw)[_STAMP_ENDS:]))
