"""Which panels a report has, in their order."""

from collections.abc import Callable

from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.figures.body_angle import body_angle_panel
from worm_analysis.report.figures.direction_correlation import persistence_panel
from worm_analysis.report.figures.first_contact import first_contact
from worm_analysis.report.figures.forecasts import forecasts
from worm_analysis.report.figures.joint_question import joint_question, joint_questions
from worm_analysis.report.figures.model_comparison import model_comparison
from worm_analysis.report.figures.penetration import penetration_depths
from worm_analysis.report.figures.picture_motion import picture_motion, picture_trajectories
from worm_analysis.report.figures.radial_distance import radii
from worm_analysis.report.figures.search_by_width import search_time_by_width, skips_by_width
from worm_analysis.report.figures.search_times import search_times
from worm_analysis.report.figures.sensitivity import sensitivity
from worm_analysis.report.figures.speed_and_angle import (
    speed_after_collision,
    speed_against_angle,
    speed_law,
)
from worm_analysis.report.figures.statuses import statuses
from worm_analysis.report.figures.success import success
from worm_analysis.report.figures.time_course import time_course
from worm_analysis.report.figures.time_traces import Example, time_traces, traces
from worm_analysis.report.figures.trajectories import trajectories
from worm_analysis.report.figures.trial_picture import trial_picture
from worm_analysis.report.figures.wall_distances import wall_distances
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData, of_trial
from worm_analysis.results import Results
from worm_analysis.results.picture import TrialPicture

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


def opening_panels(results: Results, picture: TrialPicture | None) -> list[Panel]:
    """Return what a trial's report begins with: what was filmed, where it went, and when.

    Up to 90 s the examples against time are the whole trial.
    """
    first = trial_picture(results, picture)
    if not results.chambers:
        return [first, picture_trajectories(results), picture_motion(results)]
    return [first, trajectories(results), time_traces(results) if _is_short(results)
            else time_course(results)]  # fmt: skip


def trial_panels(results: Results) -> list[Panel]:
    """Return every other panel of one trial."""
    data = of_trial(results)
    shown = [] if results.chambers else [trajectories(results)]
    examples = [] if results.chambers and _is_short(results) else [time_traces(results)]
    return [
        *shown,
        *(make(data) for make in _POSITIONS),
        *examples,
        *(make(data) for make in (*_MOTION, *_MEMORY, penetration_depths, sensitivity)),
        *_model_panels(results),
        statuses(results),
    ]


def _is_short(results: Results) -> bool:
    return not len(results.t_s) or float(results.t_s[-1]) <= FIGURES.whole_s


def single_panels(results: Results) -> list[Panel]:
    """Return what a single trial's report has beyond a pool's and its opening."""
    return [*_model_panels(results), statuses(results)]


def _model_panels(results: Results) -> list[Panel]:
    """Return what the boundary walk says beside a trial."""
    return [make(results) for make in (model_comparison, joint_question, forecasts)]


def pooled_panels(data: ReportData, examples: list[Example]) -> list[Panel]:
    """Return every figure of the paper from a pool of trials."""
    return [
        *(make(data) for make in _POSITIONS),
        traces(examples),
        *(make(data) for make in (*_MOTION, *_BY_WIDTH, *_MEMORY, success, penetration_depths)),
        sensitivity(data),
        *joint_questions(data),
    ]
