"""Which panels a report has, in their order."""

from collections.abc import Callable

from worm_analysis.report.body_angle import body_angle
from worm_analysis.report.model_comparison import model_comparison
from worm_analysis.report.panel import Panel
from worm_analysis.report.persistence import persistence
from worm_analysis.report.picture_motion import picture_motion, picture_trajectories
from worm_analysis.report.radii import radii
from worm_analysis.report.statuses import statuses
from worm_analysis.report.tables import Results
from worm_analysis.report.time_traces import time_traces
from worm_analysis.report.trajectories import trajectories
from worm_analysis.report.wall_distances import wall_distances

PAPER = (trajectories, radii, body_angle, time_traces, wall_distances, persistence)
WITHOUT_CHAMBER = (picture_trajectories, picture_motion)


def all_panels(results: Results) -> list[Panel]:
    """Return every panel; without a chamber those in the picture come first."""
    makers: tuple[Callable[[Results], Panel], ...] = (*PAPER, model_comparison, statuses)
    if not results.chambers:
        makers = (*WITHOUT_CHAMBER, statuses, *PAPER, model_comparison)
    return [make(results) for make in makers]
