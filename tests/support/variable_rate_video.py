"""An MP4 film whose frames are shown for times of their own: its table is rewritten."""

import struct

import cv2


def write_video(path, pictures, durations_s):
    """Write grey pictures; each is shown for its own time. Return the path as text."""
    height, width = pictures[0].shape
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 100.0, (width, height))
    assert writer.isOpened()
    for picture in pictures:
        writer.write(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    writer.release()
    path.write_bytes(_rewritten(path.read_bytes(), durations_s))
    return str(path)


def _rewritten(data, durations_s):
    """Return a box, or a row of them, with another `stts`; sizes around it follow."""
    out, at = b"", 0
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + size]
        if kind in (b"moov", b"trak", b"mdia", b"minf", b"stbl"):
            body = _rewritten(body, durations_s)
        elif kind == b"edts":
            kind = b"free"  # it would end the film at its old length
        elif kind == b"mdhd":
            scale = struct.unpack(">I", body[12:16])[0]
            _rewritten.scale = scale
        elif kind == b"stts":
            rows = b"".join(struct.pack(">II", 1, round(s * _rewritten.scale)) for s in durations_s)
            body = body[:4] + struct.pack(">I", len(durations_s)) + rows
        out += struct.pack(">I4s", len(body) + 8, kind) + body
        at += size
    return out
