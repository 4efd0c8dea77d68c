"""Fig. 4: the speed along the wall against the body's angle, and against that of a collision."""

from typing import Any

import numpy as np

from worm_analysis.pooling import Pool
from worm_analysis.pooling.trial_sums import ANGLE_EDGES_DEG
from worm_analysis.report.evidence import Evidence
from worm_analysis.report.numbers import plain, with_interval
from worm_analysis.report.panel import NO_CHAMBER, Panel
from worm_analysis.report.theme import COLUMN_IN, GREY, HEAD, INK, PAPER_STYLE, new_figure, say_n
from worm_analysis.results import Floats

FEWEST = 30
MOST_POINTS = 1500
BIN_DEG = 10.0
FEWEST_IN_BIN, LEAST_PART = 20, 0.005
"""Bins with fewer frames, or a smaller part of all of them, have no mean."""
POINTS: dict[str, Any] = {"color": HEAD, "markersize": 2.2, "alpha": 0.4, "mew": 0, "zorder": 1}
PAPER_V_W_MM_S = 2.02
READING_ANGLE = (
    "θ̇<sub>h</sub> = Δθ<sub>h</sub>/Δ<i>t</i> over Δ<i>t</i> = 1 s, against the body angle "
    "ψ<sub>b</sub> in the same frame. Points: frames, evenly thinned. Black: the mean over all "
    "frames in 10° of ψ<sub>b</sub>. The paper finds that θ̇<sub>h</sub> grows with "
    "ψ<sub>b</sub>. r: Pearson’s correlation over all frames."
)
READING_INCIDENCE = (
    "θ̇<sub>h</sub> over the Δ<i>t</i> = 1 s after the head came into contact with the wall, "
    "against its incidence θ<sub>h</sub><sup>i</sup>: the signed angle between the head’s "
    "displacement just before the contact and the outward normal. Points: contacts, evenly "
    "thinned. The paper finds no correlation. r: Pearson’s correlation over all contacts."
)
READING_LAW = (
    "⟨<i>v</i><sub>b</sub>⟩ = <i>R</i>⟨θ̇<sub>h</sub>⟩ against the sine of the mean body angle. "
    "Blue points: short windows of time (mean_window_s), evenly thinned. Black: searches, that is "
    "visits of a chamber, longer ones cut into minutes (the paper has one point a trial). Line, "
    "fitted to the windows: "
    "⟨<i>v</i><sub>b</sub>⟩ = <i>v</i><sub>w</sub> sin⟨ψ<sub>b</sub>⟩. Dashed: the paper’s "
    "<i>v</i><sub>w</sub> = 2.02 mm/s."
)


def speed_against_angle(evidence: Evidence) -> Panel:
    """Return Fig. 4a: θ̇_h against ψ_b."""
    pool, r = evidence.pool, evidence.quantity("theta_dot_psi_b_correlation")
    frames = 0 if pool is None else int(pool.total("theta_dot_psi_b")[0])
    n = evidence.counted(frames, "frames")
    base: dict[str, Any] = {
        "key": "fig-4a", "title": "Angular speed against the body’s angle", "paper": "Fig. 4a",
        "reading": READING_ANGLE, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if frames < FEWEST:
        return Panel(**base, why=f"not enough data: {frames} frames, {FEWEST} are needed")
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    x, y = _thinned(pool, "frame_psi_b", "frame_theta_dot")
    axes.plot(x, y, "o", **POINTS)
    mean, count = np.split(pool.total("theta_dot_by_psi_b"), 2)
    edges = ANGLE_EDGES_DEG[::5]
    seen = count >= max(FEWEST_IN_BIN, LEAST_PART * frames)
    middles = (edges[1:] + edges[:-1]) / 2
    means = np.divide(mean, count, out=np.full(len(mean), np.nan), where=seen)
    axes.plot(middles, means, "o-", color=INK, markersize=3, linewidth=0.8, label="mean in 10°")
    _cross(axes)
    axes.set_xlim(*_reach(x, 120.0, 180.0))
    axes.set_xticks(np.arange(-180, 181, 60))
    axes.set_xlim(*_reach(x, 120.0, 180.0))
    _limit_y(axes, y)
    axes.set_xlabel(r"$\psi_b$ (degrees)")
    axes.set_ylabel(r"$\dot\theta_h$ (degrees/s)")
    axes.legend(loc="lower right")
    say_n(axes, _with_r(n, pool, "theta_dot_psi_b", r), x=0.03)
    tables = {
        "points": {"psi_b_deg": x, "theta_dot_deg_s": y},
        "means": {"psi_b_deg": middles, "theta_dot_deg_s": means, "frames": count},
    }
    return Panel(**base, figure=figure, alt=f"θ̇_h against ψ_b, {n}.", tables=tables)


def speed_after_collision(evidence: Evidence) -> Panel:
    """Return Fig. 4b: θ̇_h after a collision against θ_h^i."""
    pool, r = evidence.pool, evidence.quantity("theta_dot_incidence_correlation")
    contacts = 0 if pool is None else int(pool.total("theta_dot_incidence")[0])
    n = evidence.counted(contacts, "contacts")
    base: dict[str, Any] = {
        "key": "fig-4b", "title": "Angular speed after a collision against its incidence",
        "paper": "Fig. 4b", "reading": READING_INCIDENCE, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if contacts < FEWEST:
        return Panel(**base, why=f"not enough data: {contacts} contacts, {FEWEST} are needed")
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    x, y = _thinned(pool, "incidence", "theta_dot_after")
    axes.plot(x, y, "o", **(POINTS | {"alpha": 0.5}))
    _cross(axes)
    axes.set_xticks(np.arange(-180, 181, 45))
    axes.set_xlim(*_reach(x, 95.0, 180.0))
    _limit_y(axes, y)
    axes.set_xlabel(r"$\theta_h^{\,i}$ (degrees)")
    axes.set_ylabel(r"$\dot\theta_h$ after it (degrees/s)")
    say_n(axes, _with_r(n, pool, "theta_dot_incidence", r), x=0.03)
    tables = {"": {"incidence_deg": x, "theta_dot_deg_s": y}}
    return Panel(**base, figure=figure, alt=f"θ̇_h after a collision, {n}.", tables=tables)


def speed_law(evidence: Evidence) -> Panel:
    """Return Fig. 4c: ⟨v_b⟩ against sin⟨ψ_b⟩, with v_w."""
    pool, v_w = evidence.pool, evidence.quantity("v_w")
    windows = 0 if pool is None else len(pool.events("window_v_b"))
    searches = 0 if pool is None else len(pool.events("search_v_b"))
    n = evidence.counted(searches, f"searches, {windows} windows")
    base: dict[str, Any] = {
        "key": "fig-4c", "title": "Speed along the wall against the sine of the body’s angle",
        "paper": "Fig. 4c", "reading": READING_LAW, "n": n,
    }  # fmt: skip
    if pool is None:
        return Panel(**base, why=NO_CHAMBER)
    if windows < FEWEST // 3:
        return Panel(**base, why=f"not enough data: {windows} windows of time")
    figure = new_figure(COLUMN_IN, 2.7)
    axes = figure.add_subplot()
    psi, v = _thinned(pool, "window_psi_b", "window_v_b", MOST_POINTS // 2)
    s = np.sin(np.radians(psi))
    axes.plot(s, v, "o", **POINTS)
    s_search = np.sin(np.radians(pool.events("search_psi_b")))
    v_search = pool.events("search_v_b")
    axes.plot(s_search, v_search, "o", color=INK, markersize=2.6, mew=0, alpha=0.8)
    ends = np.array([-1.0, 1.0])
    if v_w.value is not None:
        label = f"fit, $v_w$ = {with_interval(v_w)} mm/s"
        axes.plot(ends, v_w.value * ends, color=HEAD, label=label)
    axes.plot(
        ends, PAPER_V_W_MM_S * ends, label=f"paper, {plain(PAPER_V_W_MM_S)} mm/s", **PAPER_STYLE
    )
    _cross(axes)
    axes.set_xlim(-1.02, 1.02)
    _limit_y(axes, np.r_[v, v_search], room=1.25)
    axes.set_xlabel(r"$\sin\langle\psi_b\rangle$ (–)")
    axes.set_ylabel(r"$\langle v_b \rangle$ (mm/s)")
    axes.legend(loc="upper left", title=n, title_fontsize=7.0, alignment="left", fontsize=6.5)
    tables = {
        "windows": {"sin_psi_b": s, "v_b_mm_s": v},
        "searches": {"sin_psi_b": s_search, "v_b_mm_s": v_search},
    }
    alt = f"v_b against sin ψ_b, {n}, v_w {with_interval(v_w)} mm/s."
    return Panel(**base, figure=figure, alt=alt, tables=tables)


def _thinned(pool: Pool, x: str, y: str, most: int = MOST_POINTS) -> tuple[Floats, Floats]:
    """Return the pairs of all trials, evenly thinned to so many."""
    first, second = pool.events(x), pool.events(y)
    step = max(1, -(-len(first) // most))
    return first[::step], second[::step]


def _with_r(n: str, pool: Pool, name: str, r: Any) -> str:
    """Write n and Pearson's r; where the summary has none it follows from the sums."""
    if r.value is not None:
        return f"{n}\nr = {with_interval(r)}"
    count, x, y, xx, yy, xy = pool.total(name)
    spread = (xx / count - (x / count) ** 2) * (yy / count - (y / count) ** 2)
    if not spread > 0:
        return n
    return f"{n}\nr = {plain((xy / count - x * y / count**2) / np.sqrt(spread), 2)}"


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
