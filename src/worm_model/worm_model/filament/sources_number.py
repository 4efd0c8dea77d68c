"""A number of the filament's sources, which ties the machine code that is kept to all of them."""

from pathlib import Path
from zlib import crc32


def sources_number() -> int:
    """Return a number that changes with any file of this folder."""
    number = 0
    for file in sorted(Path(__file__).parent.glob("*.py")):
        number = crc32(file.read_bytes(), number)
    return number
