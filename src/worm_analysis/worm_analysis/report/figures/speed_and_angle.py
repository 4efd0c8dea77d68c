"""Fig. 4: the speed along the wall against the body's angle, and against that of a collision."""

from typing import Any

import numpy as np

from worm_analysis.pooling import Pool
from worm_analysis.pooling.pooled_trial import SHOWN_ANGLES_DEG
from worm_analysis.report.figure_settings import FIGURES
from worm_analysis.report.numbers import plain, with_interval
from worm_analysis.report.panel import Panel, number_of
from worm_analysis.report.report_data import ReportData
from worm_analysis.report.theme import (
    COLUMN_IN,
    GREY,
    HEAD_COLOUR,
    INK,
    PAPER_STYLE,
    new_figure,
    say_n,
)
from worm_analysis.report.verdicts import against_paper
from worm_analysis.statistics.sample_correlation import correlation_of_sums
from worm_analysis.summary.definition import NO_CHAMBER
from worm_analysis.wording import not_enough
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.paper import paper_number
from worm_msgs_py.units import MM_PER_M

_DOTS: dict[str, Any] = {
    "color": HEAD_COLOUR,
    "markersize": 2.2,
    "alpha": 0.4,
    "mew": 0,
    "zorder": 1,
}
LEAST_EXPLAINED = 0.5
"""A line that explains a smaller part of the squared speeds is no law."""
_READING_ANGLE = (
    "θ̇<sub>h</sub> = Δθ<sub>h</sub>/Δ<i>t</i> over Δ<i>t</i> = 1 s, against the body angle "
    "ψ<sub>b</sub> in the same frame. Points: frames, evenly thinned. Black: the mean over all "
    "frames in 10° of ψ<sub>b</sub>. The paper finds that θ̇<sub>h</sub> grows with "
    "ψ<sub>b</sub>. r: Pearson’s correlation over all frames."
)
_READING_INCIDENCE = (
    "θ̇<sub>h</sub> over the Δ<i>t</i> = 1 s after the head came into contact with the wall, "
    "against its incidence θ<sub>h</sub><sup>i</sup>: the signed angle between the head’s "
    "displacement just before the contact and the outward normal. Points: contacts, evenly "
    "thinned. The paper finds no correlation. r: Pearson’s correlation over all contacts. A head "
    "that comes in along the wall and goes on in its direction makes it positive."
)
_READING_LAW = (
    "⟨<i>v</i><sub>b</sub>⟩ = <i>R</i>⟨θ̇<sub>h</sub>⟩ against the sine of the mean body angle. "
    "Blue points: windows of one undulatory stroke (12 s), evenly thinned. Black: searches, that "
    "is visits of a chamber, longer ones cut into minutes (the paper has one point a trial). Line, "
    "fitted to the windows: "
    "⟨<i>v</i><sub>b</sub>⟩ = <i>v</i><sub>w</sub> sin⟨ψ<sub>b</sub>⟩. Dashed: the paper’s "
    "<i>v</i><sub>w</sub> = 2.02 mm/s."
)


def speed_against_angle(data: ReportData) -> Panel:
    """Return Fig. 4a: θ̇_h against ψ_b."""
    pool, r = data.pool, data.quantity("theta_dot_psi_b_correlation")
    frames = 0 if pool is None else pool.count("theta_dot_psi_b")
    n = data.counted(frames, "frames")
    base: dict[str, Any] = {
        "key": "fig-4a", "title": "Angular speed against the body’s angle", "paper": "Fig. 4a",
        "reading": _READING_ANGLE, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if frames < FIGURES.fewest_points:
        return Panel(**base, why=not_enough(frames, "frames", FIGURES.fewest_points))
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    x, y = _thinned(pool.points("frame_psi_b"), pool.points("frame_theta_dot"))
    axes.plot(x, y, "o", **_DOTS)
    mean, count = (
        np.sum([trial.points[f"binned_{what}"] for trial in pool.trials], axis=0)
        for what in ("theta_dot", "frames")
    )
    edges = SHOWN_ANGLES_DEG
    seen = count >= max(FIGURES.fewest_in_bin, FIGURES.smallest_part_in_bin * frames)
    middles = (edges[1:] + edges[:-1]) / 2
    means = np.divide(mean, count, out=np.full(len(mean), np.nan), where=seen)
    axes.plot(middles, means, "o-", color=INK, markersize=3, linewidth=0.8, label="mean in 10°")
    _cross(axes)
    axes.set_xlim(*_reach(x, 120.0, 180.0))
    axes.set_xticks(np.arange(-180, 181, 60))
    axes.set_xlim(*_reach(x, 120.0, 180.0))
    _limit_y(axes, y)
    axes.set_xlabel(r"body angle $\psi_b$ (degrees)")
    axes.set_ylabel(r"angular speed $\dot\theta_h$ (degrees/s)")
    axes.legend(loc="lower right")
    say_n(axes, _with_r(n, pool, "theta_dot_psi_b", r), x=0.03)
    tables = {
        "points": {"psi_b_deg": x, "theta_dot_deg_s": y},
        "means": {"psi_b_deg": middles, "theta_dot_deg_s": means, "frames": count},
    }
    alt = f"Angular speed of the head against the body’s angle, {n}, r {with_interval(r)}."
    wrong = tuple(filter(None, [against_paper(r, expected=True)]))
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def speed_after_collision(data: ReportData) -> Panel:
    """Return Fig. 4b: θ̇_h after a collision against θ_h^i."""
    pool, r = data.pool, data.quantity("theta_dot_incidence_correlation")
    contacts = 0 if pool is None else pool.count("theta_dot_incidence")
    n = data.counted(contacts, "contacts")
    base: dict[str, Any] = {
        "key": "fig-4b", "title": "Angular speed after a collision against its incidence",
        "paper": "Fig. 4b", "reading": _READING_INCIDENCE, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if contacts < FIGURES.fewest_points:
        return Panel(**base, why=not_enough(contacts, "contacts", FIGURES.fewest_points))
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    x, y = _thinned(*np.degrees(pool.pairs("collision_points")).T)
    axes.plot(x, y, "o", **(_DOTS | {"alpha": 0.5}))
    _cross(axes)
    axes.set_xticks(np.arange(-180, 181, 45))
    axes.set_xlim(*_reach(x, 95.0, 180.0))
    _limit_y(axes, y)
    axes.set_xlabel(r"incidence $\theta_h^{\,i}$ (degrees)")
    axes.set_ylabel(r"angular speed after it $\dot\theta_h$ (degrees/s)")
    say_n(axes, _with_r(n, pool, "theta_dot_incidence", r), x=0.03)
    tables = {"": {"incidence_deg": x, "theta_dot_deg_s": y}}
    alt = f"Angular speed of the head after a collision, {n}, r {with_interval(r)}."
    wrong = tuple(filter(None, [against_paper(r, expected=False)]))
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def speed_law(data: ReportData) -> Panel:
    """Return Fig. 4c: ⟨v_b⟩ against sin⟨ψ_b⟩, with v_w."""
    pool, v_w = data.pool, data.quantity("v_w")
    windows = 0 if pool is None else pool.count("v_w")
    searches = 0 if pool is None else len(pool.points("search_v_b"))
    n = data.counted(searches, "searches") + f", {number_of(windows, 'windows')}"
    base: dict[str, Any] = {
        "key": "fig-4c", "title": "Speed along the wall against the sine of the body’s angle",
        "paper": "Fig. 4c", "reading": _READING_LAW, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if windows < FIGURES.fewest_windows:
        return Panel(**base, why=f"not enough data: {windows} windows of time")
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    sines, speeds_m_s = pool.pairs("window_points").T
    s, v = _thinned(sines, MM_PER_M * speeds_m_s, FIGURES.most_points // 2)
    axes.plot(s, v, "o", **_DOTS)
    s_search = np.sin(np.radians(pool.points("search_psi_b")))
    v_search = pool.points("search_v_b")
    axes.plot(s_search, v_search, "o", color=INK, markersize=2.6, mew=0, alpha=0.8)
    ends = np.array([-1.0, 1.0])
    if v_w.value is not None:
        label = f"fit, $v_w$ = {with_interval(v_w)} mm/s"
        axes.plot(ends, v_w.value * ends, color=HEAD_COLOUR, label=label)
    axes.plot(
        ends,
        paper_number("v_w") * ends,
        label=f"paper, {plain(paper_number('v_w'))} mm/s",
        **PAPER_STYLE,
    )
    _cross(axes)
    axes.set_xlim(-1.02, 1.02)
    _limit_y(axes, np.r_[v, v_search], room=1.25)
    axes.set_xlabel("sine of the mean body angle (–)")
    axes.set_ylabel(r"mean speed along the wall $\langle v_b \rangle$ (mm/s)")
    axes.legend(loc="upper left", title=n, title_fontsize=7.0, alignment="left", fontsize=6.5)
    tables = {
        "windows": {"sin_psi_b": s, "v_b_mm_s": v},
        "searches": {"sin_psi_b": s_search, "v_b_mm_s": v_search},
    }
    alt = f"Speed along the wall against the sine, {n}, slope {with_interval(v_w)} mm/s."
    wrong = _why_no_line(v_w, sines, MM_PER_M * speeds_m_s)
    return Panel(**base, figure=figure, alt=alt, tables=tables, wrong=wrong)


def _why_no_line(v_w: Quantity, sine: Floats, speed_mm_s: Floats) -> tuple[str, ...]:
    """Say that a line through the origin tells little of the speeds, if it does."""
    if v_w.value is None:
        return ()
    left = np.sum((speed_mm_s - v_w.value * sine) ** 2)
    explained = 1.0 - float(left / np.sum(speed_mm_s**2))
    if explained >= LEAST_EXPLAINED:
        return ()
    part = max(0, round(100 * explained))
    return (
        "The line is no law here: <i>v</i><sub>w</sub> sin⟨ψ<sub>b</sub>⟩ explains "
        f"{part} % of the windows’ squared speeds",
    )


def _thinned(x: Floats, y: Floats, most: int = FIGURES.most_points) -> tuple[Floats, Floats]:
    """Return pairs, evenly thinned to so many."""
    step = max(1, -(-len(x) // most))
    return x[::step], y[::step]


def _with_r(n: str, pool: Pool, name: str, r: Any) -> str:
    """Write n and Pearson's r; where the summary has none it follows from the sums."""
    if r.value is not None:
        return f"{n}\nr = {with_interval(r)}"
    found = float(correlation_of_sums(pool.total(name)[None])[0])
    return f"{n}\nr = {plain(found, 2)}" if found == found else n


def _cross(axes: Any) -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0)
    axes.axvline(0.0, color=GREY, linewidth=0.5, zorder=0)


def _reach(x: Floats, near: float, far: float) -> tuple[float, float]:
    reach = near if np.mean(np.abs(x) > near) < 0.02 else far
    return -reach, reach


def _limit_y(axes: Any, y: Floats, room: float = 1.15) -> None:
    """Leave out the farthest points, one in two hundred, which would flatten the rest."""
    reach = float(np.quantile(np.abs(y), 0.995)) * room
    axes.set_ylim(-reach, reach) if reach > 0 else None
