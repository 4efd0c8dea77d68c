"""Corrections that a replay is given: whether they fit what is played, and how it is tracked."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from worm_analysis.results.summary import read_summary
from worm_msgs_py.errors import BadInput, ReportError
from worm_msgs_py.files.corrections import Correction
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.corrected_frames import check_corrections


def check_fit(
    file: Path | None, corrected: tuple[Correction, ...], player: Mapping[str, Any]
) -> None:
    """Refuse corrections that are not of what will be played.

    Raises
    ------
    BadInput
        They are of another recording.
    """
    with BagPictures(
        Path(player["bag"]),
        player["topic"] or None,
        start_offset_s=player["start_offset"],
        playback_duration_s=player.get("playback_duration"),
        salvage=player["salvage"],
        max_chunk_mib=player["max_chunk_mib"],
        max_megapixels=player["max_megapixels"],
    ) as pictures:
        try:
            check_corrections(corrected, pictures)
        except BadInput as error:
            raise BadInput(f"{file}: {error}") from None


def other_settings(given: Path | None, tracker: Mapping[str, Any]) -> str:
    """Say where corrections were made on results of a tracker that was set otherwise.

    They exchange the ends that the tracker tells, and set otherwise it may tell others.

    Parameters
    ----------
    given : Path
        What the corrections were read from: only results say how they were made.
    tracker : mapping
        Its parameters now; None, or NaN as in a summary, is not given.

    Returns
    -------
    str
        A line for people; empty where nothing differs, or it is not known.
    """
    if given is None or not given.is_dir():
        return ""
    try:
        provenance = read_summary(given / "summary.json")["provenance"]
    except ReportError:
        return ""
    before = provenance.get("parameters", {}).get("tracker", {})
    differ = [
        f"{name} was {before[name]}, is {value}"
        for name, value in tracker.items()
        if name in before and before[name] != _as_kept(value)
    ]
    if not differ:
        return ""
    return (
        f"{given}: was looked at as tracked with other parameters ({'; '.join(differ)}): the "
        "corrections exchange what is told now, so look at the new results again"
    )


def _as_kept(value: Any) -> Any:
    """Return a value as a summary keeps it: NaN is null."""
    return None if value != value else value
