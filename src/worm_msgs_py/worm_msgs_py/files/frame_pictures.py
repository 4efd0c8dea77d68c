"""What the pictures of single frames are called that lie beside a trial's results.

The name is one that no other program gives: `frame_000012.png` is what video tools call what they
cut from a film, and a user may keep such pictures beside the results.
"""

import re
from pathlib import Path

FRAME_PICTURE = r"report_frame_\d{6,}\.png"
"""Regular expression of their names."""


def frame_picture_path(directory: Path, frame: int) -> Path:
    """Return where the picture of a frame is kept."""
    return directory / f"report_frame_{frame:06d}.png"


def frame_pictures(directory: Path) -> dict[int, Path]:
    """Return the pictures that are there by their frames, ascending; others are passed over."""
    ours = (p for p in directory.glob("report_frame_*.png") if re.fullmatch(FRAME_PICTURE, p.name))
    return dict(sorted((int(path.stem.rpartition("_")[2]), path) for path in ours))
