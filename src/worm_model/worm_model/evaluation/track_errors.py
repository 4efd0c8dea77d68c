"""The figures of an evaluation: errors of tips, centroid and midline, identity, contact, circles.

They describe the frames at hand. No interval is given with them: frames in a row are not
independent, and truth is exact.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from worm_model.evaluation.distances import as_given_rms, resampled, shape_rms
from worm_model.evaluation.frame_table import (
    EVALUATION,
    ChamberCircle,
    EvaluationSettings,
    FrameTable,
    common_rows,
)
from worm_msgs_py.arrays import Floats
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class Figure:
    """One number of an evaluation.

    Attributes
    ----------
    name : str
        What it is.
    value : float or None
        None where it cannot be had.
    unit : str
        Its unit; empty for a share.
    n : int
        Frames, or episodes, that it rests on.
    why : str
        Why there is no value.
    """

    name: str
    value: float | None
    unit: str
    n: int
    why: str = ""


@dataclass(frozen=True, slots=True)
class Evaluation:
    """All figures of a trial.

    Attributes
    ----------
    joined_by : str
        The column by which frames were matched.
    frames_of_tracks, frames_of_truth, frames_in_common : int
        Rows of the tables, and how many belong together.
    figures : tuple of Figure
        In the order in which people read them.
    """

    joined_by: str
    frames_of_tracks: int
    frames_of_truth: int
    frames_in_common: int
    figures: tuple[Figure, ...]

    def __getitem__(self, name: str) -> Figure:
        """Return the figure of this name; KeyError where there is none."""
        for figure in self.figures:
            if figure.name == name:
                return figure
        raise KeyError(name)

    def document(self) -> dict[str, Any]:
        """Return everything as JSON takes it."""
        return {
            "joined_by": self.joined_by,
            "frames": {
                "tracks": self.frames_of_tracks,
                "truth": self.frames_of_truth,
                "common": self.frames_in_common,
            },
            "figures": {
                figure.name: {"value": figure.value, "unit": figure.unit, "n": figure.n}
                | ({"why": figure.why} if figure.why else {})
                for figure in self.figures
            },
        }


def evaluate_tracks(
    tracks: FrameTable,
    truth: FrameTable,
    *,
    certain: float = SURE_HEAD_CERTAINTY,
    settings: EvaluationSettings = EVALUATION,
) -> Evaluation:
    """Compare tracks with the truth.

    Parameters
    ----------
    tracks, truth : FrameTable
        What was said and what is true.
    certain : float
        Head certainty (0.5 to 1) from which a frame counts as not flagged uncertain.
    settings : EvaluationSettings

    Raises
    ------
    EvaluationError
        Where the tables have no frame in common.

    Notes
    -----
    Tip errors are distances of the head given from the true head, so an exchange of the ends
    costs the body's length; ``tip_nearer_end`` is free of that. A frame of the truth that the
    tracks lack counts as not tracked, and what they do not decide (contact, where) as wrong, but in
    ``contact_agreement_where_told``; ``contact_told`` is the part of which they decide it.
    """
    key, said, true = common_rows(tracks, truth, settings)
    pair = _Pair(tracks, truth, said, true, settings)
    figures = [
        *_tip_figures(pair),
        *_midline_figures(pair),
        *_identity_figures(pair, certain),
        _tracked(pair),
        *_wall_figures(pair),
        *_episode_figures(pair),
        _where(pair),
        *_circle_figures(tracks.circles, truth.circles),
    ]
    return Evaluation(key, len(tracks), len(truth), len(said), tuple(figures))


@dataclass(frozen=True, eq=False, slots=True)
class _Pair:
    tracks: FrameTable
    truth: FrameTable
    said: NDArray[np.intp]
    true: NDArray[np.intp]
    settings: EvaluationSettings

    def spread(self, values: NDArray[Any], nothing: Any) -> NDArray[Any]:
        """Return a column of the tracks over all rows of the truth."""
        out = np.full(len(self.truth), nothing, dtype=values.dtype)
        out[self.true] = values[self.said]
        return out

    def ends_px(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return head and tail as given, and the true ones, of the common frames that are tracked.

        NaN where they are not.
        """
        tracked = self.tracks.tracked[self.said, np.newaxis]
        head = np.where(tracked, self.tracks.head_px[self.said], np.nan)
        tail = np.where(tracked, self.tracks.tail_px[self.said], np.nan)
        return head, tail, self.truth.head_px[self.true], self.truth.tail_px[self.true]

    def median_and_95(
        self, name: str, values: Floats, unit: str, why: str = ""
    ) -> Iterator[Figure]:
        """Yield both, or why there are none."""
        known = values[np.isfinite(values)]
        if len(known) < self.settings.fewest_frames:
            why = why or f"not enough data: {len(known)} frames"
            yield Figure(f"{name}_median", None, unit, len(known), why)
            yield Figure(f"{name}_95", None, unit, len(known), why)
            return
        median, high = np.quantile(known, [0.5, 0.95])
        yield Figure(f"{name}_median", float(median), unit, len(known))
        yield Figure(f"{name}_95", float(high), unit, len(known))

    def share_right(self, name: str, right: NDArray[np.bool_], why: str = "") -> Figure:
        """Return the share of frames that are right."""
        if len(right) < self.settings.fewest_frames:
            return Figure(
                name, None, "", len(right), why or f"not enough data: {len(right)} frames"
            )
        return Figure(name, float(right.mean()), "", len(right))


def _tip_figures(pair: _Pair) -> Iterator[Figure]:
    head, tail, true_head, true_tail = pair.ends_px()
    yield from pair.median_and_95("head_error", _apart(head, true_head), "px")
    yield from pair.median_and_95("tail_error", _apart(tail, true_tail), "px")
    straight = np.stack([_apart(head, true_head), _apart(tail, true_tail)])
    turned = np.stack([_apart(head, true_tail), _apart(tail, true_head)])
    nearer = np.where((straight**2).sum(axis=0) <= (turned**2).sum(axis=0), straight, turned)
    yield from pair.median_and_95("tip_nearer_end_error", nearer.ravel(), "px")
    centroid = _apart(pair.tracks.centroid_px[pair.said], pair.truth.centroid_px[pair.true])
    yield from pair.median_and_95("centroid_error", centroid, "px")


def _midline_figures(pair: _Pair) -> Iterator[Figure]:
    found, real = pair.tracks.midline_px, pair.truth.midline_px
    as_given, shape = [], []
    if found is not None and real is not None:
        for k, j in zip(pair.said.tolist(), pair.true.tolist(), strict=True):
            one, other = resampled(found[k]), resampled(real[j])
            if pair.tracks.tracked[k] and one is not None and other is not None:
                as_given.append(as_given_rms(one, other))
                shape.append(shape_rms(one, other))
    why = "" if found is not None and real is not None else "no columns midline_u_px, midline_v_px"
    yield from pair.median_and_95("midline_rms", np.array(as_given), "px", why)
    yield from pair.median_and_95("midline_shape_rms", np.array(shape), "px", why)


def _identity_figures(pair: _Pair, certain: float) -> Iterator[Figure]:
    head, tail, true_head, true_tail = pair.ends_px()
    straight = _apart(head, true_head) ** 2 + _apart(tail, true_tail) ** 2
    turned = _apart(head, true_tail) ** 2 + _apart(tail, true_head) ** 2
    known = np.isfinite(straight) & np.isfinite(turned)
    stamps, why = pair.truth.stamp_ns, ""
    if stamps is None:
        known[:], why = False, "no column stamp_ns"
    else:
        from_ns = round(pair.settings.head_judged_from_s * NS_PER_S)
        known &= stamps[pair.true] >= stamps.min() + from_ns
    right = straight < turned
    yield pair.share_right("right_end_for_head", right[known], why)
    certainty = pair.tracks.head_certainty
    if certainty is None:
        yield Figure("right_end_where_certain", None, "", 0, "no column head_certainty")
        return
    sure = known & (certainty[pair.said] >= certain)
    yield pair.share_right("right_end_where_certain", right[sure], why)
    yield pair.share_right("certain_of_the_head", sure[known], why)


def _tracked(pair: _Pair) -> Figure:
    there = np.isfinite(pair.truth.head_px).all(axis=1)
    return pair.share_right("tracked", pair.spread(pair.tracks.tracked, nothing=False)[there])


def _wall_figures(pair: _Pair) -> Iterator[Figure]:
    said, true = pair.tracks.r_h_mm, pair.truth.r_h_mm
    if said is None or true is None:
        yield from pair.median_and_95("r_h_error", np.empty(0), "mm", "no column r_h_mm")
    else:
        yield from pair.median_and_95("r_h_error", np.abs(said[pair.said] - true[pair.true]), "mm")
    contact, true_contact = pair.tracks.contact, pair.truth.contact
    if contact is None or true_contact is None:
        names = ("contact_agreement", "contact_agreement_where_told", "contact_told")
        yield from (Figure(name, None, "", 0, "no column contact") for name in names)
        return
    known = np.isfinite(true_contact)
    all_said = pair.spread(contact, np.nan)
    told, agrees = np.isfinite(all_said), all_said == true_contact
    yield pair.share_right("contact_agreement", agrees[known])
    yield pair.share_right("contact_agreement_where_told", agrees[known & told])
    yield pair.share_right("contact_told", told[known])


def _episode_figures(pair: _Pair) -> Iterator[Figure]:
    names = [f"contact_episode_{name}" for name in ("precision", "recall", "f1")]
    contact, true_contact = pair.tracks.contact, pair.truth.contact
    if contact is None or true_contact is None:
        yield from (Figure(name, None, "", 0, "no column contact") for name in names)
        return
    order = _in_time(pair.truth)
    known = np.isfinite(true_contact[order])
    found = runs((_bridged(pair, contact, order) == 1.0) & known)
    real = runs(true_contact[order] == 1.0)
    matched = matches(found, real)
    for name, of, count in (
        (names[0], matched, len(found)),
        (names[1], matched, len(real)),
        (names[2], 2 * matched, len(found) + len(real)),
    ):
        enough = len(real) >= pair.settings.fewest_episodes and count > 0
        why = "" if enough else f"not enough data: {len(real)} true, {len(found)} found episodes"
        yield Figure(name, of / count if enough else None, "", count, why)


def _bridged(pair: _Pair, said: Floats, order: NDArray[np.intp]) -> Floats:
    """Carry the contact told last over the few frames that do not tell it."""
    contact, truth = pair.spread(said, np.nan)[order], pair.truth
    last = np.maximum.accumulate(np.where(np.isfinite(contact), np.arange(len(contact)), -1))
    carried = np.where(last >= 0, contact[np.maximum(last, 0)], np.nan)
    if truth.stamp_ns is None:
        return contact
    stamps = truth.stamp_ns[order]
    fresh = stamps - stamps[np.maximum(last, 0)] <= round(pair.settings.longest_gap_s * NS_PER_S)
    return np.where(fresh, carried, np.nan)


def runs(on: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the first and last row of each run of True, shape (m, 2)."""
    edges = np.flatnonzero(np.diff(np.r_[False, on, False].astype(np.int8)))
    return np.stack([edges[::2], edges[1::2] - 1], axis=1)


def matches(found: NDArray[np.intp], real: NDArray[np.intp]) -> int:
    """Return the largest number of pairs of episodes, one of each, that overlap in time.

    Parameters
    ----------
    found, real : ndarray of int, shape (m, 2)
        First and last frame of each episode.
    """
    if not len(found) or not len(real):
        return 0
    overlap = (found[:, :1] <= real[:, 1]) & (found[:, 1:] >= real[:, 0])
    paired = maximum_bipartite_matching(csr_array(overlap), perm_type="column")
    return int((paired >= 0).sum())


def _where(pair: _Pair) -> Figure:
    if pair.tracks.where is None or pair.truth.where is None:
        return Figure("where_agreement", None, "", 0, "no column where")
    known = ~np.isin(pair.truth.where, ("unknown", "None", ""))
    said = pair.spread(pair.tracks.where.astype(object), "")
    return pair.share_right("where_agreement", (said == pair.truth.where)[known])


def _circle_figures(
    found: dict[str, ChamberCircle], real: dict[str, ChamberCircle]
) -> Iterator[Figure]:
    if not real:
        yield Figure("circle", None, "", 0, "the truth has no geometry")
    for name, true in real.items():
        said = found.get(name)
        if said is None:
            yield Figure(f"{name}_centre_error", None, "px", 0, "the tracks have no such chamber")
            continue
        centre = np.hypot(said.centre_u_px - true.centre_u_px, said.centre_v_px - true.centre_v_px)
        yield Figure(f"{name}_centre_error", float(centre), "px", 1)
        radius = 100.0 * abs(said.radius_px / true.radius_px - 1.0)
        yield Figure(f"{name}_radius_error", float(radius), "%", 1)
        turn = abs((said.exit_deg - true.exit_deg + 180.0) % 360.0 - 180.0)
        exit_known = bool(np.isfinite(turn))
        why = "" if exit_known else "no exit was found"
        yield Figure(f"{name}_exit_error", float(turn) if exit_known else None, "deg", 1, why)


def _in_time(record: FrameTable) -> NDArray[np.intp]:
    key = record.stamp_ns if record.stamp_ns is not None else record.frame
    return np.argsort(np.arange(len(record)) if key is None else key, kind="stable")


def _apart(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.hypot(*(one - other).T), dtype=np.float64)
