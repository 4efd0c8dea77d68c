"""Decompresses zstd and lz4 within a limit, and keeps what came before an error."""

from typing import Any

import lz4.frame
import zstandard

from worm_msgs_py.limits import Limit

MIB = 1 << 20
CHUNK_MIB = Limit(1e-3, 1e6, "MiB")
MAX_CHUNK_MIB = 512.0
"""Largest chunk, decompressed, that is read where nothing else is asked for."""

COMPRESSIONS = ("", "zstd", "lz4")

_ZSTD, _LZ4 = b"\x28\xb5\x2f\xfd", b"\x04\x22\x4d\x18"
_COARSE_STEP_BYTES, _FINE_STEP_BYTES = 1 << 18, 1 << 9


def is_zstd(data: bytes) -> bool:
    """Tell whether the data begins as a zstd frame does."""
    return data[:4] == _ZSTD


def decompress(data: bytes, compression: str, limit: int) -> tuple[bytes, str]:
    """Return what can be decompressed, and why it is not all; empty where it is.

    Parameters
    ----------
    data : bytes
        The whole compressed piece.
    compression : str
        ``zstd``, ``lz4`` or empty; where it is something else, the first bytes tell.
    limit : int
        No more bytes than this are made, whatever the data holds.
    """
    kind = compression if compression in COMPRESSIONS else _sniffed(data)
    if kind == "":
        return data[:limit], "" if len(data) <= limit else f"it is larger than {limit} bytes"
    if kind is None:
        return b"", f"its compression {compression[:16]!r} is not known"
    whole, why = _stream(_decompressor(kind), data, limit, _COARSE_STEP_BYTES)
    if why:  # once more in small steps, which keeps all that comes before the error
        partial, _ = _stream(_decompressor(kind), data, limit, _FINE_STEP_BYTES)
        whole = max(whole, partial, key=len)
    return whole, why


def _sniffed(data: bytes) -> str | None:
    if is_zstd(data):
        return "zstd"
    return "lz4" if data[:4] == _LZ4 else None


class _Zstd:
    """zstandard's reader in the form of lz4's decompressor: it makes no more than it is asked."""

    def __init__(self) -> None:
        self._reader: Any = None
        self.eof = False

    def decompress(self, data: bytes, max_length: int) -> bytes:
        if self._reader is None:
            self._reader = zstandard.ZstdDecompressor().stream_reader(data)
        made: bytes = self._reader.read(max_length)
        self.eof = not made
        return made


def _decompressor(kind: str) -> Any:
    return _Zstd() if kind == "zstd" else lz4.frame.LZ4FrameDecompressor()


def _stream(decompressor: Any, data: bytes, limit: int, step: int) -> tuple[bytes, str]:
    made = bytearray()
    try:
        while not decompressor.eof:
            piece = decompressor.decompress(data, max_length=min(step, limit + 1 - len(made)))
            data = b""
            made += piece
            if len(made) > limit:
                return bytes(made[:limit]), f"it decompresses to more than {limit} bytes"
            if not piece and not decompressor.eof:
                return bytes(made), "its compressed data is cut short"
    except (zstandard.ZstdError, RuntimeError, EOFError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        return bytes(made), f"its compressed data is damaged ({reason})"
    return bytes(made), ""
