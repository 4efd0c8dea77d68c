"""Fig. 8: how often the worm goes through after its head has entered the exit."""

from typing import Any

from worm_analysis.report.figures.search_by_width import draw_by_width
from worm_analysis.report.panel import Panel
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import COLUMN_IN, PAPER_STYLE, new_figure
from worm_analysis.summary.definition import NO_CHAMBER
from worm_msgs_py.paper import paper_number

_READING = (
    "Attempts in which the centroid entered the passage after the head did, over all attempts "
    "that were decided, with 95 % intervals; n above each is the number of trials. Dashed: the "
    "paper’s, about 60 % for every width."
)


def success(data: ReportData) -> Panel:
    """Return the panel."""
    pool = data.pool
    attempts = 0 if pool is None else pool.count("success")
    n = data.counted(attempts, "attempts")
    base: dict[str, Any] = {
        "key": "fig-8", "title": "Success after the head’s entry", "paper": "Fig. 8",
        "reading": _READING, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    rows = [(part.width_mm, numbers["success"]) for part, numbers in data.by_width]
    known = [(width, pooled) for width, pooled in rows if pooled.quantity.value is not None]
    if not known:
        return Panel(**base, why=f"not enough data: {attempts} attempts, 10 are needed for a W")
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    axes.axhline(paper_number("success"), label="paper, 0.6", **PAPER_STYLE)
    table = draw_by_width(axes, known)
    axes.set_xlim(0, max(5.4, 1.08 * max(width for width, _ in rows)))
    axes.set_ylim(0, 1.12)
    axes.set_yticks([0, 0.2, 0.4, 0.6, 0.8, 1.0])
    axes.set_xlabel("width of the exit $W$ (mm)")
    axes.set_ylabel("success (fraction of attempts)")
    figure.legend(loc="outside upper center", ncols=2, title=n, title_fontsize=7.0)
    told = ", ".join(f"{w:g} mm: {p.quantity.value:.2f}" for w, p in known)
    return Panel(**base, figure=figure, alt=f"Success by width, {n}. {told}.", tables={"": table})
