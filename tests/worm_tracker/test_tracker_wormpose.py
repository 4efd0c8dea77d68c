"""Real crops that follow a worm, against what another tool made of those where it is not coiled."""

import io
import zipfile
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from benchmarks.guises import CROPS_PER_S, on_canvas

from worm_tracker.midline.curve import arc_length
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

CROPS = Path(__file__).parents[2] / "bags" / "wormpose_crops.zip"
ENDS = {"head": (0, 2.7), "tail": (-1, 3.2)}
"""Which point of a line is it, and how far within the body's end the other tool's skeletons end.

They end where the body is still 6.4 px wide (of 10.6): that is no tip. The second test shows where
the grey levels fall to half height."""


@cache
def crops():
    """Return the crops, and the other tool's skeletons (frames, 52, 2) in them."""
    with zipfile.ZipFile(CROPS) as archive:
        names = sorted(name for name in archive.namelist() if name.endswith(".png"))
        pictures = [
            cv2.imdecode(np.frombuffer(archive.read(name), np.uint8), cv2.IMREAD_GRAYSCALE)
            for name in names
        ]
        skeletons = np.load(io.BytesIO(archive.read("skeletons.npz")))["skeletons"]
    return pictures, skeletons.astype(float)


def water(crop):
    return float(np.median(np.concatenate([crop[0], crop[-1], crop[:, 0], crop[:, -1]])))


@cache
def tracked():
    """Return the midline found in each crop, None where there is none, and the frames from which on
    the tracker took the other end for the head.

    Where the crops were cut is not known: each goes into the middle of a canvas of one size.
    """
    tracker, given, corners = Tracker(TrackerParameters(no_chamber=True)), [], []
    for k, crop in enumerate(crops()[0]):
        canvas, corner = on_canvas(crop)
        corners.append(corner)
        given += tracker.push(canvas, round(k * 1e9 / CROPS_PER_S))
    given += tracker.finish()
    lines = [np.stack([t.midline.u_px, t.midline.v_px], axis=1) for t in given]
    found = [line - at if len(line) else None for line, at in zip(lines, corners, strict=True)]
    return found, {exchange.frame for exchange in tracker.exchanges}


@cache
def compared():
    """Return crop, midline and skeleton of each frame that has all, and whether both agree on the
    head; midlines are turned to the skeleton's order."""
    pictures, skeletons = crops()
    found = []
    for picture, line, skeleton in zip(pictures, tracked()[0], skeletons, strict=True):
        if line is not None and np.isfinite(skeleton).all():
            straight, turned = (np.hypot(*(x - skeleton[0])) for x in (line[0], line[-1]))
            agree = bool(straight < turned)
            found.append((picture, line if agree else line[::-1], skeleton, agree))
    return found


def from_end(line, end, distance):
    """Return the point of a line at a distance from one of its ends, along it."""
    s = arc_length(line)
    at = distance if end == 0 else s[-1] - distance
    return np.array([np.interp(at, s, line[:, 0]), np.interp(at, s, line[:, 1])])


def distances(points, line):
    """Return the distance of each point from a line."""
    start, step = line[:-1], np.diff(line, axis=0)
    part = ((points[:, None] - start) * step).sum(-1) / (step**2).sum(-1)
    nearest = start + np.clip(part, 0, 1)[..., None] * step
    return np.hypot(*(points[:, None] - nearest).transpose(2, 0, 1)).min(axis=1)


def test_nearly_every_frame_gives_a_body():
    assert np.mean([line is not None for line in tracked()[0]]) >= 0.95


def test_the_midline_is_that_of_another_tool_below_half_a_pixel():
    rms = [np.sqrt((distances(skeleton, line) ** 2).mean()) for _, line, skeleton, _ in compared()]
    assert len(rms) >= 0.98 * np.isfinite(crops()[1]).all(axis=(1, 2)).sum()
    assert np.median(rms) <= 0.5


@pytest.mark.parametrize("end", ENDS)
def test_the_ends_are_those_of_another_tool_which_ends_within_the_body(end):
    index, within = ENDS[end]
    off = [
        np.hypot(*(from_end(line, index, within) - skeleton[index]))
        for _, line, skeleton, _ in compared()
    ]
    assert np.median(off) <= 1.0


def test_no_end_is_taken_for_the_other_unless_it_is_said():
    """Which one is the head is not judged: pictures that follow a worm hide where it goes, and the
    tracker may change its mind, never without an exchange that says so."""
    _, exchanged = tracked()
    frames = np.flatnonzero(np.isfinite(crops()[1]).all(axis=(1, 2)))
    agree = [agree for *_, agree in compared()]
    assert len(agree) == len(frames)
    for k in range(1, len(frames)):
        if frames[k] == frames[k - 1] + 1:  # across a coil the other tool tells nothing
            assert (agree[k] != agree[k - 1]) == (frames[k] in exchanged), frames[k]


@pytest.mark.parametrize("end", ENDS)
def test_the_tip_is_where_the_grey_levels_fall_to_half(end):
    """Along the axis through the tip, mean over all frames; the skeletons end short of that."""
    index, _ = ENDS[end]
    t = np.arange(-4.0, 8.01, 0.25)
    beyond = {}
    for which in ("tip", "skeleton"):
        profiles = []
        for crop, line, skeleton, _ in compared():
            curve = line if which == "tip" else skeleton
            near = from_end(curve, index, 3.0)
            axis = (curve[index] - near) / np.hypot(*(curve[index] - near))
            u, v = (curve[index] + t[:, None] * axis).T.astype(np.float32)
            dark = (water(crop) - crop).astype(np.float32)
            profiles.append(cv2.remap(dark, u[None], v[None], cv2.INTER_LINEAR, borderMode=1)[0])
        profile = np.mean(profiles, axis=0)
        # The level just inside the edge: 2.5 px, a quarter of the width.
        edge = next(k for k in range(10, len(t)) if profile[k] < profile[k - 10] / 2)
        beyond[which] = t[edge]
    assert abs(beyond["tip"]) <= 0.5
    assert beyond["skeleton"] >= 1.5
