"""Analyses a table of tracks without a graph: the same core, the same files as `worm replay`."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.results import contacts, passages, tracks
from worm_analysis.results.parquet_table import Row, TableWriter, table_writer
from worm_analysis.results.summary import TrialRecord, build_summary, write_summary
from worm_analysis.results.sums import write_sums
from worm_analysis.summary.quantities import DEFINITIONS
from worm_bringup.provenance import file_hash, provenance
from worm_bringup.tracks.missing_rows import MissingRows
from worm_bringup.tracks.track_rig import Placed, Placer, TableRig
from worm_bringup.tracks.track_table import Rows, TrackTable
from worm_model.inference.comparison import ModelParameters
from worm_model.inference.trial_model import TrialModel
from worm_msgs_py import (
    Attempt,
    BodyState,
    Episode,
    Event,
    Geometry,
    Keypoint,
    Observables,
    Quantity,
    Status,
    Where,
)
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.errors import BadInput
from worm_msgs_py.units import MM_PER_M

STRAY_RADIUS = 1.1
"""Heads farther from the centre than this, in units of R, are not in the chamber that they say."""
MOST_STRAY = 0.5
MODEL = ModelParameters()
_NO_CENTROID = "the tracks have no centroid: give centroid_x_mm and centroid_y_mm"
_NO_WIDTH = "d_w is not known: give a column width_mm, or --body-width-mm"
_NO_EXIT = "W is not known: give --exit-width-mm"
_NEEDS: dict[str, tuple[str, ...]] = {
    _NO_CENTROID: (
        "r_c_over_R", "psi_b_negative_peak", "psi_b_positive_peak", "v_w", "success",
        "failures_without_contact", "failures_in_elongation", "beta",
    ),
    _NO_WIDTH: (
        "contact_fraction", "d_c", "d_nc", "delta_r_h", "reversal_per_cycle", "tau_h", "n_s",
        "failures_without_contact", "d_w",
    ),
    _NO_EXIT: ("tau_h", "n_s", "w_s", "beta"),
    "the tracks have no tail: give tail_x_mm and tail_y_mm": ("r_t_over_R",),
    "the tracks have no length: give a column length_mm": ("l_w", "failures_in_elongation"),
}  # fmt: skip
"""What cannot be had without a part of the table, and what to do about it."""


def analyse_tracks(
    table: TrackTable,
    rig: TableRig,
    parameters: AnalysisParameters,
    out: Path,
    progress: Callable[[int, int | None], None] = lambda done, total: None,
    *,
    source: Mapping[str, Any] | None = None,
    metadata: Mapping[str, Any] | None = None,
    rounded: bool = False,
) -> None:
    """Write tracks, contacts, passages and the summary into a directory that is there.

    Parameters
    ----------
    table : TrackTable
    rig : TableRig
        What the table does not say.
    parameters : AnalysisParameters
    out : Path
        An empty directory.
    progress : callable
        Given the rows that are done, and of how many, where that is known.
    source : mapping, optional
        What the tracks come from, for the summary; the table's name and hash where not given.
    metadata : mapping, optional
        What the lab has noted of the trial.
    rounded : bool
        Whether each frame's observables are written in whole steps; what is averaged is not.

    Raises
    ------
    BadInput
        Where the table cannot be used.
    """
    run = _TableRun(rig, parameters, out, rounded=rounded)
    placer = Placer(rig)
    with run.tracks, run.contacts, run.passages:
        for rows in table.rows():
            run.take(rows, placer.place(rows))
            progress(run.rows, None)
        run.finish()
    run.refuse_strangers(table.path)
    lacking = _lacking(table, rig, parameters)
    trial = run.record(lacking)
    write_sums(out / "sums.parquet", _without_lacking(run.analysis.sums(), lacking))
    source = source or {"table": table.path.name, "sha256": file_hash(table.path)}
    settings = {"rig": _rig_provenance(rig), "analysis": asdict(parameters), "model": asdict(MODEL)}
    document = provenance(source, settings) | ({"trial": dict(metadata)} if metadata else {})
    write_summary(out / "summary.json", build_summary(trial, document))


class _TableRun:
    """What grows while the rows go through the analysis."""

    def __init__(self, rig: TableRig, parameters: AnalysisParameters, out: Path, *, rounded: bool):
        self._rig = rig
        self._geometry = geometry = rig.geometry()
        self.analysis = Analysis(parameters)
        self.analysis.set_geometry(geometry)
        self._model = TrialModel(MODEL)
        self._model.set_geometry(geometry)
        self.tracks = TrackWriter(out / "tracks.parquet", rounded=rounded)
        self.contacts = TableWriter(out / "contacts.parquet", contacts.SCHEMA)
        self.passages = TableWriter(out / "passages.parquet", passages.SCHEMA)
        self._statuses: Counter[str] = Counter()
        self._chambers: set[str] = set()
        self.rows = self._heads = self._strays = self._last_ns = 0
        self._has_centroid = False
        self._missing = MissingRows()

    def take(self, rows: Rows, placed: Placed) -> None:
        """Analyse some rows and write them."""
        self._missing.take(rows.stamp_ns)
        self._has_centroid |= bool(np.isfinite(placed.x_mm["centroid"]).any())
        found = []
        for state in states_of(rows, placed):
            observables, events = self.analysis.push(state)
            self._model.take_state(observables)
            found.append(observables)
            if events:
                self._write(events)
        self.tracks.write(rows, placed, found, has_picture=self._rig.has_picture)
        self._count(placed)
        self.rows += len(rows)
        self._last_ns = int(rows.stamp_ns[-1])

    def finish(self) -> None:
        """End the trial."""
        self._write(self.analysis.finish())

    def record(self, lacking: Sequence[str]) -> TrialRecord:
        """Return what `summary.json` says of the trial, which is over."""
        quantities = _with_reasons(self.analysis.summary(), lacking)
        trial = TrialRecord(
            frames_read=self.rows,
            statuses=dict(self._statuses),
            geometry=_seen(self._geometry, self._chambers, self._rig),
            quantities=tuple(quantities),
            correlation=self.analysis.correlation(),
            source_events=self._missing.events(),
        )
        self._model.take_summary(quantities, self._last_ns)
        compared = self._model.finish()
        if compared is not None:
            trial.comparison, trial.model_correlation = compared
        return trial

    def refuse_strangers(self, path: Path) -> None:
        """Refuse tracks of which no row, or hardly one, has its head in the rig."""
        if self._heads == 0:
            raise BadInput(f"{path}: no row has a head: fill head_x_mm and head_y_mm")
        if self._strays > MOST_STRAY * self._heads:
            radius_mm = self._geometry.chambers[0].radius_m * MM_PER_M
            raise BadInput(
                f"{path}: {self._strays} of {self._heads} heads are outside of the chamber (R = "
                f"{radius_mm:g} mm, centre at 0, 0): say with --radius-mm, --centre-mm and "
                "--exit-deg, or with --circle-px, where it is"
            )

    def _write(self, events: Sequence[Event]) -> None:
        for event in events:
            if isinstance(event, Episode):
                self.contacts.append(contacts.contact_row(event))
            else:
                self.passages.append(self._passage_row(event))
            if self._has_centroid or not isinstance(event, Attempt):
                self._model.take_event(event)

    def _passage_row(self, event: Any) -> Row:
        row = passages.passage_row(event)
        if isinstance(event, Attempt) and not self._has_centroid:  # nobody saw the body follow
            return {**row, "success": None, "complete": False}
        return row

    def _count(self, placed: Placed) -> None:
        codes, counts = np.unique(placed.status, return_counts=True)
        for code, count in zip(codes, counts, strict=True):
            self._statuses[Status(int(code)).label] += int(count)
        x, y = placed.x_mm["head"], placed.y_mm["head"]
        inside = (placed.where == Where.CHAMBER_A) | (placed.where == Where.CHAMBER_B)
        r_mm, most_mm = (
            np.hypot(x, y),
            STRAY_RADIUS * self._geometry.chambers[0].radius_m * MM_PER_M,
        )
        strayed = r_mm > np.where(
            inside, most_mm, most_mm + self._geometry.passage_length_m * MM_PER_M
        )
        self._heads += int(np.count_nonzero(np.isfinite(r_mm)))
        self._strays += int(np.count_nonzero(strayed))
        for code in np.unique(placed.where[inside]):
            self._chambers.add(Where(int(code)).label)


def states_of(rows: Rows, placed: Placed) -> Iterator[BodyState]:
    """Yield the rows as the tracker would give them."""
    points = [_keypoints(placed, point) for point in KEYPOINTS]
    where = [Where(code) for code in range(len(Where))]
    status = {int(member): member for member in Status}
    names = (CHAMBER_A, CHAMBER_B)
    columns = (
        rows.frame.tolist(),
        rows.stamp_ns.tolist(),
        placed.in_b.tolist(),
        placed.where.tolist(),
        placed.status.tolist(),
        _trusted(rows, "confidence").tolist(),
        _trusted(rows, "head_certainty").tolist(),
        *points,
        rows.column("length_px").tolist(),
        rows.column("width_px").tolist(),
        (rows.column("length_mm") / MM_PER_M).tolist(),
        (rows.column("width_mm") / MM_PER_M).tolist(),
        (rows.values.get("head_sd_mm", np.zeros(len(rows))) / MM_PER_M).tolist(),
    )
    for frame, stamp_ns, in_b, place, code, *rest in zip(*columns, strict=True):
        yield BodyState(frame, stamp_ns, names[in_b], where[place], status[code], 1, *rest)


def _trusted(rows: Rows, name: str) -> Any:
    """Return how far to trust each row: wholly, where the tracks say nothing about it."""
    return rows.values.get(name, np.ones(len(rows)))


def _keypoints(placed: Placed, point: str) -> Iterator[Keypoint]:
    x, y = placed.x_mm[point], placed.y_mm[point]
    if not np.isfinite(x).any():
        none = Keypoint()
        return iter([none] * len(x))
    yaw = np.radians(placed.yaw_deg[point])
    columns = (placed.u_px[point], placed.v_px[point], x / MM_PER_M, y / MM_PER_M, yaw)
    return map(Keypoint, *(column.tolist() for column in columns))


_ROUNDED_COMPRESSION_LEVEL = 15
"""Rounded tables are small, and kept in large numbers."""


class TrackWriter:
    """Writes `tracks.parquet` by columns, some ten thousand rows at a time."""

    def __init__(self, path: Path, *, rounded: bool = False):
        level = _ROUNDED_COMPRESSION_LEVEL if rounded else 1
        self._writer = table_writer(path, tracks.SCHEMA, compression_level=level)
        self._rounded = rounded

    def write(
        self, rows: Rows, placed: Placed, found: Sequence[Observables], *, has_picture: bool
    ) -> None:
        """Write rows with what the analysis says of each."""
        columns: dict[str, Any] = {
            "stamp_ns": rows.stamp_ns,
            "frame": rows.frame,
            "where": _labels(Where, placed.where),
            "status": _labels(Status, placed.status),
        }
        for name in ("confidence", "head_certainty", "length_mm", "width_mm", "length_px"):
            columns[name] = rows.column(name)
        columns["width_px"] = rows.column("width_px")
        columns["head_sd_mm"] = rows.values.get("head_sd_mm")
        for point in KEYPOINTS:
            columns[f"{point}_x_mm"] = placed.x_mm[point]
            columns[f"{point}_y_mm"] = placed.y_mm[point]
            columns[f"{point}_yaw_deg"] = placed.yaw_deg[point]
            if has_picture:
                columns[f"{point}_u_px"] = placed.u_px[point]
                columns[f"{point}_v_px"] = placed.v_px[point]
        columns |= tracks.observed_columns(found, rounded=self._rounded)
        if rows.midline is not None:
            columns |= {name: rows.midline.column(name) for name in rows.midline.column_names}
        arrays = [_array(columns.get(field.name), field.type, len(rows)) for field in tracks.SCHEMA]
        self._writer.write_table(pa.table(arrays, schema=tracks.SCHEMA))

    def __enter__(self) -> "TrackWriter":
        return self

    def __exit__(self, *error: object) -> None:
        self._writer.close()


def _array(values: Any, kind: Any, rows: int) -> Any:
    if values is None:
        return pa.nulls(rows, kind)
    if isinstance(values, pa.ChunkedArray):
        return values.cast(kind)
    return pa.array(values, kind)


def _labels(kind: Any, codes: Any) -> Any:
    members = {int(member): member.label for member in kind}
    words = np.array([members.get(code, "") for code in range(max(members) + 1)], dtype=object)
    return words[codes]


def _lacking(table: TrackTable, rig: TableRig, parameters: AnalysisParameters) -> list[str]:
    geometry = rig.geometry()
    has = {
        _NO_CENTROID: table.has_point("centroid"),
        _NO_WIDTH: "width_mm" in table.columns or parameters.body_width_m is not None,
        _NO_EXIT: isfinite(geometry.chambers[0].exit_width_m),
    }
    tail, length = list(_NEEDS)[-2:]
    has |= {tail: table.has_point("tail"), length: "length_mm" in table.columns}
    return [why for why, there in has.items() if not there]


def _with_reasons(quantities: Sequence[Quantity], lacking: Sequence[str]) -> list[Quantity]:
    """Return the numbers, without those that what is lacking makes meaningless."""
    why = {name: reason for reason in reversed(lacking) for name in _NEEDS[reason]}
    return [
        Quantity(q.name, None, n=q.n, unit=q.unit, paper=q.paper, why=why[q.name])
        if q.name in why
        else q
        for q in quantities
    ]


def _without_lacking(sums: Mapping[str, Floats], lacking: Sequence[str]) -> dict[str, Floats]:
    """Return the sums, without those of the numbers that what is lacking makes meaningless."""
    meaningless = {DEFINITIONS[name].sums for reason in lacking for name in _NEEDS[reason]}
    return {name: rows for name, rows in sums.items() if name not in meaningless}


def _seen(geometry: Geometry, names: set[str], rig: TableRig) -> Geometry:
    """Return the rig as far as it was seen: a table has no picture, and may have one chamber."""
    if rig.known is not None:
        return geometry
    kept = [chamber for chamber in geometry.chambers if chamber.name in names]
    if not rig.has_picture:
        nan = float("nan")
        kept = [
            replace(c, centre_u_px=nan, centre_v_px=nan, radius_px=nan, exit_rad=nan) for c in kept
        ]
    return replace(geometry, chambers=tuple(kept or geometry.chambers[:1]))


def _rig_provenance(rig: TableRig) -> dict[str, Any]:
    """Return the rig for the provenance: what was told, or that it is that of the tracks."""
    told = {name: value for name, value in asdict(rig).items() if name != "known"}
    return {**told, "from_summary": rig.known is not None}
