"""`summary.json`, written and read: every number of a trial, with what it takes to repeat it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from math import degrees, inf, isfinite, isnan, radians
from pathlib import Path
from typing import Any

import numpy as np

from worm_analysis.results import entries
from worm_msgs_py import (
    Chamber,
    Comparison,
    Correlation,
    Geometry,
    ModelQuantity,
    NeededReversal,
    Quantity,
    SourceEvent,
    SourceEventKind,
)
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.errors import RUN_AGAIN, ReportError
from worm_msgs_py.files.corrections import Correction
from worm_msgs_py.files.json_files import read_json
from worm_msgs_py.files.whole_files import whole_file
from worm_msgs_py.limits import RADIUS
from worm_msgs_py.units import MM_PER_M

CHAMBERS = (CHAMBER_A, CHAMBER_B)
RULES, SPEEDS = ("per_cycle", "per_phase", "rate"), ("v_w", "v_b")


@dataclass
class TrialRecord:
    """What is known of a trial at its end, apart from the rows of its tables."""

    frames_read: int = 0
    statuses: dict[str, int] = field(default_factory=dict)
    geometry: Geometry | None = None
    earlier_geometries: list[Geometry] = field(default_factory=list)
    quantities: tuple[Quantity, ...] = ()
    sums: dict[str, Floats] = field(default_factory=dict)
    correlation: Correlation | None = None
    comparison: Comparison | None = None
    model_correlation: Correlation | None = None
    source_events: list[SourceEvent] = field(default_factory=list)
    ignored_messages: dict[str, int] = field(default_factory=dict)
    corrections: list[Correction] = field(default_factory=list)
    frames_swapped: int = 0

    @property
    def why_not_whole(self) -> str:
        """Why the source ended before its time; empty where the trial is whole."""
        early = (e.why for e in self.source_events if e.kind is SourceEventKind.ENDED_EARLY)
        return next(early, "")

    @property
    def what_to_try(self) -> str:
        """What to do where most frames gave no pose for one reason; empty where they did."""
        told = (e.why for e in self.source_events if e.kind is SourceEventKind.WHAT_TO_TRY)
        return next(told, "")

    def take_geometry(self, geometry: Geometry) -> None:
        """Take a version of the rig; the frames before its stamp rest on the one before it."""
        if self.geometry is not None:
            self.earlier_geometries.append(self.geometry)
        self.geometry = geometry


def build_summary(trial: TrialRecord, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document; NaN becomes null, so that it is JSON that every reader takes."""
    summary = {
        "quantities": {quantity.name: _quantity_entry(quantity) for quantity in trial.quantities},
        "geometry": _geometry(trial.geometry),
        "earlier_geometries": [
            {"version": old.version, "stamp_ns": old.stamp_ns} | _geometry(old)
            for old in trial.earlier_geometries
        ],
        "frames": {"read": trial.frames_read, "tracked": 0}
        | dict(sorted(trial.statuses.items(), key=lambda item: item[0])),
        "correlation": _correlation(trial.correlation),
        "model": _model_entry(trial.comparison, trial.model_correlation),
        "provenance": dict(provenance),
        "source_events": [_source_event(event) for event in _in_order(trial.source_events)],
        "ignored_messages": trial.ignored_messages,
        "what_to_try": trial.what_to_try or None,
        "complete": not trial.why_not_whole,
    }
    if trial.why_not_whole:
        summary["why_not_complete"] = trial.why_not_whole
    if trial.corrections:
        summary["corrections"] = {
            "frames_swapped": trial.frames_swapped,
            "applied": [asdict(correction) for correction in trial.corrections],
        }
    finite: dict[str, Any] = _without_nan(summary)
    return finite


def _source_event(event: SourceEvent) -> dict[str, Any]:
    entry = asdict(event)
    del entry["at"]  # what an operator asked for stands among the corrections
    return entry


def _in_order(events: Sequence[SourceEvent]) -> list[SourceEvent]:
    """Return events in an order that does not depend on which of two nodes was heard first."""
    return sorted(events, key=lambda event: (event.frame, event.stamp_ns, event.kind, event.why))


def write_summary(path: Path, summary: Mapping[str, Any]) -> None:
    """Write the document, whole or not at all; the bytes depend on its content alone."""
    text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False)
    with whole_file(path) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")


def _quantity_entry(quantity: Quantity) -> dict[str, Any]:
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
        "depth_mm": geometry.depth_m * MM_PER_M,
        "passage_length_mm": geometry.passage_length_m * MM_PER_M,
    }
    return {chamber.name: _chamber(chamber) | rig for chamber in geometry.chambers}


def _chamber(chamber: Chamber) -> dict[str, float]:
    return {
        "centre_u_px": chamber.centre_u_px,
        "centre_v_px": chamber.centre_v_px,
        "centre_sd_px": chamber.centre_sd_px,
        "radius_px": chamber.radius_px,
        "radius_sd_px": chamber.radius_sd_px,
        "radius_mm": chamber.radius_m * MM_PER_M,
        "exit_deg": degrees(chamber.exit_rad),
        "exit_sd_deg": degrees(chamber.exit_sd_rad),
        "exit_width_mm": chamber.exit_width_m * MM_PER_M,
        "exit_width_sd_mm": chamber.exit_width_sd_m * MM_PER_M,
        "px_per_mm": chamber.px_per_m / MM_PER_M,
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


def _model_entry(comparison: Comparison | None, correlation: Correlation | None) -> Any:
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
    if isinstance(value, float) and not isfinite(value):
        return None
    return value


def read_summary(path: Path) -> Mapping[str, Any]:
    """Read the document.

    Raises
    ------
    ReportError
        Where it is missing, damaged or incomplete.
    """
    try:
        summary: Any = read_json(path)
    except FileNotFoundError:
        raise ReportError(
            f"{path}: not there, so this is no result of a trial: {RUN_AGAIN}"
        ) from None
    except (OSError, ValueError) as error:
        raise ReportError(f"{path}: cannot be read ({error}): {RUN_AGAIN}") from error
    missing = [
        key
        for key in ("quantities", "geometry", "frames", "provenance")
        if not isinstance(summary, dict) or not isinstance(summary.get(key), dict)
    ]
    if missing:
        raise ReportError(f"{path}: lacks {missing[0]!r}: {RUN_AGAIN}")
    if summary.get("complete") is not True and not summary.get("why_not_complete"):
        raise ReportError(f"{path}: says that the results are not complete: {RUN_AGAIN}")
    return dict(summary)


def frames_of(entry: Mapping[str, Any]) -> Mapping[str, int]:
    """Return how many frames there are of each status, and in all."""
    for key in ("read", "tracked"):
        if key not in entry:
            raise KeyError(f"frames.{key}")
    return {entries.name(label): entries.as_count(count) for label, count in entry.items()}


def provenance_of(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the provenance; what it says is text for the page, whatever it is."""
    source = entries.mapping(entry.get("source"))
    parameters = {
        node: entries.mapping(values)
        for node, values in entries.mapping(entry.get("parameters")).items()
    }
    told = {key: str(entry[key]) for key in ("software", "version") if entry.get(key) is not None}
    source = {key: value if value is None else str(value) for key, value in source.items()}
    return {
        **entry,
        "software": None,
        "version": None,
        **told,
        "source": source,
        "parameters": parameters,
    }


def quantity_of(name: str, entry: Mapping[str, Any]) -> Quantity:
    """Return a quantity from its entry."""
    return Quantity(
        entries.name(name),
        entries.number_or_none(entry["value"]),
        entries.number_or_none(entry.get("low")),
        entries.number_or_none(entry.get("high")),
        entries.as_count(entry.get("n")),
        entries.words(entry.get("unit")) or "1",
        entries.number_or_none(entry.get("paper")),
        entries.words(entry.get("why")),
    )


def chamber_of(name: str, entry: Mapping[str, Any]) -> Chamber:
    """Return a chamber from its entry in `summary.json`; KeyError where its circle is missing."""
    return Chamber(
        name=entries.one_of(name, CHAMBERS),
        centre_u_px=entries.as_number(entry["centre_u_px"]),
        centre_v_px=entries.as_number(entry["centre_v_px"]),
        radius_px=entries.as_number(entry["radius_px"]),
        exit_rad=radians(entries.as_number(entry["exit_deg"])),
        radius_m=_radius_mm(entry) / MM_PER_M,
        exit_width_m=entries.as_number(entry.get("exit_width_mm")) / MM_PER_M,
        residual_px=entries.as_number(entry.get("residual_px")),
        centre_sd_px=entries.as_number(entry.get("centre_sd_px")),
        radius_sd_px=entries.as_number(entry.get("radius_sd_px")),
        exit_sd_rad=radians(entries.as_number(entry.get("exit_sd_deg"))),
        exit_width_sd_m=entries.as_number(entry.get("exit_width_sd_mm")) / MM_PER_M,
    )


def depth_mm_of(geometry: Mapping[str, Any]) -> float:
    """Return h; NaN where the summary does not have it."""
    entry: Mapping[str, Any] = next(iter(geometry.values()), {})
    return entries.as_number(entry.get("depth_mm"))


def _radius_mm(entry: Mapping[str, Any]) -> float:
    """Return R: of tracks that came without a picture it is all that is known of the circle."""
    if entry.get("radius_mm") is not None:
        radius_mm = entries.as_number(entry["radius_mm"])
    else:
        radius_mm = entries.as_number(entry["radius_px"]) / entries.as_number(entry["px_per_mm"])
    wrong = "" if isnan(radius_mm) else RADIUS.to("mm").refusal(radius_mm)
    if wrong:
        raise ValueError(f"the radius of a chamber {wrong}")
    return radius_mm


def correlation_of(entry: Mapping[str, Any]) -> Correlation:
    """Return C_θ(t) from its entry; ValueError where the curves differ in length."""
    lag_s = entries.as_numbers(entry["lag_s"])
    unknown = [None] * len(lag_s)
    found = {key: entries.as_numbers(entry.get(key) or unknown) for key in ("c", "error", "fit")}
    pairs = entry.get("pairs") or [0] * len(lag_s)
    for key, values in (*found.items(), ("pairs", pairs)):
        if len(values) != len(lag_s):
            raise ValueError(f"{len(lag_s)} lags of the correlation but {len(values)} of {key}")
    return Correlation(
        lag_s=lag_s,
        c=found["c"],
        error=found["error"],
        pairs=np.array([entries.as_count(count) for count in pairs], dtype=np.int64),
        model=found["fit"],
    )


def comparison_of(entry: Mapping[str, Any]) -> Comparison:
    """Return model against measurement from its entry."""
    fields = (
        "measured",
        "measured_low",
        "measured_high",
        "modelled",
        "modelled_low",
        "modelled_high",
    )
    return Comparison(
        stamp_ns=0,
        parameters=tuple(
            (entries.name(name), entries.as_number(value))
            for name, value in entry["parameters"].items()
        ),
        quantities=tuple(
            ModelQuantity(
                entries.name(name),
                entries.words(item["unit"]),
                **{key: entries.as_number(item.get(key)) for key in fields},
            )
            for name, item in entry["quantities"].items()
        ),
        needs=tuple(_read_need(item) for item in entry.get("needed_reversals") or ()),
        scores=tuple(
            (entries.name(name), entries.as_number(value))
            for name, value in entries.mapping(entry.get("forecasts")).items()
        ),
    )


def _read_need(entry: Mapping[str, Any]) -> NeededReversal:
    low, high = entries.as_number(entry["low"]), entries.as_number(entry["high"])
    return NeededReversal(
        rule=entries.one_of(entry["rule"], RULES),
        speed=entries.one_of(entry["speed"], SPEEDS),
        observation=entries.name(entry["observation"]),
        value=entries.as_number(entry["value"]),
        low=low,
        high=inf if isfinite(low) and not isfinite(high) else high,  # JSON has no infinity
        is_measured=bool(entry["is_measured"]),
    )
