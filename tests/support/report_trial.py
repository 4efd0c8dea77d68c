"""Results directories for tests of the report: a simulated worm, analysed and recorded for real."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from worm_analysis.analysis import Analysis
from worm_bringup.recorder.recording import Recording
from worm_model.simulator.head_path import Walker
from worm_model.simulator.worm import midlines_mm
from worm_msgs_py import (
    BodyState,
    Chamber,
    Comparison,
    Correlation,
    Geometry,
    Keypoint,
    Midline,
    ModelQuantity,
    Observables,
    Status,
    Where,
)

CHAMBER = Chamber(
    name="chamber_a",
    centre_u_px=507.4,
    centre_v_px=515.6,
    radius_px=400.0,
    exit_rad=np.radians(147.0),
    radius_m=0.01,
    exit_width_m=0.002,
    residual_px=0.31,
    centre_sd_px=0.02,
    radius_sd_px=0.02,
    exit_sd_rad=0.002,
)
PROVENANCE = {
    "software": "worm-escape",
    "version": "0.1.0",
    "source": {"bag": "walker", "sha256": "0" * 64, "topic": "image_raw"},
    "parameters": {"tracker": {"polarity": "dark"}, "analysis": {"contact_factor": 0.3}},
}
SPARE = 5
"""Every so many hundred frames a few have no worm, as in a real film."""


@cache
def midlines(duration_s: float, fps: float, seed: int) -> tuple[np.ndarray, ...]:
    """Return the simulated worm's midlines, mm, head first."""
    walker = Walker(seed=seed, speed_mm_s=4.0, reversal_per_cycle=0.1, length_mm=12.0)
    return tuple(midlines_mm(walker, 10.0, duration_s, fps))


def states(
    duration_s: float = 80.0, fps: float = 12.0, seed: int = 3, *, mirrored: bool = False
) -> list[tuple[BodyState, Midline]]:
    """Return what a tracker without error says of the simulated worm.

    Parameters
    ----------
    duration_s, fps, seed
        Length of the trial, frames per second, which worm.
    mirrored : bool
        Whether the chamber is seen in a mirror: y of its frame changes its sign.
    """
    found = []
    for frame, midline_mm in enumerate(midlines(duration_s, fps, seed)):
        x_m, y_m = midline_mm.T * 1e-3 * ([[1], [-1]] if mirrored else [[1], [1]])
        found.append(_state(frame, round(frame * 1e9 / fps), x_m, y_m))
    return found


def _state(frame: int, stamp_ns: int, x_m: np.ndarray, y_m: np.ndarray):
    if frame % 400 in range(390, 390 + SPARE):
        return BodyState(frame, stamp_ns, status=Status.NO_WORM), Midline.empty()
    u, v = CHAMBER.to_pixels(x_m, y_m)
    s = np.r_[0.0, np.cumsum(np.hypot(np.diff(u), np.diff(v)))]
    tenth = int(np.searchsorted(s, 0.1 * s[-1]))

    def keypoint(x, y, yaw):
        place = CHAMBER.to_pixels(float(x), float(y))
        return Keypoint(*place, float(x), float(y), float(yaw))

    x_c, y_c = x_m.mean(), y_m.mean()
    yaw = np.arctan2(y_m[0] - y_m[tenth], x_m[0] - x_m[tenth])
    state = BodyState(
        frame=frame,
        stamp_ns=stamp_ns,
        frame_id=CHAMBER.name,
        where=Where.CHAMBER_A,
        status=Status.TRACKED,
        geometry=1,
        confidence=0.97,
        head_certainty=0.99,
        head=keypoint(x_m[0], y_m[0], yaw),
        centroid=keypoint(x_c, y_c, np.arctan2(y_m[0] - y_c, x_m[0] - x_c)),
        tail=keypoint(x_m[-1], y_m[-1], 0.0),
        length_px=float(s[-1]),
        width_px=16.0,
        length_m=float(s[-1]) / CHAMBER.px_per_m,
        width_m=16.0 / CHAMBER.px_per_m,
    )
    return state, Midline(u, v, x_m, y_m, s, np.full(len(u), 16.0))


def without_chamber(
    trial: list[tuple[BodyState, Midline]],
) -> list[tuple[BodyState, Midline]]:
    """Return the same trial as seen where there is no chamber: pixels alone."""
    nan = float("nan")

    def point(keypoint: Keypoint) -> Keypoint:
        return replace(keypoint, x_m=nan, y_m=nan)

    return [
        (
            replace(
                state,
                frame_id="camera_optical_frame",
                where=Where.UNKNOWN,
                geometry=0,
                head=point(state.head),
                centroid=point(state.centroid),
                tail=point(state.tail),
                length_m=nan,
                width_m=nan,
            ),
            midline,
        )
        for state, midline in trial
    ]


def record(
    directory: Path,
    trial: list[tuple[BodyState, Midline]],
    *,
    chamber: bool = True,
    comparison: Comparison | None = None,
    model_correlation: Correlation | None = None,
) -> Path:
    """Analyse a trial and write its results directory with the recorder's own writer."""
    directory.mkdir(parents=True)
    analysis, recording = Analysis(), Recording(directory)
    geometry = Geometry(1, 0, 1024, 1024, (CHAMBER,)) if chamber else None
    if geometry is not None:
        analysis.set_geometry(geometry)
    for state, midline in trial:
        observables, events = analysis.push(state)
        assert isinstance(observables, Observables)
        recording.add_state(state)
        recording.add_midline(midline)
        recording.add_observables(observables)
        recording.add_events(events)
    recording.add_events(analysis.finish())
    recording.trial.frames_read = len(trial)
    recording.trial.geometry = geometry
    recording.trial.quantities = tuple(analysis.summary())
    recording.trial.sums = analysis.sums()
    recording.trial.correlation = analysis.correlation()
    recording.trial.comparison = comparison
    recording.trial.model_correlation = model_correlation
    recording.finish(PROVENANCE)
    return directory


def telegraph_walk(rate_1_s: float) -> tuple[Comparison, Correlation]:
    """Return a comparison as the model node gives it, with a direction that turns at a rate."""
    lag_s = np.linspace(0.0, 120.0, 121)
    unknown = np.full(len(lag_s), np.nan)
    correlation = Correlation(
        lag_s, np.exp(-2 * rate_1_s * lag_s), unknown, np.zeros(len(lag_s), np.int64), unknown
    )
    comparison = Comparison(
        stamp_ns=0,
        parameters=(
            ("R_m", 0.01), ("v_m_s", 0.00202), ("mean_slide_m", 0.002), ("reversal", 0.3),
            ("rule_per_cycle", 1.0), ("rule_rate", 0.0), ("hop_may_land", 0.0), ("walks", 2000.0),
            ("d_c_is_measured", 1.0), ("reversal_per_cycle_is_measured", 0.0),
        ),
        quantities=(
            ModelQuantity("tau_h", "s", modelled=50.0, modelled_low=49.0, modelled_high=51.0),
            ModelQuantity("n_s", "per 30 min", 10.0, 5.0, 20.0, 12.0, 11.0, 13.0),
            ModelQuantity("d_c", "m", 0.0020, 0.0016, 0.0025, 0.0020),
            ModelQuantity("t_per", "s", 8.0, 5.0, 12.0, 1 / (2 * rate_1_s)),
        ),
    )  # fmt: skip
    return comparison, correlation
