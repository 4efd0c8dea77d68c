"""The rig that a table of tracks was made in, and the way from its coordinates to the chambers'."""

from dataclasses import dataclass, replace
from math import isfinite, nan, radians
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from worm_analysis.results import chamber_of
from worm_bringup.tracks.track_table import Rows
from worm_msgs_py import Chamber, Geometry, Status, Where, limits
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import KEYPOINTS
from worm_msgs_py.contract.frames import CHAMBER_A, CHAMBER_B
from worm_msgs_py.contract.locating import is_in_passage
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.json_files import read_json
from worm_msgs_py.limits import first_refusal
from worm_msgs_py.paper import DEPTH_MM, PASSAGE_LENGTH_MM
from worm_msgs_py.units import MM_PER_M

NO_PICTURE_PX_PER_M = 1e8
"""Of a table in millimetres: its picture is imagined, with pixels too small to limit anything."""
RIG_LIMITS = {
    "radius_mm": limits.RADIUS.to("mm"),
    "exit_width_mm": limits.EXIT_WIDTH.to("mm"),
    "depth_mm": limits.DEPTH.to("mm"),
    "passage_mm": limits.PASSAGE_LENGTH.to("mm"),
}


@dataclass(frozen=True, slots=True)
class TableRig:
    """What a table cannot say of its rig; lengths in millimetres, as people give them.

    Attributes
    ----------
    radius_mm, exit_width_mm, depth_mm, passage_mm : float
        R, W (NaN where it is not known), h and L.
    circle_px : (float, float, float) or None
        Centre and radius of the wall in the picture, for tables in pixels.
    centre_mm : (float, float)
        Centre of the chamber in the table's own coordinates.
    exit_deg : float
        Direction of the exit, counter-clockwise from the table's x axis (from the picture's right,
        for tables in pixels).
    y_down : bool
        Whether the table's y points down, as in pictures.
    known : Geometry or None
        The rig as an earlier result has it; the table's millimetres are then in its chambers'
        frames, and the above is not used.

    Raises
    ------
    BadInput
        Where a number makes no sense.
    """

    radius_mm: float = 10.0
    exit_width_mm: float = nan
    depth_mm: float = DEPTH_MM
    passage_mm: float = PASSAGE_LENGTH_MM
    circle_px: tuple[float, float, float] | None = None
    centre_mm: tuple[float, float] = (0.0, 0.0)
    exit_deg: float = 0.0
    y_down: bool = False
    known: Geometry | None = None

    def __post_init__(self) -> None:
        wrong = first_refusal(self, RIG_LIMITS, may_lack=("exit_width_mm",))
        if wrong:
            raise BadInput(wrong)
        if self.exit_width_mm >= 2 * self.radius_mm:
            raise BadInput(
                f"--exit-width-mm is {self.exit_width_mm:g} mm: an exit is "
                f"narrower than its chamber, {2 * self.radius_mm:g} mm across"
            )

    @property
    def has_picture(self) -> bool:
        """Whether pixel coordinates mean anything."""
        return self.known is not None or self.circle_px is not None

    def geometry(self) -> Geometry:
        """Return the rig for the analysis: both chambers, whether the worm visits both or not."""
        if self.known is not None:
            return self.known
        if self.circle_px is not None:
            u, v, radius_px = self.circle_px
            exit_rad = radians(self.exit_deg)
        else:
            u = v = exit_rad = 0.0
            radius_px = self.radius_mm / MM_PER_M * NO_PICTURE_PX_PER_M
        radius_m, width_m = self.radius_mm / MM_PER_M, self.exit_width_mm / MM_PER_M
        a = Chamber(CHAMBER_A, u, v, radius_px, exit_rad, radius_m, width_m)
        far = a.to_pixels(2 * radius_m + self.passage_mm / MM_PER_M, 0.0)
        b = Chamber(CHAMBER_B, *far, radius_px, exit_rad + np.pi, radius_m, width_m)
        return Geometry(1, 0, 0, 0, (a, b), self.depth_mm / MM_PER_M, self.passage_mm / MM_PER_M)


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Rows in the chambers' frames.

    Attributes
    ----------
    where : ndarray of int64, shape (n,)
        Values of `Where`.
    in_b : ndarray of bool, shape (n,)
        Whether the coordinates are in chamber b's frame rather than in chamber a's.
    status : ndarray of int64, shape (n,)
        Values of `Status`.
    x_mm, y_mm, yaw_deg, u_px, v_px : dict of ndarray
        By point of the body; the pixels are those of `TableRig.geometry`.
    """

    where: NDArray[np.int64]
    in_b: NDArray[np.bool_]
    status: NDArray[np.int64]
    x_mm: dict[str, Floats]
    y_mm: dict[str, Floats]
    yaw_deg: dict[str, Floats]
    u_px: dict[str, Floats]
    v_px: dict[str, Floats]


class Placer:
    """Puts rows into the chambers' frames, in order: a head in the passage keeps its chamber's.

    A table that says `where` the head is has each row in the frame of the chamber that it names,
    and in the passage in that of the chamber that the head came from. A table that does not has
    all rows in one frame, chamber a's; what is beyond the middle of the passage is in chamber b,
    which lies at x = 2 R + L.
    """

    def __init__(self, rig: TableRig):
        self._rig = rig
        self._geometry = rig.geometry()
        self._a = self._geometry.chambers[0]
        self._home_is_b = self._a.name == CHAMBER_B

    def place(self, rows: Rows) -> Placed:
        """Return the rows in the chambers' frames."""
        x, y, yaw = {}, {}, {}
        for point in KEYPOINTS:
            x[point], y[point] = self._in_one_frame(rows, point)
            yaw[point] = self._turned(rows.column(f"{point}_yaw_deg"))
        has_head = np.isfinite(x["head"]) & np.isfinite(y["head"])
        if rows.where is None:
            where, in_b = self._locate(x["head"], y["head"], has_head)
            self._into_b(x, y, yaw, in_b)
        else:
            where = rows.where
            in_b = self._frames(where)
            if self._rig.known is not None:
                in_b = self._as_pixels_say(rows, x["head"], y["head"], in_b)
        status = rows.status
        if status is None:
            status = np.where(has_head, int(Status.TRACKED), int(Status.NO_WORM))
        u, v = self._pixels(rows, x, y, in_b)
        return Placed(where, in_b, status, x, y, yaw, u, v)

    def _in_one_frame(self, rows: Rows, point: str) -> tuple[Floats, Floats]:
        rig = self._rig
        if rig.circle_px is not None:
            x_m, y_m = self._a.to_metres(rows.column(f"{point}_u_px"), rows.column(f"{point}_v_px"))
            return x_m * MM_PER_M, y_m * MM_PER_M
        x, y = rows.column(f"{point}_x_mm"), rows.column(f"{point}_y_mm")
        if rig.known is not None:
            return x, y
        right, up = x - rig.centre_mm[0], y - rig.centre_mm[1]
        up = -up if rig.y_down else up
        if rig.exit_deg == 0.0:
            return right, up
        c, s = np.cos(radians(rig.exit_deg)), np.sin(radians(rig.exit_deg))
        return c * right + s * up, c * up - s * right

    def _turned(self, yaw_deg: Floats) -> Floats:
        rig = self._rig
        if rig.known is not None or not (rig.y_down or rig.exit_deg or rig.circle_px):
            return yaw_deg
        seen = -yaw_deg if rig.y_down or rig.circle_px is not None else yaw_deg
        return seen - rig.exit_deg

    def _locate(
        self, x: Floats, y: Floats, has_head: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        R, W = self._a.radius_m * MM_PER_M, self._a.exit_width_m * MM_PER_M
        L = self._geometry.passage_length_m * MM_PER_M
        out_a = np.hypot(x, y) / R
        out_b = np.hypot(x - (2 * R + L), y) / R
        nearer_b = out_b < out_a
        passage = is_in_passage(x, y, np.minimum(out_a, out_b), R, W, L)
        where = np.where(nearer_b, int(Where.CHAMBER_B), int(Where.CHAMBER_A))
        where = np.where(passage, int(Where.PASSAGE), where)
        where = np.where(has_head, where, int(Where.UNKNOWN))
        return where, self._frames(where)

    def _frames(self, where: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return whether each row is in chamber b's frame: that of the chamber seen last."""
        named = (where == Where.CHAMBER_A) | (where == Where.CHAMBER_B)
        last = np.maximum.accumulate(np.where(named, np.arange(len(where)), -1))
        in_b = np.where(last >= 0, where[last] == Where.CHAMBER_B, self._home_is_b)
        if len(in_b):
            self._home_is_b = bool(in_b[-1])
        return in_b

    def _into_b(
        self,
        x: dict[str, Floats],
        y: dict[str, Floats],
        yaw: dict[str, Floats],
        in_b: NDArray[np.bool_],
    ) -> None:
        apart = 2 * self._a.radius_m * MM_PER_M + self._geometry.passage_length_m * MM_PER_M
        for point in KEYPOINTS:
            x[point] = np.where(in_b, apart - x[point], x[point])
            y[point] = np.where(in_b, -y[point], y[point])
            yaw[point] = np.where(in_b, yaw[point] + 180.0, yaw[point])
            yaw[point] = (yaw[point] + 180.0) % 360.0 - 180.0

    def _as_pixels_say(
        self, rows: Rows, x: Floats, y: Floats, in_b: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return the frame in which a row's millimetres agree with its pixels."""
        chambers = self._geometry.chambers
        if len(chambers) < 2:
            return np.full(len(x), chambers[0].name == CHAMBER_B)
        u, v = rows.column("head_u_px"), rows.column("head_v_px")
        off = []
        for chamber in chambers:
            x_m, y_m = chamber.to_metres(u, v)
            off.append(np.hypot(x_m * MM_PER_M - x, y_m * MM_PER_M - y))
        return np.where(np.isfinite(off[0]), off[1] < off[0], in_b)

    def _pixels(
        self, rows: Rows, x: dict[str, Floats], y: dict[str, Floats], in_b: NDArray[np.bool_]
    ) -> tuple[dict[str, Floats], dict[str, Floats]]:
        u, v = {}, {}
        for point in KEYPOINTS:
            if self._rig.has_picture:
                u[point], v[point] = rows.column(f"{point}_u_px"), rows.column(f"{point}_v_px")
                continue
            a, b = (
                chamber.to_pixels(x[point] / MM_PER_M, y[point] / MM_PER_M)
                for chamber in self._geometry.chambers
            )
            u[point], v[point] = np.where(in_b, b[0], a[0]), np.where(in_b, b[1], a[1])
        return u, v


def rig_of_summary(summary_path: Path) -> TableRig | None:
    """Return the rig that an earlier result's summary has; None where it saw no chamber.

    Raises
    ------
    BadInput
        Where the summary cannot be read.
    """
    try:
        entries = read_json(summary_path)["geometry"]
        chambers = tuple(chamber_of(name, entry) for name, entry in entries.items())
        if not chambers:
            return None
        first, entry = chambers[0], next(iter(entries.values()))
        rig = TableRig(
            radius_mm=first.radius_m * MM_PER_M,
            exit_width_mm=first.exit_width_m * MM_PER_M,
            depth_mm=float(entry.get("depth_mm", DEPTH_MM)),
            passage_mm=float(entry.get("passage_length_mm", PASSAGE_LENGTH_MM)),
        )
    except (OSError, ArithmeticError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(
            f"{summary_path}: cannot be read as the summary of these tracks ({error!r}): take "
            "the table out of this directory, or write the results again"
        ) from None
    if not isfinite(first.radius_px):
        return rig
    depth_m, length_m = rig.depth_mm / MM_PER_M, rig.passage_mm / MM_PER_M
    return replace(rig, known=Geometry(1, 0, 0, 0, chambers, depth_m, length_m))
