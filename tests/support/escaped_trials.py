"""Results directories of worms of known laws, analysed for real, for tests of what pools them."""

from pathlib import Path

from escaping_worm import Worm, escaping_worm, write_table

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.tracks.track_analysis import analyse_tracks
from worm_bringup.tracks.track_rig import TableRig
from worm_bringup.tracks.track_table import TrackTable


def escaped_trial(
    directory: Path,
    worm: Worm,
    duration_s: float = 300.0,
    *,
    radius_mm: float = 10.0,
    mirrored: bool = False,
) -> Path:
    """Analyse a worm's tracks into a results directory, without a report."""
    directory.mkdir(parents=True)
    columns = escaping_worm(worm, duration_s, fps=12.0)
    if mirrored:
        columns = {n: -v if n.endswith(("_y_mm", "_yaw_deg")) else v for n, v in columns.items()}
    table = write_table(directory.with_suffix(".parquet"), columns)
    rig = TableRig(radius_mm=radius_mm, exit_width_mm=worm.exit_width_mm)
    analyse_tracks(TrackTable(table), rig, AnalysisParameters(), directory)
    return directory
