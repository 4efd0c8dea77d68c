"""How good the model's forecasts of the search were, beside a memoryless forecast."""

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any

from worm_analysis.report.numbers import plain
from worm_analysis.report.panel import Panel, counted
from worm_analysis.report.theme import COLUMN_IN, GREY, INK, MODEL_COLOUR, new_figure
from worm_analysis.report.verdicts import REJECTED
from worm_analysis.results import Results
from worm_analysis.summary.definition import NO_CHAMBER

HORIZONS = ("10", "30", "60")
_READING = (
    "When the head first touches the wall, the boundary walk forecasts the time until it finds the "
    "exit, from its angle, its direction and its contact, with the trial’s numbers so far. Each "
    "passage scores its forecast; lower is better. Left: the continuous ranked probability score, "
    "a mean distance in seconds; right: the Brier score of the probability that the exit is found "
    "within 10, 30 and 60 s. Purple, the walk; grey, an exponential forecast with the walk’s "
    "⟨τ<sub>h</sub>⟩, which does not know where the head is."
)


def forecasts(results: Results) -> Panel:
    """Return the panel."""
    scores = {} if results.comparison is None else dict(results.comparison.scores)
    passages = int(scores.get("passages", 0))
    base: dict[str, Any] = {
        "key": "fig-forecast",
        "title": "Forecasts of the search for the exit",
        "paper": "",
        "label": "Forecasts",
        "reading": _READING + _gain_in_words(scores),
        "n": counted(passages, "passages with a forecast"),
    }
    if not results.chambers:
        return Panel(**base, why=NO_CHAMBER)
    if not passages:
        return Panel(**base, why="no passage from a first contact to the exit was forecast")
    figure = new_figure(COLUMN_IN, 1.9)
    left, right = figure.subplots(1, 2, width_ratios=(1, 2.4))
    pair = (scores["crps_s"], scores["crps_memoryless_s"])
    _bars(left, [0.0], [[value] for value in pair])
    left.set_xticks([0.0], ["CRPS"])
    left.set_ylabel("score (s)")
    own, memoryless = (
        [scores[f"brier_{kind}{horizon}_s"] for horizon in HORIZONS] for kind in ("", "memoryless_")
    )
    _bars(right, [0.0, 1.0, 2.0], [own, memoryless])
    right.set_xticks([0.0, 1.0, 2.0], [f"{horizon} s" for horizon in HORIZONS])
    right.set_ylabel("Brier score")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2)
    alt = (
        f"Scores of {passages} forecasts: CRPS {plain(pair[0])} s, memoryless {plain(pair[1])} s; "
        f"Brier at 10, 30, 60 s {', '.join(map(plain, own))}, memoryless "
        f"{', '.join(map(plain, memoryless))}."
    )
    table = {"score": list(scores), "value": list(scores.values())}
    return Panel(**base, figure=figure, alt=alt, tables={"": table}, wrong=_wrong(scores))


def _wrong(scores: Mapping[str, float]) -> tuple[str, ...]:
    """Say that the forecasts' probabilities do not hold, or that they gain nothing."""
    said = []
    if scores["pit_p"] < REJECTED:
        p = f"<i>p</i> = {plain(scores['pit_p'], 2)}, Kolmogorov–Smirnov"
        said.append(f"The forecasts’ probabilities do not hold ({p})")
    if scores.get("crps_gain_high_s", nan) < 0:
        said.append("The walk’s forecasts are worse than memoryless ones")
    return tuple(said)


def _bars(axes: Any, places: list[float], values: list[list[float]]) -> None:
    for shift, heights, colour, label in (
        (-0.19, values[0], MODEL_COLOUR, "boundary walk"),
        (0.19, values[1], GREY, "memoryless"),
    ):
        at = [place + shift for place in places]
        axes.bar(at, heights, 0.34, color=colour, edgecolor=INK, linewidth=0.4, label=label)
    axes.tick_params(axis="x", length=0)


def _gain_in_words(scores: Mapping[str, float]) -> str:
    """Say how much the forecasts gain, and whether they are calibrated."""
    if not scores.get("passages"):
        return ""
    low, high = (scores.get(f"crps_gain_{end}_s", nan) for end in ("low", "high"))
    between = f" [{plain(low)} … {plain(high)}]" if isfinite(low) and isfinite(high) else ""
    unscored = int(scores.get("passages_unscored", 0))
    text = f" Here the walk gains {plain(scores['crps_gain_s'])} s{between} of CRPS a passage."
    text += (
        f" If its probabilities hold they are uniform: p = {plain(scores['pit_p'], 2)} "
        "(Kolmogorov–Smirnov)."
    )
    if unscored:
        text += (
            f" Without a score, as cut short or begun before a forecast could be made: {unscored}."
        )
    return text
