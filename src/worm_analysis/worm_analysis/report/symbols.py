"""The symbol and the meaning of each quantity, for people: the table's own, and the model's."""

from worm_analysis.summary.quantities import DEFINITIONS

_OF_THE_MODEL = {
    "tau_escape": (
        "⟨τ<sub>e</sub>⟩",
        r"$\langle \tau_e \rangle$",
        "time until the whole worm is out",
    ),
    "escape_ratio": ("τ<sub>e</sub>/τ<sub>h</sub>", r"$\tau_e/\tau_h$", "escape over finding"),
    "reversal": ("reversal", "reversal", "as counted at the wall"),
}
SYMBOLS: dict[str, tuple[str, str, str]] = {
    item.name: (item.html, item.plain, item.meaning) for item in DEFINITIONS.values()
} | _OF_THE_MODEL
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
