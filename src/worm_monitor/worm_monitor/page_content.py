"""What the page shows of a trial, in bounded memory: no ROS, no clock of its own, no browser."""

from collections import OrderedDict, deque
from collections.abc import Iterable, Mapping
from math import degrees, isfinite, nan, pi, remainder
from typing import Any

from worm_monitor.event_words import event_in_words
from worm_monitor.json_numbers import JsonRow, rounded, rounded_all
from worm_monitor.overlay_json import drawn_chambers, drawn_pose
from worm_monitor.rates import Rate
from worm_monitor.thinned_rows import ThinnedRows
from worm_msgs_py import (
    BodyState,
    Comparison,
    Correlation,
    Distribution,
    Event,
    Forecast,
    Geometry,
    Midline,
    Observables,
    Quantity,
    SourceEvent,
)
from worm_msgs_py.contract.body import KEYPOINTS, SURE_HEAD_CERTAINTY
from worm_msgs_py.units import MM_PER_M, NS_PER_S

MOST_POSES = 512
"""More than the tracker holds back: the pose of a picture that waits for it is found."""
MOST_LOGGED = 400
MOST_MIDLINE_POINTS = 48
ROW = ("t", "r_h", "r_c", "r_t", "theta_h", "psi_b", "psi_h", "contact")
"""What a row of the time plots holds: seconds, mm, degrees, 1 in contact."""
_DISTRIBUTIONS = ("r_h", "r_c", "r_t", "psi_b", "d_c", "d_nc", "delta_r_h")


class PageContent:
    """Takes what the graph says, and tells what is new of it, or all.

    Nothing of it grows without end: rows are thinned, events and poses are the last ones.
    """

    def __init__(self) -> None:
        self._rows = ThinnedRows()
        self._sections: dict[str, Any] = {}
        self._changed: set[str] = set()
        self._events: deque[dict[str, Any]] = deque(maxlen=MOST_LOGGED)
        self._new_events: deque[dict[str, Any]] = deque(maxlen=MOST_LOGGED)
        self._poses: OrderedDict[int, dict[str, Any]] = OrderedDict()
        self._health: dict[str, dict[str, Any]] = {}
        self._rates = {"in": Rate(), "done": Rate()}
        self._state: BodyState | None = None
        self._observables: Observables | None = None
        self._geometry: Geometry | None = None
        self._first_ns: int | None = None
        self._last_s: float | None = None
        self._latency_s: float | None = None

    def news(self) -> dict[str, Any]:
        """Return what has come since the last time."""
        anew, rows = self._rows.news()
        told: dict[str, Any] = {name: self._sections[name] for name in self._changed}
        if rows or anew:
            told |= {"rows": rows, "anew": anew}
        if self._new_events:
            told["events"] = list(self._new_events)
        self._new_events.clear()
        self._changed.clear()
        return told

    def everything(self) -> dict[str, Any]:
        """Return all that a page needs which has just been opened."""
        return {
            **self._sections,
            "rows": self._rows.rows,
            "anew": True,
            "events": list(self._events),
            "all": True,
        }

    def take_state(self, state: BodyState, now_s: float, latency_s: float | None) -> None:
        """Take a frame's state.

        Parameters
        ----------
        now_s : float
            When it came, on a clock that only goes forward.
        latency_s : float or None
            Seconds since the frame was captured; None where stamps are of another time.
        """
        if self._first_ns is None:
            self._first_ns = state.stamp_ns
        self._state, self._last_s, self._latency_s = state, now_s, latency_s
        self._rates["done"].take(state.frame + 1, now_s)
        self._poses[state.stamp_ns] = _pose(state)
        while len(self._poses) > MOST_POSES:
            self._poses.popitem(last=False)

    def take_midline(self, stamp_ns: int, midline: Midline) -> None:
        """Take a frame's midline, which comes after its state; it is empty where there is none."""
        pose = self._poses.get(stamp_ns)
        if pose is not None:
            step = max(1, len(midline.u_px) // MOST_MIDLINE_POINTS)
            pose["midline"] = [rounded_all(midline.u_px[::step]), rounded_all(midline.v_px[::step])]

    def pose(self, stamp_ns: int) -> dict[str, Any] | None:
        """Return what is drawn over the picture of this stamp; None where it has not come."""
        pose = self._poses.get(stamp_ns)
        return None if pose is None or "midline" not in pose else pose

    def time_s(self, stamp_ns: int) -> float:
        """Return the seconds since the first frame; NaN before its state has come."""
        return nan if self._first_ns is None else (stamp_ns - self._first_ns) / NS_PER_S

    def take_observables(self, seen: Observables) -> None:
        """Take the symbols of a frame."""
        self._observables = seen
        if self._first_ns is None:
            self._first_ns = seen.stamp_ns
        time_s = self.time_s(seen.stamp_ns)
        if self._rows.is_due(time_s):
            self._rows.add(_plotted_row(time_s, seen))

    def take_events(self, events: Iterable[Event]) -> None:
        """Take contacts, excursions, visits and attempts that have closed."""
        for event in events:
            self._log(event.start_ns, event.end_ns, *event_in_words(event))

    def take_source_events(self, events: Iterable[SourceEvent]) -> None:
        """Take what happened to the pictures."""
        for event in events:
            start_ns = event.stamp_ns
            end_ns = start_ns + round(event.duration_s * NS_PER_S)
            self._log(start_ns, end_ns, "source", f"{event.kind.replace('_', ' ')}: {event.why}")

    def take_remark(self, text: str, stamp_ns: int | None = None) -> None:
        """Take what a node says, or what became of what an operator asked for: now if no stamp."""
        if stamp_ns is None:
            stamp_ns = self._state.stamp_ns if self._state is not None else 0
        self._log(stamp_ns, stamp_ns, "remark", text)

    def _log(self, start_ns: int, end_ns: int, kind: str, text: str) -> None:
        entry = {
            "t": rounded(self.time_s(start_ns), 7),
            "end": rounded(self.time_s(end_ns), 7),
            "kind": kind,
            "text": text,
        }
        self._events.append(entry)
        self._new_events.append(entry)

    def take_geometry(self, geometry: Geometry) -> None:
        """Take the rig."""
        self._geometry = geometry
        size = [geometry.picture_width_px, geometry.picture_height_px]
        self._put(
            "geometry",
            {
                "version": geometry.version,
                "size": size,
                "chambers": drawn_chambers(geometry.chambers),
            },
        )

    def take_correlation(self, curve: Correlation, *, of_model: bool) -> None:
        """Take C_θ(t) as measured, or the walk's."""
        told = {"lag": rounded_all(curve.lag_s), "c": rounded_all(curve.c, digits=4)}
        if not of_model:
            told |= {"error": rounded_all(curve.error, digits=3)}
        self._put("model_correlation" if of_model else "correlation", told)

    def take_distribution(self, histogram: Distribution) -> None:
        """Take one histogram, in mm, degrees or units of R."""
        if histogram.name not in _DISTRIBUTIONS:
            return
        scale = {"m": MM_PER_M, "rad": 180.0 / pi}.get(histogram.unit, 1.0)
        last = max((k for k, count in enumerate(histogram.counts) if count), default=-1) + 1
        told = {
            "edges": rounded_all(histogram.edges[: last + 1], scale),
            "counts": [int(count) for count in histogram.counts[:last]],
            "unit": {"m": "mm", "rad": "deg"}.get(histogram.unit, histogram.unit),
        }
        self._put(f"P_{histogram.name}", told)

    def take_quantities(self, quantities: Iterable[Quantity]) -> None:
        """Take the trial's numbers."""
        told = {
            item.name: {
                "value": rounded(item.value, 4),
                "low": rounded(item.low, 4),
                "high": rounded(item.high, 4),
                "n": item.n,
                "unit": item.unit,
                "paper": rounded(item.paper, 4),
                "why": item.why,
            }
            for item in quantities
        }
        self._put("quantities", told)

    def take_comparison(self, comparison: Comparison) -> None:
        """Take what the walk says of the trial's numbers, and the lengths that it is run with."""
        told: dict[str, Any] = {}
        for item in comparison.quantities:
            unit, scale = ("mm", MM_PER_M) if item.unit == "m" else (item.unit, 1.0)
            numbers = (item.modelled, item.modelled_low, item.modelled_high)
            value, low, high = (rounded(number * scale, 4) for number in numbers)
            told[item.name] = {"value": value, "low": low, "high": high, "unit": unit}
        self._put("walk", told)

    def take_forecast(self, forecast: Forecast) -> None:
        """Take when the head will find the exit."""
        told = {
            "median": rounded(forecast.median_s, 3),
            "low": rounded(forecast.low_s, 3),
            "high": rounded(forecast.high_s, 3),
            "within": [
                [seconds, rounded(share, 2)]
                for seconds, share in (
                    (10, forecast.within_10_s),
                    (30, forecast.within_30_s),
                    (60, forecast.within_60_s),
                )
            ],
        }
        self._put("forecast", told)

    def take_counts(self, taken: int, now_s: float) -> None:
        """Take how many frames the tracker has taken in."""
        self._rates["in"].take(taken, now_s)

    def take_health(self, name: str, level: int, message: str, values: Mapping[str, str]) -> None:
        """Take what a node says of itself on `/diagnostics`; of each name the last."""
        if name in self._health or len(self._health) < MOST_LOGGED:
            told = {"level": level, "message": message, "values": dict(values)}
            self._health[name] = told
            self._put("health", self._health)

    def tell_now(self, now_s: float, **more: Any) -> None:
        """Put together what the head of the page says at this moment."""
        state, seen, geometry = self._state, self._observables, self._geometry
        told: dict[str, Any] = {
            "age_s": None if self._last_s is None else rounded(now_s - self._last_s, 3),
            "latency_s": rounded(self._latency_s, 3),
            "fps_in": rounded(self._rates["in"].per_s(now_s), 3),
            "fps_done": rounded(self._rates["done"].per_s(now_s), 3),
            "taken": self._rates["in"].count,
        }
        if state is not None:
            told |= {
                "t": rounded(self.time_s(state.stamp_ns), 8),
                "frame": state.frame,
                "status": state.status.label,
                "reason": state.status.reason,
                "has_pose": state.status.has_pose,
                "certainty": rounded(state.head_certainty, 3),
                "sure": state.head_certainty >= SURE_HEAD_CERTAINTY,
                "where": state.where.label,
                "length_mm": rounded(state.length_m * MM_PER_M, 3),
            }
        if seen is not None:
            told |= {"contact": seen.contact, "v_b": rounded(seen.v_b_m_s * MM_PER_M, 3)}
            told |= {"r_h": rounded(seen.r_h_m * MM_PER_M), "r_c": rounded(seen.r_c_m * MM_PER_M)}
            told["psi_b"] = rounded(degrees(seen.psi_b_rad), 3)
        if geometry is not None:
            told["version"] = geometry.version
        self._put("now", told | more)

    def _put(self, name: str, told: Any) -> None:
        self._sections[name] = told
        self._changed.add(name)


def _pose(state: BodyState) -> dict[str, Any]:
    points = {name: getattr(state, name) for name in KEYPOINTS}
    return drawn_pose(
        state.frame,
        state.status.label,
        state.head_certainty,
        {name: (point.u_px, point.v_px) for name, point in points.items()},
        (state.width_px, state.length_px),
    )


def _plotted_row(time_s: float, seen: Observables) -> JsonRow:
    radii = rounded_all((seen.r_h_m, seen.r_c_m, seen.r_t_m), MM_PER_M, 4)
    theta = seen.theta_h_rad
    wrapped = remainder(theta, 2 * pi) if isfinite(theta) else theta
    angles = rounded_all((wrapped, seen.psi_b_rad, seen.psi_h_rad), degrees(1.0), 4)
    contact = None if seen.contact is None else float(seen.contact)
    return [rounded(time_s, 8), *radii, *angles, contact]
