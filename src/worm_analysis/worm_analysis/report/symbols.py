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
    "v_b_mean": ("⟨<i>v</i><sub>b</sub>⟩", r"$\langle v_b \rangle$", "mean speed, signed"),
    "psi_b_mean": ("⟨ψ<sub>b</sub>⟩", r"$\langle\psi_b\rangle$", "mean body angle"),
    "theta_dot_psi_b_correlation": (
        "r(θ̇<sub>h</sub>, ψ<sub>b</sub>)",
        r"$r(\dot\theta_h, \psi_b)$",
        "correlation of speed and body angle",
    ),
    "theta_dot_incidence_correlation": (
        "r(θ̇<sub>h</sub>, θ<sub>h</sub><sup>i</sup>)",
        r"$r(\dot\theta_h, \theta_h^i)$",
        "correlation of speed after a contact and incidence",
    ),
    "d_c_exponential_p": (
        "p(<i>d</i><sub>c</sub>)",
        "$p(d_c)$",
        "fit of an exponential law: small is bad",
    ),
    "d_nc_exponential_p": (
        "p(<i>d</i><sub>nc</sub>)",
        "$p(d_{nc})$",
        "fit of an exponential law: small is bad",
    ),
    "delta_r_h_exponential_p": (
        "p(Δ<i>r</i><sub>h</sub>)",
        r"$p(\Delta r_h)$",
        "fit of an exponential law: small is bad",
    ),
    "tau_h_exponential_p": (
        "p(τ<sub>h</sub>)",
        r"$p(\tau_h)$",
        "fit of an exponential law: small is bad",
    ),
    "alpha": ("α", r"$\alpha$", "F(x<sub>p</sub>) where it begins, without the constant"),
    "const": ("constant", "constant", "of F(x<sub>p</sub>)"),
    "failures_touching_in_elongation": (
        "touching in elongation",
        "touching in elongation",
        "part of the failed entries",
    ),
    "failures_touching_in_contraction": (
        "touching in contraction",
        "touching in contraction",
        "part of the failed entries",
    ),
    "failures_of_unknown_phase": (
        "of unknown phase",
        "of unknown phase",
        "part of the failed entries",
    ),
    "frames_untracked": ("frames untracked", "frames untracked", "part that counts for nothing"),
    "frames_uncertain": (
        "frames uncertain",
        "frames uncertain",
        "part whose head and tail may be exchanged, which counts for nothing",
    ),
    "reversal_per_cycle": ("reversal", "reversals per cycle", "probability per slide and hop"),
    "reversal_rate": ("reversal rate", "reversal rate", "sign changes of θ̇<sub>h</sub> per time"),
    "tau_h": ("⟨τ<sub>h</sub>⟩", r"$\langle \tau_h \rangle$", "time to find the exit"),
    "tau_escape": (
        "⟨τ<sub>e</sub>⟩",
        r"$\langle \tau_e \rangle$",
        "time until the whole worm is out",
    ),
    "escape_ratio": ("τ<sub>e</sub>/τ<sub>h</sub>", r"$\tau_e/\tau_h$", "escape over finding"),
    "reversal": ("reversal", "reversal", "as counted at the wall"),
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
