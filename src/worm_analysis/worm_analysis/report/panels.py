"""Which panels a report has, in their order."""

from collections.abc import Callable

from worm_analysis.report.figures.body_angle import body_angle_panel
from worm_analysis.report.figures.direction_correlation import persistence_panel
from worm_analysis.report.figures.first_contact import first_contact
from worm_analysis.report.figures.forecasts import forecasts
from worm_analysis.report.figures.joint_question import joint_question
from worm_analysis.report.figures.model_comparison import model_comparison
from worm_analysis.report.figures.penetration import penetration_depths
from worm_analysis.report.figures.picture_motion import picture_motion, picture_trajectories
from worm_analysis.report.figures.radial_distance import radii
from worm_analysis.report.figures.search_by_width import search_time_by_width, skips_by_width
from worm_analysis.report.figures.search_times import search_times
from worm_analysis.report.figures.speed_and_angle import (
    speed_after_collision,
    speed_against_angle,
    speed_law,
)
from worm_analysis.report.figures.statuses import statuses
from worm_analysis.report.figures.success import success
from worm_analysis.report.figures.time_traces import Example, time_traces, traces
from worm_analysis.report.figures.trajectories import trajectories
from worm_analysis.report.figures.wall_distances import wall_distances
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData, of_trial
from worm_analysis.results import Results

Maker = Callable[[ReportData], Panel]

_POSITIONS: tuple[Maker, ...] = (radii, body_angle_panel)
_MOTION: tuple[Maker, ...] = (
    wall_distances,
    speed_against_angle,
    speed_after_collision,
    speed_law,
    search_times,
)
_BY_WIDTH: tuple[Maker, ...] = (search_time_by_width, skips_by_width)
_MEMORY: tuple[Maker, ...] = (persistence_panel, first_contact)


def all_panels(results: Results) -> list[Panel]:
    """Return every panel of one trial; without a chamber those in the picture come first."""
    data = of_trial(results)
    paper = [
        trajectories(results),
        *(make(data) for make in _POSITIONS),
        time_traces(results),
        *(make(data) for make in (*_MOTION, *_MEMORY, penetration_depths)),
    ]
    if not results.chambers:
        own = [picture_trajectories(results), picture_motion(results), statuses(results)]
        return [*own, *paper, *_model(results)]
    return [*paper, *_model(results), statuses(results)]


def single_panels(results: Results) -> list[Panel]:
    """Return what a single trial's report has beyond a pool's."""
    return [trajectories(results), *_model(results), statuses(results)]


def _model(results: Results) -> list[Panel]:
    """Return what the boundary walk says beside a trial."""
    return [make(results) for make in (model_comparison, joint_question, forecasts)]


def pooled_panels(data: ReportData, examples: list[Example]) -> list[Panel]:
    """Return every figure of the paper from a pool of trials."""
    return [
        *(make(data) for make in _POSITIONS),
        traces(examples),
        *(make(data) for make in (*_MOTION, *_BY_WIDTH, *_MEMORY, success, penetration_depths)),
    ]
