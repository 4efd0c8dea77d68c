"""`worm calibrate`: pictures of a rig become a rig file, once somebody has looked and says yes."""

import os
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_bringup.cli import options
from worm_bringup.cli.camera_options import SIMULATED, CameraAddress
from worm_bringup.cli.terminal import say
from worm_bringup.outputs.output_rules import check_apart
from worm_bringup.rig.rig_file import RigParameters, read_rig
from worm_bringup.rig.rig_file_writer import (
    as_png,
    found_entries,
    found_in_words,
    rig_picture,
    rig_text,
)
from worm_bringup.rig.sample_pictures import pictures_of_camera, pictures_of_recording
from worm_msgs_py.arrays import Picture
from worm_msgs_py.errors import BadInput, TrackerError
from worm_msgs_py.files.whole_files import new_file, whole_file
from worm_tracker.calibration.calibrate_pictures import calibrate_pictures
from worm_tracker.detection.polarity import Polarity
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.cameras.camera_address import shown_address

NOT_WRITTEN = 1
_LOOKED_FOR_ANEW = {"polarity", "exit_deg"} | {
    f"{what}_{chamber}{axis}px"
    for chamber in ("", "b_")
    for what, axis in (("centre", "u_"), ("centre", "v_"), ("radius", ""))
}
"""What a rig file before this one says of them is looked for anew."""


def calibrate(
    bag: Annotated[
        Path | None, typer.Argument(help="A rosbag2 directory, an .mcap or a .db3 file.")
    ] = None,
    *,
    camera: CameraAddress = None,
    out: Annotated[
        Path, typer.Option(help="Rig file to write; a picture goes beside it, OUT with .png.")
    ],
    topic: Annotated[
        str, typer.Option(help="Topic of the bag's pictures; found where there is one.")
    ] = "",
    rig: options.RigFiles = None,
    polarity: options.PolarityOption = None,
    radius_mm: options.RadiusMm = None,
    exit_width_mm: options.ExitWidthMm = None,
    depth_mm: options.DepthMm = None,
    passage_mm: options.PassageMm = None,
    yes: Annotated[bool, typer.Option("--yes", help="Write without asking, for scripts.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace files that are there.")
    ] = False,
) -> None:
    """Find polarity, walls, exits and scale in pictures, and write them as a rig file.

    Looks at 16 pictures, spread over the bag or four seconds of the camera, in which the camera and
    the rig must stand still. Shows what it found, with its uncertainty and as a picture, and writes
    nothing before a yes. Then: `worm replay BAG --rig OUT`.
    """
    base = read_rig(rig)
    if bag is not None and camera == os.environ.get("WORM_CAMERA"):
        camera = None
    elif bag is None:
        camera = camera or base.of("image_source").get("camera")
    if (bag is None) == (not camera):
        raise BadInput("give either a bag or --camera (or WORM_CAMERA, or a rig file that has it)")
    picture_file = out.with_suffix(".png")
    check_apart({"--out": out, "its picture": picture_file}, {"the bag": bag} if bag else {})
    _refuse_unasked(out, picture_file, yes=yes, overwrite=overwrite)
    see = options.TrackerOptions(
        radius_mm=radius_mm,
        exit_width_mm=exit_width_mm,
        depth_mm=depth_mm,
        passage_mm=passage_mm,
    ).parameters({k: v for k, v in base.of("tracker").items() if k not in _LOOKED_FOR_ANEW})
    told = polarity or base.of("tracker").get("polarity")
    name, pictures = _sample_of(bag, camera, topic)
    try:
        found = calibrate_pictures(
            pictures, TrackerParameters(**see), Polarity(told) if told else None
        )
    except TrackerError as error:
        raise BadInput(f"{name}: {error}") from None
    text = rig_text(
        Path(name).name if bag else name, found, found_entries(found, see), _others(base, camera)
    )
    for line in found_in_words(found):
        say(line)
    drawn = as_png(rig_picture(pictures[0], found))
    if not (yes or _writing_agreed(drawn, out, picture_file)):
        say("Nothing was written.")
        raise typer.Exit(NOT_WRITTEN)
    write = whole_file if overwrite or not yes else new_file
    for file, data in ((picture_file, drawn), (out, text.encode())):
        with write(file) as unfinished:
            unfinished.write_bytes(data)
    say(f"Rig file: {out}\nPicture: {picture_file}")


def _refuse_unasked(out: Path, picture_file: Path, *, yes: bool, overwrite: bool) -> None:
    """Refuse what needs somebody to ask where nobody is."""
    if not (yes or _somebody_is_there()):
        raise BadInput("nobody is here to look and say yes: run it in a terminal, or add --yes")
    for file in (out, picture_file):
        if file.exists() and yes and not overwrite:
            raise BadInput(f"{file}: is there already: add --overwrite, or name another --out")


def _somebody_is_there() -> bool:
    return sys.stdin.isatty() and sys.stdout.isatty()


def _sample_of(bag: Path | None, camera: str | None, topic: str) -> tuple[str, list[Picture]]:
    """Return what the pictures come from, as people may see it, and some of them."""
    if camera is None:
        assert bag is not None
        return str(bag), pictures_of_recording(bag, topic or None)
    if camera != SIMULATED:
        return shown_address(camera), pictures_of_camera(camera)
    from worm_bringup.simulated_camera import SimulatedCapture

    return camera, pictures_of_camera(camera, lambda: SimulatedCapture(0))


def _others(base: RigParameters, camera: str | None) -> dict[str, dict[str, Any]]:
    """Return what the file says to other nodes; an address with a password is not written."""
    others = {node: base.of(node) for node in base.told if node != "tracker"}
    if camera is not None and shown_address(camera) == camera:
        others.setdefault("image_source", {})["camera"] = camera
    return others


def _writing_agreed(drawn: bytes, out: Path, picture_file: Path) -> bool:
    """Show the picture, and ask whether it may be written."""
    with tempfile.TemporaryDirectory(prefix="worm-calibrate-") as folder:
        shown = Path(folder) / picture_file.name
        shown.write_bytes(drawn)
        say(f"Look at {shown}: do the circles lie on the walls, the lines across the exits?")
        there = [str(file) for file in (out, picture_file) if file.exists()]
        question = f"Replace {' and '.join(there)}?" if there else f"Write {out}?"
        return typer.confirm(question)
