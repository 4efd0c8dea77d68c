"""Builds the example bags: `make bags`, or `python bags/build.py --out FOLDER`.

Without options everything comes from what the repository holds, and gives the same bytes again.
README.md beside this file says what the bags are and why they were made so.
"""

import argparse
import gzip
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.progress import track
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from worm_model.simulator.film import FilmFrame, frame_stamp_ns, write_film, write_picture_bag
from worm_model.simulator.rig import Body, Optics, Rig, draw, truth_of
from worm_model.simulator.rig.skins import SKINS_FILE

HERE = Path(__file__).parent

WORMTRACER_FPS = 66.0

LARVA_FPS = 16.0
LARVA_FIRST_STEP, LARVA_FRAMES = 1080, 800
LARVA_WIDTH_MM = 0.45
LARVA_SHORTEST = 0.72  # of the median length; a spine below it is not one
LARVA_JPEG_QUALITY = 70
LARVA_RIG = Rig(
    centre_px=(507.37, 515.62),
    exit_width_mm=2.0,
    optics=Optics(light=190.0, gradient=(0.10, -0.07), blur_px=0.9, noise=1.5, seed=20230300647),
)


TRIAL = (
    "--minutes", "3", "--fps", "10", "--exit-width-mm", "2", "--seed", "9",
    "--px-per-mm", "16", "--noise", "0.7", "--blur-px", "0.9", "--gradient-percent", "6", "-4",
    "--jpeg-quality", "75",
)  # fmt: skip
"""Options of `worm simulate`: three minutes of the two-dimensional worm in both chambers."""
POOL = (
    "--trials", "12", "--tracks-only", "--minutes", "23", "--fps", "14", "--seed", "300",
    "--exit-width-mm", "0.5", "--exit-width-mm", "5", "--exit-width-mm", "3",
    "--exit-width-mm", "1", "--exit-width-mm", "5", "--exit-width-mm", "0.5",
    "--exit-width-mm", "5", "--exit-width-mm", "3", "--exit-width-mm", "1",
    "--exit-width-mm", "5", "--exit-width-mm", "3", "--exit-width-mm", "3",
)  # fmt: skip
"""Twelve trials of it without pictures, enough for every number of the paper at W = 0.5, 1, 3 and
5 mm: the wider the exit, the more trials it takes for 20 failed attempts.

14 frames a second are the fewest with five of them in half of a peristaltic stroke (0.3 s), as its
phase needs.
"""


def main() -> None:
    """Build the bags into a folder, replacing what is there."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=HERE, help="folder for the bags")
    parser.add_argument(
        "--wormtracer",
        type=Path,
        metavar="FOLDER",
        help="folder with the original WT_grayscale.avi and WT_binary_image_sequence.zip",
    )
    parser.add_argument(
        "--larva", type=Path, metavar="FOLDER", help="folder with the original track 7.csv.gz"
    )
    parser.add_argument(
        "--wormpose",
        type=Path,
        metavar="FOLDER",
        help="folder with the original frames/*.png and skeletons.npz; keeps them, builds no bag",
    )
    parser.add_argument(
        "--folded",
        type=Path,
        metavar="FOLDER",
        help="folder with worm_*.npz, midlines of worms that fold; keeps them, builds no bag",
    )
    parser.add_argument(
        "--skins",
        type=Path,
        metavar="FOLDER",
        help="folder with the original skins.npz; keeps it, builds no bag",
    )
    options = parser.parse_args()
    if options.wormtracer:
        keep_masks(
            options.wormtracer / "WT_binary_image_sequence.zip", HERE / "wormtracer_masks.zip"
        )
    if options.larva:
        cut_larva_track(options.larva / "7.csv.gz", HERE / "source" / "larva_track.csv.gz")
    if options.wormpose:
        keep_crops(options.wormpose, HERE / "wormpose_crops.zip")
        return
    if options.folded or options.skins:
        if options.folded:
            keep_folded_worms(options.folded, HERE / "source" / "folded_worms.npz")
        if options.skins:
            keep_skins(options.skins / "skins.npz", SKINS_FILE)
        return
    video = options.wormtracer / "WT_grayscale.avi" if options.wormtracer else None
    new = options.out / ".new"
    shutil.rmtree(new, ignore_errors=True)
    new.mkdir(parents=True)
    build_wormtracer(new / "wormtracer", video)
    build_larva(new / "larva")
    simulate(new / "trial", TRIAL)
    for made in sorted(new.iterdir()):  # the old bags are kept until the new ones are whole
        old = options.out / made.name
        if old.is_dir():
            shutil.rmtree(old)
        made.replace(old)
    new.rmdir()
    simulate(options.out / "pool", POOL)  # replaces earlier results of its own alone


def simulate(out: Path, words: Sequence[str]) -> None:
    """Run `worm simulate`."""
    worm = Path(sys.executable).with_name("worm")
    subprocess.run([worm, "simulate", "--out", out, *words], check=True)


# The wormtracer bag: a real video, its JPEG frames byte for byte.


def build_wormtracer(bag: Path, video: Path | None = None, frames: int | None = None) -> None:
    """Write the bag from the original video, or from the bag of the repository."""
    pictures = jpegs_of_avi(video) if video else jpegs_of_bag(HERE / "wormtracer")
    pictures = pictures[:frames]
    stamped = ((frame_stamp_ns(k, WORMTRACER_FPS), data) for k, data in enumerate(pictures))
    write_picture_bag(bag, track(stamped, f"writing {bag.name}", total=len(pictures)))


def jpegs_of_avi(video: Path) -> list[bytes]:
    """Return the JPEG files in a Motion-JPEG AVI, found by its index."""
    data = video.read_bytes()
    start, index = data.find(b"movi"), data.rfind(b"idx1")
    if data[:4] != b"RIFF" or start < 0 or index < 0:
        raise ValueError(
            f"{video}: not an AVI file with an index; give the original WT_grayscale.avi"
        )
    length = int.from_bytes(data[index + 4 : index + 8], "little")
    entries = np.frombuffer(data, dtype="<u4", offset=index + 8, count=length // 4).reshape(-1, 4)
    # Offsets count from the file's start in some files and from the word movi in others.
    origin = 0 if data[int(entries[0, 2]) :][:4] == b"00dc" else start
    chunks = ((origin + int(offset) + 8, int(size)) for _, _, offset, size in entries)
    return [data[first : first + size] for first, size in chunks]


def jpegs_of_bag(bag: Path) -> list[bytes]:
    """Return the JPEG files in a bag of CompressedImage messages."""
    types = get_typestore(Stores.ROS2_JAZZY)
    with Reader(bag) as reader:
        return [
            types.deserialize_cdr(raw, connection.msgtype).data.tobytes()
            for connection, _, raw in reader.messages()
        ]


def keep_masks(source: Path, target: Path) -> None:
    """Keep the hand-cleaned masks alone, byte for byte, in one small archive."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        names = sorted(
            n for n in old.namelist() if n.startswith("WT_binary/") and n.endswith("png")
        )
        for name in names:
            entry = zipfile.ZipInfo(Path(name).name)  # a fixed date: the same bytes each time
            new.writestr(entry, old.read(name), zipfile.ZIP_DEFLATED)


def keep_crops(source: Path, target: Path) -> None:
    """Keep pictures that follow a worm, and another tool's skeletons of them, byte for byte."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as new:  # they are compressed already
        for path in [*sorted((source / "frames").glob("*.png")), source / "skeletons.npz"]:
            new.writestr(zipfile.ZipInfo(path.name), path.read_bytes())


# Worms that fold on themselves, and real skins: numbers to draw with, no bags.


def keep_folded_worms(source: Path, target: Path) -> None:
    """Keep midlines and widths in whole micrometres, midlines as steps by frame and by point."""
    kept: dict[str, NDArray[np.generic]] = {"fps": np.array(25.0)}
    for path in sorted(source.glob("worm_*.npz")):
        name = path.stem.removeprefix("worm_")
        with np.load(path) as data:
            um = np.rint(1000.0 * data["midline_mm"].astype(np.float64)).astype(np.int32)
            steps = np.diff(np.diff(np.moveaxis(um, -1, 0), axis=2, prepend=0), axis=1, prepend=0)
            kept[f"midline_steps_{name}"] = steps.astype(np.int16)
            kept[f"width_um_{name}"] = np.rint(1000.0 * data["width_mm"]).astype(np.int16)
    np.savez_compressed(target, **kept)


def keep_skins(source: Path, target: Path) -> None:
    """Keep skins in steps of a half per cent, the midline moved to the middle, the water cut off.

    Across, 0.35 mm to either side are kept; along, 0.3 mm beyond the tips.
    """
    per_mm, beyond_mm, across_mm = 60, 0.3, 0.35
    kept: dict[str, NDArray[np.generic]] = {"per_mm": np.array(float(per_mm))}
    with np.load(source) as data:
        for name in ("w4", "w5"):
            left, right = data[f"{name}_left"], data[f"{name}_right"]
            inside = np.flatnonzero(np.isfinite(left + right))
            rows = np.arange(inside[0] - beyond_mm * per_mm, inside[-1] + beyond_mm * per_mm + 1)
            middle = np.interp(rows, inside, cv2.blur(0.5 * (left + right)[inside], (1, 9)).ravel())
            offsets = np.arange(-across_mm * per_mm, across_mm * per_mm + 1)
            columns = offsets + (0.6 + middle[:, np.newaxis]) * per_mm
            whole = np.asarray(data[f"{name}_T"], dtype=np.float32)
            at = np.broadcast_to(rows[:, np.newaxis], columns.shape)
            moved = cv2.remap(
                whole, columns.astype(np.float32), at.astype(np.float32), cv2.INTER_CUBIC
            )
            kept[f"transmission_{name}"] = np.rint(200.0 * np.clip(moved, 0, 1.2)).astype(np.uint8)
            kept[f"width_um_{name}"] = np.rint(1000.0 * (right - left)[inside]).astype(np.int16)
            kept[f"length_mm_{name}"] = np.array(float(data[f"{name}_L"]))
            kept[f"first_s_mm_{name}"] = np.array(rows[0] / per_mm - 0.6)
    np.savez_compressed(target, **kept)


# The larva bag: real motion, drawn by the rig.


def build_larva(bag: Path, frames: int = LARVA_FRAMES) -> None:
    """Draw the larva's track as a worm in the chamber, with its truth beside it."""
    write_film(bag, larva_film(frames), jpeg_quality=LARVA_JPEG_QUALITY)


def larva_film(frames: int) -> Iterator[FilmFrame]:
    """Yield the first frames of the film; the chamber is chosen from the whole track."""
    spines = mended(larva_spines(HERE / "source" / "larva_track.csv.gz"))
    mm, exit_rad = into_chamber(spines)
    rig = Rig(
        centre_px=LARVA_RIG.centre_px,
        exit_rad=exit_rad,
        exit_width_mm=LARVA_RIG.exit_width_mm,
        optics=LARVA_RIG.optics,
    )
    for frame in track(range(frames), "drawing larva"):
        body = body_in_picture(mm[frame])
        stamp_ns = frame_stamp_ns(frame, LARVA_FPS)
        yield FilmFrame(stamp_ns, draw(rig, body, frame), truth_of(rig, body, frame, stamp_ns))


def larva_spines(table: Path) -> NDArray[np.float64]:
    """Return the track's spines, shape (frames, 12, 2), mm in the dish, **head first**."""
    with gzip.open(table, "rt") as text:
        rows = np.genfromtxt(text, delimiter=",")
    return np.asarray(rows[:, 1:25].reshape(-1, 12, 2)[:, ::-1])


def mended(spines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the track with the source's own mistakes put right.

    Where the larva's outline closed on itself, the source's spine is that of a blob, far too short:
    such frames are bridged in straight lines. The source also takes the tail for the head now and
    then: the ends are carried on from frame to frame, and the end that leads most of the time is
    the head, as a larva crawls forwards.
    """
    steps = np.arange(len(spines))
    length = np.hypot(*np.moveaxis(np.diff(spines, axis=1), 2, 0)).sum(axis=1)
    good = length > LARVA_SHORTEST * np.median(length)
    whole = spines[good].copy()
    for before, spine in pairwise(whole):
        if np.hypot(*(spine - before).T).sum() > np.hypot(*(spine[::-1] - before).T).sum():
            spine[:] = spine[::-1].copy()
    mended = np.empty_like(spines)
    for point, axis in np.ndindex(12, 2):
        mended[:, point, axis] = np.interp(steps, steps[good], whole[:, point, axis])
    advance = np.diff(mended.mean(axis=1), axis=0)
    forwards = ((mended[:-1, 0] - mended[:-1, -1]) * advance).sum()
    return mended if forwards > 0.0 else mended[:, ::-1]


def into_chamber(spines: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Scale and shift the track, as a whole, so that the body just fits into the chamber.

    Returns
    -------
    spines_mm : ndarray, shape (frames, 12, 2)
        mm from the chamber's centre, x to the picture's right, y up.
    exit_rad : float
        The direction that the body keeps away from most: the exit is put there.
    """
    scale, centre = 1.0, np.zeros(2)
    for _ in range(6):
        # The width is given in the chamber, so the fit is repeated with the outline that it makes.
        inside = scale * (spines - centre)
        outline = np.concatenate([_outline_mm(spine) for spine in inside])
        (x, y), radius = cv2.minEnclosingCircle(outline.astype(np.float32))
        centre = centre + np.array([x, y]) / scale
        scale *= LARVA_RIG.radius_mm / radius
    outline -= [x, y]
    scale *= radius / np.hypot(*outline.T).max() * (1.0 - 1e-4)  # float32 above
    mm = scale * (spines - centre)
    outline = outline[np.hypot(*outline.T) > 0.5 * LARVA_RIG.radius_mm]
    directions = np.radians(np.arange(-180.0, 180.0, 3.0))
    mouths = LARVA_RIG.radius_mm * np.c_[np.cos(directions), np.sin(directions)]
    away = [np.hypot(*(outline - mouth).T).min() for mouth in mouths]
    return mm, float(directions[int(np.argmax(away))])


def _outline_mm(spine_mm: NDArray[np.float64]) -> NDArray[np.float64]:
    centres, radius = Body.along(
        spine_mm * LARVA_RIG.px_per_mm, LARVA_WIDTH_MM * LARVA_RIG.px_per_mm
    ).discs(step_px=4.0)
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    circle = np.c_[np.cos(turn), np.sin(turn)] / np.cos(np.pi / 24)
    points = centres[:, np.newaxis] + radius[:, np.newaxis, np.newaxis] * circle
    return np.asarray(points.reshape(-1, 2) / LARVA_RIG.px_per_mm)


def body_in_picture(spine_mm: NDArray[np.float64]) -> Body:
    """Return the worm on this spine, in picture coordinates."""
    u = LARVA_RIG.centre_px[0] + LARVA_RIG.px_per_mm * spine_mm[:, 0]
    v = LARVA_RIG.centre_px[1] - LARVA_RIG.px_per_mm * spine_mm[:, 1]
    return Body.along(np.c_[u, v], LARVA_WIDTH_MM * LARVA_RIG.px_per_mm)


def cut_larva_track(source: Path, target: Path) -> None:
    """Keep the part of the original track that the bag is drawn from, its lines unchanged."""
    lines = gzip.decompress(source.read_bytes()).splitlines(keepends=True)
    kept = lines[LARVA_FIRST_STEP - 1 : LARVA_FIRST_STEP - 1 + LARVA_FRAMES]
    target.parent.mkdir(exist_ok=True)
    target.write_bytes(gzip.compress(b"".join(kept), mtime=0))


if __name__ == "__main__":
    main()
