"""The table of quantities: one definition of every number, for a trial and for several pooled.

A quantity is a name, a unit, a symbol, a meaning, the sums that it rests on and how its value
follows from them. A trial's interval leaves out blocks of time, a pool's whole trials as well.
The paper's values: `worm_msgs_py.paper`.
"""

from collections.abc import Iterable
from functools import lru_cache
from math import degrees, inf, nan

import numpy as np

from worm_analysis.accumulators.bins import (
    BODY_LENGTH_BIN_M,
    BODY_WIDTH_BIN_M,
    LENGTH_BIN_M,
    TAU_BIN_S,
)
from worm_analysis.summary import direction_persistence as c_theta
from worm_analysis.summary import estimates as by
from worm_analysis.summary import failure_causes as causes
from worm_analysis.summary import peaks
from worm_analysis.summary.definition import NO_CHAMBER, NO_EXIT, Definition, first
from worm_analysis.summary.resolution import radius_noise_m
from worm_analysis.summary.sums import Sums
from worm_msgs_py import Quantity
from worm_msgs_py.arrays import Floats
from worm_msgs_py.intervals import Interval
from worm_msgs_py.paper import TRIAL_S
from worm_msgs_py.units import MM_PER_M


def _third(total: Floats) -> float:
    return float(total[2])


FRAMES, WITH_BODY, WITH_SPEED = (
    "frames in a chamber",
    "frames with a body angle",
    "frames with a speed",
)
WITH_BOTH = "frames with a speed and a body angle"
CONTACTS = "complete contacts above the resolution limit"
EXCURSIONS = "complete excursions above the resolution limit"
FINDINGS = "findings of the exit after a contact"
CAUSES = "failed attempts whose cause can be told"
OF_STATES = "most_noise_for_states"
PART_OF_FAILURES = "part of the failed entries"
SMALL_IS_BAD = "fit of an exponential law: small is bad"


def _peak_of_radius(point: str, where: str) -> Definition:
    return Definition(
        f"r_{point}_over_R", "1", f"<i>r</i><sub>{point}</sub>/<i>R</i>", f"$r_{point}/R$",
        f"most frequent distance from the centre, {where}", f"r_{point}",
        peaks.radius_peak(f"r_{point}"), FRAMES, np.sum, bounds=(0.0, 1.0),
        undetermined="no distance is the most frequent one",
    )  # fmt: skip


def _peak_of_angle(side: int) -> Definition:
    name, sign, turn, bounds = (
        ("negative", "−", "clockwise", (-180.0, 0.0)),
        ("positive", "+", "counter-clockwise", (0.0, 180.0)),
    )[side]
    return Definition(
        f"psi_b_{name}_peak", "deg", f"ψ<sub>b</sub><sup>{sign}</sup>",
        rf"$\psi_b^{'-' if sign == '−' else sign}$", f"body angle, {turn} peak", "psi_b",
        peaks.angle_peak("psi_b", side), WITH_BODY, np.sum, scale=degrees(1.0), bounds=bounds,
        undetermined="the body angles have no peak of their own on this side",
    )  # fmt: skip


def _quantile_definitions(point: str, html: str, plain: str) -> list[Definition]:
    """Return the tenth, the half and nine tenths of r/R of a point; of ψ_b where none is given."""
    found = []
    for percent in (10, 50, 90):
        if point:
            name, sums, scale, bounds = f"r_{point}_over_R", f"r_{point}", 1.0, (0.0, 1.0)
            estimate, items = peaks.radius_quantile(sums, percent / 100), FRAMES
        else:
            name, sums, scale, bounds = "psi_b", "psi_b", degrees(1.0), (-180.0, 180.0)
            estimate, items = peaks.angle_quantile(sums, percent / 100), WITH_BODY
        found.append(
            Definition(
                f"{name}_q{percent}", "1" if point else "deg", f"{html}, {percent} %",
                f"{plain}, {percent} %", f"{percent} % of the frames are below it", sums,
                estimate, items, np.sum, scale=scale, bounds=bounds,
            )
        )  # fmt: skip
    return found


def _length(name: str, html: str, plain: str, meaning: str, which: int, items: str) -> Definition:
    return Definition(
        name, "mm", f"⟨{html}⟩", rf"$\langle {plain} \rangle$", meaning, name,
        by.length(name, which), items, _third if which < 2 else first, scale=MM_PER_M,
        within_radius=which == 2, most_noise=OF_STATES, refused_if_hidden=True,
    )  # fmt: skip


def _plain_mean(name: str, html: str, plain: str, items: str) -> Definition:
    return Definition(
        f"{name}_mean", "mm", f"mean {html}", f"mean ${plain}$",
        "plain mean of those that were seen whole", f"{name}_mean", by.mean(f"{name}_mean"), items,
        scale=MM_PER_M, bounds=(0.0, inf), within_radius=name == "delta_r_h",
        most_noise=OF_STATES, refused_if_hidden=True,
    )  # fmt: skip


def _radius_noise(sums: Sums) -> Interval:
    noise, _ = radius_noise_m(sums)
    return noise if noise[0] > 0 else (nan, nan, nan)


def _fit(name: str, html: str, plain: str, bin_width: float, items: str) -> Definition:
    missing = NO_EXIT if name == "tau_h" else NO_CHAMBER
    return Definition(
        f"{name}_exponential_p", "1", f"p({html})", f"$p({plain})$", SMALL_IS_BAD, f"{name}_excess",
        by.exponential_fit(f"{name}_excess", bin_width), items, lambda total: total[:-1].sum(),
        needs="fewest_for_p", missing=missing,
        most_noise="" if name == "tau_h" else OF_STATES,
    )  # fmt: skip


def _share_definition(
    name: str, items: str, words: str = "", meaning: str = PART_OF_FAILURES
) -> Definition:
    words = words or name.replace("_", " ")
    return Definition(name, "1", words, words, meaning, name, by.share(name), items)


def _touching(phase: str) -> Definition:
    name, words = f"failures_touching_in_{phase}", f"touching in {phase}"
    return Definition(
        name, "1", words, words, PART_OF_FAILURES, name, causes.touching_share(name), CAUSES
    )


def _decay(name: str, html: str, plain: str, meaning: str) -> Definition:
    return Definition(
        name, "1/mm", html, plain, meaning, "x_p", by.penetration_part(name), "failed attempts",
        np.sum, scale=1 / MM_PER_M, needs="fewest_for_decay",
    )  # fmt: skip


def _size_definition(name: str, letter: str, what: str, bin_m: float) -> Definition:
    return Definition(
        name, "mm", f"<i>{letter}</i><sub>w</sub>", f"${letter}_w$", f"{what} of the worm", name,
        by.median(name, bin_m), "frames with a body and a scale", np.sum, scale=MM_PER_M,
        bounds=(0.0, inf),
    )  # fmt: skip


def _excluded(reason: str, meaning: str) -> Definition:
    name, words = f"frames_{reason}", f"frames {reason}"
    return Definition(
        name, "1", words, words, meaning, name, by.exact(name), "frames", needs="",
        undetermined="not a frame was read",
    )  # fmt: skip


def _gap(kind: str, which: str) -> Definition:
    name, words = f"search_{kind}", f"search {kind}"
    return Definition(
        name, "1", words, words, f"part of the search in gaps without a certain head {which}", name,
        by.exact(name), "seconds of search", needs="", undetermined="no search was seen",
    )  # fmt: skip


POSITIONS = (
    _peak_of_radius("h", "head"),
    _peak_of_radius("c", "centroid"),
    _peak_of_radius("t", "tail"),
    _peak_of_angle(0),
    _peak_of_angle(1),
    *_quantile_definitions("h", "<i>r</i><sub>h</sub>/<i>R</i>", "$r_h/R$"),
    *_quantile_definitions("c", "<i>r</i><sub>c</sub>/<i>R</i>", "$r_c/R$"),
    *_quantile_definitions("", "ψ<sub>b</sub>", r"$\psi_b$"),
    Definition(
        "contact_fraction", "1", "contact", "contact",
        "fraction of frames with the head at the wall", "contact_fraction",
        by.mean("contact_fraction"), FRAMES, bounds=(0.0, 1.0),
    ),
)  # fmt: skip
"""Figs 1d and 1e."""

EPISODES = (
    _length("d_c", "<i>d</i><sub>c</sub>", "d_c", "distance along the wall in contact, as a law",
            0, "complete contacts"),
    _length("d_nc", "<i>d</i><sub>nc</sub>", "d_{nc}", "the same out of contact",
            1, "complete excursions"),
    _length("delta_r_h", "Δ<i>r</i><sub>h</sub>", r"\Delta r_h", "radial excursion, as a law",
            2, EXCURSIONS),
    _plain_mean("d_c", "<i>d</i><sub>c</sub>", "d_c", "complete contacts"),
    _plain_mean("d_nc", "<i>d</i><sub>nc</sub>", "d_{nc}", "complete excursions"),
    _plain_mean("delta_r_h", "Δ<i>r</i><sub>h</sub>", r"\Delta r_h", "excursions past their peak"),
    Definition(
        "radius_noise", "mm", "σ(<i>r</i><sub>h</sub>)", r"$\sigma(r_h)$",
        "noise of the head's radius, from its spread in contact", "radius_noise",
        _radius_noise, "complete contacts", scale=MM_PER_M,
        undetermined="less than a sixtieth of the distance that counts as contact",
    ),
    _fit("d_c", "<i>d</i><sub>c</sub>", "d_c", LENGTH_BIN_M, CONTACTS),
    _fit("d_nc", "<i>d</i><sub>nc</sub>", "d_{nc}", LENGTH_BIN_M, EXCURSIONS),
    _fit("delta_r_h", "Δ<i>r</i><sub>h</sub>", r"\Delta r_h", LENGTH_BIN_M, EXCURSIONS),
)  # fmt: skip
"""Fig. 3, with what frames and pixels hide allowed for: `worm_analysis.summary.estimates`."""

MOTION = (
    Definition(
        "t_per", "s", "<i>t</i><sub>per</sub>", "$t_{per}$",
        "time over which the direction along the wall is kept", "c_theta",
        by.persistence(c_theta.persistence_time), "moments with a direction",
    ),
    Definition(
        "t_1e", "s", "<i>t</i><sub>1/e</sub>", "$t_{1/e}$",
        "time at which C<sub>θ</sub> has fallen to 1/e, whatever its form", "c_theta",
        by.persistence(c_theta.fall_time), "moments with a direction",
    ),
    Definition(
        "t_1e_over_t_per", "1", "<i>t</i><sub>1/e</sub>/<i>t</i><sub>per</sub>",
        "$t_{1/e}/t_{per}$", "1 where C<sub>θ</sub> is one exponential", "c_theta",
        by.persistence(c_theta.fall_over_decay), "moments with a direction",
    ),
    Definition(
        "c_theta_tail", "1", "<i>C</i><sub>θ</sub> − fit", r"$C_\theta$ − fit",
        "mean from 1.5 t<sub>per</sub> on; 0 where C<sub>θ</sub> is one exponential", "c_theta",
        by.persistence(c_theta.tail_excess), "moments with a direction",
    ),
    Definition(
        "c_theta_start", "1", "<i>C</i><sub>θ</sub> − fit, start", r"$C_\theta$ − fit, start",
        "mean up to 0.5 t<sub>per</sub>; 0 where C<sub>θ</sub> is one exponential", "c_theta",
        by.persistence(c_theta.start_excess), "moments with a direction",
    ),
    Definition(
        "v_w", "mm/s", "<i>v</i><sub>w</sub>", "$v_w$",
        "from v<sub>b</sub> = v<sub>w</sub> sin ψ<sub>b</sub>", "v_w", by.slope("v_w"),
        "windows of time with a speed and a body angle", scale=MM_PER_M,
    ),
    Definition(
        "v_b", "mm/s", "⟨|<i>v</i><sub>b</sub>|⟩", r"$\langle |v_b| \rangle$",
        "tangential speed within contacts and excursions near the wall", "v_b",
        by.way_over_time("v_b"), "seconds near the wall", scale=MM_PER_M, bounds=(0.0, inf),
    ),
    Definition(
        "v_b_mean", "mm/s", "⟨<i>v</i><sub>b</sub>⟩", r"$\langle v_b \rangle$",
        "mean speed, signed", "v_b_mean", by.mean("v_b_mean"), WITH_SPEED, scale=MM_PER_M,
    ),
    Definition(
        "psi_b_mean", "deg", "⟨ψ<sub>b</sub>⟩", r"$\langle\psi_b\rangle$", "mean body angle",
        "psi_b_mean", by.direction("psi_b_mean"), WITH_BODY, scale=degrees(1.0),
    ),
    Definition(
        "theta_dot_psi_b_correlation", "1", "r(θ̇<sub>h</sub>, ψ<sub>b</sub>)",
        r"$r(\dot\theta_h, \psi_b)$", "correlation of speed and body angle", "theta_dot_psi_b",
        by.pearson_of("theta_dot_psi_b"), WITH_BOTH,
        undetermined="the speed or the body angle does not vary",
    ),
    Definition(
        "theta_dot_incidence_correlation", "1",
        "r(θ̇<sub>h</sub>, θ<sub>h</sub><sup>i</sup>)", r"$r(\dot\theta_h, \theta_h^i)$",
        "correlation of speed after a contact and incidence", "theta_dot_incidence",
        by.pearson_of("theta_dot_incidence"), "contacts with an incidence and a speed after it",
        undetermined="the speed or the incidence does not vary",
    ),
    Definition(
        "reversal_per_cycle", "1", "reversal", "reversals per cycle",
        "probability per slide and hop", "reversal_per_cycle", by.reversal_chance,
        "pairs of cycles", bounds=(0.0, 1.0), most_noise=OF_STATES, refused_if_hidden=True,
    ),
    _gap("bridged", "over which the direction is followed"),
    _gap("missing", "too long for the direction to be followed"),
    Definition(
        "search_contact_untold", "1", "search contact untold", "search contact untold",
        "part of the search in which contact cannot be told: head not well placed, or no width",
        "search_contact_untold", by.exact("search_contact_untold"), "seconds of search", needs="",
        undetermined="no search was seen",
    ),
    Definition(
        "reversal_rate", "1/s", "reversal rate", "reversal rate",
        "sign changes of θ̇<sub>h</sub> per time", "reversal_rate", by.reversal_rate,
        "seconds with a direction", bounds=(0.0, inf),
    ),
)  # fmt: skip
"""Figs 4 and 7a, and the reversals."""

SEARCHES = (
    Definition(
        "tau_h", "s", "⟨τ<sub>h</sub>⟩", r"$\langle \tau_h \rangle$", "time to find the exit",
        "tau_h", by.length("tau_h"), FINDINGS, missing=NO_EXIT,
    ),
    _fit("tau_h", "τ<sub>h</sub>", r"\tau_h", TAU_BIN_S, FINDINGS),
    Definition(
        "n_s", "per 30 min", "<i>n</i><sub>s</sub>", "$n_s$",
        "skips over the exit, near the wall", "n_s",
        by.rate("n_s"), "seconds in a chamber", shown=lambda total: total[1], scale=TRIAL_S,
        missing=NO_EXIT,
    ),
    Definition(
        "n_s_over_w_s", "per 30 min", "<i>n</i><sub>s</sub>(<i>w</i><sub>s</sub>)", "$n_s(w_s)$",
        "the same over an exit as wide as w<sub>s</sub>", "n_s_over_w_s", by.rate("n_s_over_w_s"),
        "seconds in a chamber", shown=lambda total: total[1], scale=TRIAL_S, missing=NO_EXIT,
    ),
)  # fmt: skip
"""Figs 5 and 6."""

ATTEMPTS = (
    _share_definition("success", "decided attempts", meaning="passages after the head's entry"),
    Definition(
        "failures_without_contact", "1", "failures without contact", "failures without contact",
        PART_OF_FAILURES, "failures_without_contact",
        causes.share_of_determined("failures_without_contact"),
        "failed attempts in which contact can be told",
    ),
    _share_definition("failures_in_elongation", "failed attempts with a known phase of the stroke"),
    _touching("elongation"),
    _touching("contraction"),
    _share_definition("failures_of_unknown_phase", "failed attempts", "of unknown phase"),
    _decay("beta", "β", r"$\beta$", "decay of F(x<sub>p</sub>)"),
    _decay("alpha", "α", r"$\alpha$", "F(x<sub>p</sub>) where it begins, without the constant"),
    _decay("const", "constant", "constant", "of F(x<sub>p</sub>)"),
    Definition(
        "w_s", "mm", "<i>w</i><sub>s</sub>", "$w_s$", "effective width √(W² + h²)", "w_s",
        by.exact("w_s"), "trials", scale=MM_PER_M, needs="", missing=NO_EXIT,
    ),
)  # fmt: skip
"""Figs 8 and 9. Depths below that of the circle's own bulge over the mouth are not all seen."""

BODY = (
    _size_definition("l_w", "l", "length", BODY_LENGTH_BIN_M),
    _size_definition("d_w", "d", "width", BODY_WIDTH_BIN_M),
    _excluded("untracked", "part of the frames that no estimate uses: no head was found"),
    _excluded("uncertain", "part of the frames that no estimate uses: the head is in doubt"),
)

QUANTITIES = (*POSITIONS, *EPISODES, *MOTION, *SEARCHES, *ATTEMPTS)
DEFINITIONS = {definition.name: definition for definition in (*QUANTITIES, *BODY)}


def definitions(rules: Iterable[str] = ()) -> list[Definition]:
    """Return the whole table, with d_c and d_nc under other rules of contact, by their labels."""
    return [*QUANTITIES, *(d for rule in rules for d in _under_rule(rule)), *BODY]


@lru_cache(maxsize=64)
def _under_rule(rule: str) -> list[Definition]:
    return [
        Definition(
            f"{name}_at_{rule}", "mm", f"{name}_at_{rule}", f"{name} at {rule}".replace("_", " "),
            "", f"{name}_at_{rule}", by.length(f"{name}_at_{rule}", which, f"_at_{rule}"), items,
            scale=MM_PER_M, most_noise="most_noise_for_rule",
        )
        for which, (name, items) in enumerate((("d_c", CONTACTS), ("d_nc", EXCURSIONS)))
    ]  # fmt: skip


def quantities(sums: Sums, rules: Iterable[str] = ()) -> list[Quantity]:
    """Return every number, in the table's order."""
    return [definition.of(sums) for definition in definitions(rules)]
