"""The symbol and the meaning of each quantity of the summary, for people."""

SYMBOLS: dict[str, tuple[str, str, str]] = {
    "r_h_over_R": ("<i>r</i><sub>h</sub>/<i>R</i>", "$r_h/R$", "mode of P(r), head"),
    "r_c_over_R": ("<i>r</i><sub>c</sub>/<i>R</i>", "$r_c/R$", "mode of P(r), centroid"),
    "r_t_over_R": ("<i>r</i><sub>t</sub>/<i>R</i>", "$r_t/R$", "mode of P(r), tail"),
    "psi_b_negative_peak": (
        "ψ<sub>b</sub><sup>−</sup>",
        r"$\psi_b^-$",
        "body angle, clockwise peak",
    ),
    "psi_b_positive_peak": (
        "ψ<sub>b</sub><sup>+</sup>",
        r"$\psi_b^+$",
        "body angle, counter-clockwise peak",
    ),
    "contact_fraction": ("contact", "contact", "fraction of frames with the head at the wall"),
    "d_c": (
        "⟨<i>d</i><sub>c</sub>⟩",
        r"$\langle d_c \rangle$",
        "distance along the wall in contact",
    ),
    "d_nc": (
        "⟨<i>d</i><sub>nc</sub>⟩",
        r"$\langle d_{nc} \rangle$",
        "distance along the wall out of contact",
    ),
    "delta_r_h": (
        "⟨Δ<i>r</i><sub>h</sub>⟩",
        r"$\langle \Delta r_h \rangle$",
        "radial excursion out of contact",
    ),
    "t_per": ("<i>t</i><sub>per</sub>", "$t_{per}$", "decay time of C<sub>θ</sub>(t)"),
    "v_w": (
        "<i>v</i><sub>w</sub>",
        "$v_w$",
        "from v<sub>b</sub> = v<sub>w</sub> sin ψ<sub>b</sub>",
    ),
    "v_b": (
        "⟨|<i>v</i><sub>b</sub>|⟩",
        r"$\langle |v_b| \rangle$",
        "tangential speed along the wall",
    ),
    "reversal_per_cycle": ("reversal", "reversals per cycle", "probability per slide and hop"),
    "reversal_rate": ("reversal rate", "reversal rate", "sign changes of θ̇<sub>h</sub> per time"),
    "tau_h": ("⟨τ<sub>h</sub>⟩", r"$\langle \tau_h \rangle$", "time to find the exit"),
    "n_s": ("<i>n</i><sub>s</sub>", "$n_s$", "skips over the exit"),
    "success": ("success", "success", "passages after the head's entry"),
    "failures_without_contact": (
        "failures without contact",
        "free failures",
        "part of the failed entries",
    ),
    "failures_in_elongation": (
        "failures in elongation",
        "failures in elongation",
        "part of the failed entries",
    ),
    "beta": ("β", r"$\beta$", "decay of F(x<sub>p</sub>)"),
    "w_s": ("<i>w</i><sub>s</sub>", "$w_s$", "effective width √(W² + h²)"),
    "l_w": ("<i>l</i><sub>w</sub>", "$l_w$", "length of the worm"),
    "d_w": ("<i>d</i><sub>w</sub>", "$d_w$", "width of the worm"),
}
"""HTML, matplotlib's own markup, and meaning (HTML)."""

UNITS = {"1": "", "deg": "°"}


def html_symbol(name: str) -> str:
    """Return a quantity's symbol as HTML; its name where it has none."""
    return SYMBOLS[name][0] if name in SYMBOLS else name


def plain_symbol(name: str) -> str:
    """Return a quantity's symbol for a figure; its name where it has none."""
    return SYMBOLS[name][1] if name in SYMBOLS else name.replace("_", " ")


def meaning(name: str) -> str:
    """Return what a quantity is, as HTML; empty where that is not known here."""
    return SYMBOLS[name][2] if name in SYMBOLS else ""
