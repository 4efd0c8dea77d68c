"""Keeps one picture of a trial beside its tracks, for its report to open with."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import cv2

from worm_analysis.results import read_results
from worm_analysis.results.picture import row_to_show
from worm_msgs_py.errors import BadInput, BadPicture, ReportError
from worm_msgs_py.files.frame_pictures import frame_picture_path, frame_pictures
from worm_msgs_py.files.whole_files import whole_file
from worm_tracker.sources.bags.one_picture import open_bag_of, picture_at
from worm_tracker.sources.image_decoder import MAX_MEGAPIXELS


def keep_picture(results_dir: Path, source: Mapping[str, Any]) -> str:
    """Keep the trial's best picture, read again from where the pictures came from.

    Parameters
    ----------
    results_dir : Path
        Whole results, but for the report.
    source : mapping
        Parameters of the node that sent the pictures: the bag that it played, or recorded, or that
        it kept some of them in `results_dir` (`pictures`); but for one these are removed.

    Returns
    -------
    str
        Why there is no picture; empty where it is written. The results are as good without one.
    """
    bag = source.get("bag") or source.get("record")
    if not bag:
        return _keep_best(results_dir)
    try:
        results = read_results(results_dir)
        row = row_to_show(results)
        if row is None:
            return "no frame has a pose"
        offset_s = float(source.get("start_offset") or 0.0)
        grey = picture_at(
            partial(open_bag_of, Path(bag), source),
            int(results.tracks["stamp_ns"][row]),
            offset_s + float(results.t_s[row]),
            float(source.get("max_megapixels", MAX_MEGAPIXELS)),
        )
        path = frame_picture_path(results_dir, int(results.tracks["frame"][row]))
        with whole_file(path) as unfinished:
            unfinished.write_bytes(cv2.imencode(".png", grey)[1].tobytes())
    except (BadInput, BadPicture, ReportError, OSError) as error:
        return str(error)
    return ""


def _keep_best(results_dir: Path) -> str:
    """Leave the best of the pictures that are there."""
    there = frame_pictures(results_dir)
    if not there:
        return "the pictures were not recorded"
    frame = None
    try:
        results = read_results(results_dir)
        row = row_to_show(results, there)
        frame = None if row is None else int(results.tracks["frame"][row])
    except ReportError as error:
        return str(error)
    finally:
        for other in there.keys() - {frame}:
            there[other].unlink(missing_ok=True)
    return "no frame that was kept has a pose" if frame is None else ""
