"""What the pictures of single frames are called that lie beside a trial's results."""

from pathlib import Path


def frame_picture_path(directory: Path, frame: int) -> Path:
    """Return where the picture of a frame is kept."""
    return directory / f"frame_{frame:06d}.png"


def frame_pictures(directory: Path) -> dict[int, Path]:
    """Return the pictures that are there by their frames, ascending; others are passed over."""
    found = {}
    for path in directory.glob("frame_*.png"):
        number = path.stem.removeprefix("frame_")
        if number.isdecimal():
            found[int(number)] = path
    return dict(sorted(found.items()))
