"""`summary.json`: every number of the trial, with what it takes to trust and to repeat it."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from worm_msgs_py import (
    Chamber,
    Comparison,
    Correlation,
    Geometry,
    Quantity,
    SourceEvent,
    SourceEventKind,
)
from worm_msgs_py.whole_files import whole_file


@dataclass
class Trial:
    """What the recorder has gathered about a trial, apart from its rows."""

    frames_read: int = 0
    statuses: dict[str, int] = field(default_factory=dict)
    geometry: Geometry | None = None
    earlier_geometries: list[Geometry] = field(default_factory=list)
    quantities: tuple[Quantity, ...] = ()
    correlation: Correlation | None = None
    comparison: Comparison | None = None
    model_correlation: Correlation | None = None
    source_events: list[SourceEvent] = field(default_factory=list)
    ignored_messages: dict[str, int] = field(default_factory=dict)

    @property
    def why_not_whole(self) -> str:
        """Why the source ended before its time; empty where the trial is whole."""
        early = (e.why for e in self.source_events if e.kind is SourceEventKind.ENDED_EARLY)
        return next(early, "")

    def take_geometry(self, geometry: Geometry) -> None:
        """Take a version of the rig; the frames before its stamp rest on the one before it."""
        if self.geometry is not None:
            self.earlier_geometries.append(self.geometry)
        self.geometry = geometry


def build_summary(trial: Trial, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document; NaN becomes null, so that it is JSON that every reader takes."""
    summary = {
        "quantities": {quantity.name: _quantity(quantity) for quantity in trial.quantities},
        "geometry": _geometry(trial.geometry),
        "earlier_geometries": [
            {"version": old.version, "stamp_ns": old.stamp_ns} | _geometry(old)
            for old in trial.earlier_geometries
        ],
        "frames": {"read": trial.frames_read, "tracked": 0}
        | dict(sorted(trial.statuses.items(), key=lambda item: item[0])),
        "correlation": _correlation(trial.correlation),
        "model": _model(trial.comparison, trial.model_correlation),
        "provenance": dict(provenance),
        "source_events": [asdict(event) for event in _in_order(trial.source_events)],
        "ignored_messages": trial.ignored_messages,
        "complete": not trial.why_not_whole,
    }
    if trial.why_not_whole:
        summary["why_not_complete"] = trial.why_not_whole
    finite: dict[str, Any] = _without_nan(summary)
    return finite


def _in_order(events: Sequence[SourceEvent]) -> list[SourceEvent]:
    """Return events in an order that does not depend on which of two nodes was heard first."""
    return sorted(events, key=lambda event: (event.frame, event.stamp_ns, event.kind, event.why))


def write_summary(path: Path, summary: Mapping[str, Any]) -> None:
    """Write the document, whole or not at all; the bytes depend on its content alone."""
    text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False)
    with whole_file(path) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")


def _quantity(quantity: Quantity) -> dict[str, Any]:
    entry = {
        "value": quantity.value,
        "low": quantity.low,
        "high": quantity.high,
        "n": quantity.n,
        "unit": quantity.unit,
        "paper": quantity.paper,
    }
    if quantity.value is None:
        entry["why"] = quantity.why
    return entry


def _geometry(geometry: Geometry | None) -> dict[str, Any]:
    if geometry is None:
        return {}
    rig = {
        "depth_mm": geometry.depth_m * 1e3,
        "passage_length_mm": geometry.passage_length_m * 1e3,
    }
    return {chamber.name: _chamber(chamber) | rig for chamber in geometry.chambers}


def _chamber(chamber: Chamber) -> dict[str, float]:
    return {
        "centre_u_px": chamber.centre_u_px,
        "centre_v_px": chamber.centre_v_px,
        "centre_sd_px": chamber.centre_sd_px,
        "radius_px": chamber.radius_px,
        "radius_sd_px": chamber.radius_sd_px,
        "radius_mm": chamber.radius_m * 1e3,
        "exit_deg": math.degrees(chamber.exit_rad),
        "exit_sd_deg": math.degrees(chamber.exit_sd_rad),
        "exit_width_mm": chamber.exit_width_m * 1e3,
        "exit_width_sd_mm": chamber.exit_width_sd_m * 1e3,
        "px_per_mm": chamber.px_per_m / 1e3,
        "residual_px": chamber.residual_px,
    }


def _correlation(correlation: Correlation | None) -> dict[str, Sequence[float]] | None:
    if correlation is None:
        return None
    return {
        "lag_s": correlation.lag_s.tolist(),
        "c": correlation.c.tolist(),
        "error": correlation.error.tolist(),
        "pairs": correlation.pairs.tolist(),
        "fit": correlation.model.tolist(),
    }


def _model(comparison: Comparison | None, correlation: Correlation | None) -> Any:
    if comparison is None:
        return None
    return {
        "parameters": dict(comparison.parameters),
        "quantities": {
            quantity.name: {
                "unit": quantity.unit,
                "measured": quantity.measured,
                "measured_low": quantity.measured_low,
                "measured_high": quantity.measured_high,
                "modelled": quantity.modelled,
                "modelled_low": quantity.modelled_low,
                "modelled_high": quantity.modelled_high,
            }
            for quantity in comparison.quantities
        },
        "needed_reversals": [asdict(need) for need in comparison.needs],
        "forecasts": dict(comparison.scores),
        "correlation": None
        if correlation is None
        else {"lag_s": correlation.lag_s.tolist(), "c": correlation.c.tolist()},
    }


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
