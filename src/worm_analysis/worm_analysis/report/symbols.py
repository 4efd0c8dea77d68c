"""The symbol and the meaning of each quantity, for people: the table's own, and the model's."""

import re
from html import escape, unescape

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
UNITS_IN_NAMES = {"deg": "°", "mib": "MiB", "mm_s": "mm/s"}
"""Units as names of settings end in them, where they are not written so."""


def html_symbol(name: str) -> str:
    """Return a quantity's symbol as HTML; its name in words where it has none."""
    return _symbol_of(name, 0, name.replace("_", " "))


def spoken(name: str) -> str:
    """Return a quantity's symbol as text without markup, for a screen reader."""
    return unescape(re.sub(r"<[^>]*>", "", html_symbol(name)))


def plain_symbol(name: str) -> str:
    """Return a quantity's symbol for a figure; its name where it has none."""
    return _symbol_of(name, 1, name.replace("_", " "))


def meaning(name: str) -> str:
    """Return what a quantity is, as HTML; empty where that is not known here."""
    return _symbol_of(name, 2, "")


def is_known(name: str) -> bool:
    """Whether a quantity has a symbol, which is markup of ours."""
    return under_rule(name)[0] in SYMBOLS


def under_rule(name: str) -> tuple[str, str]:
    """Return a quantity's own name, and the rule of contact that it is told under, in words."""
    own, _, rule = name.partition("_at_")
    rule = re.sub(r"(.*)_s_([^_]+)", r"\1 \2 s", rule).replace("_", " ")
    return (own, rule) if own in SYMBOLS else (name, "")


def setting_in_words(key: str) -> str:
    """Return the name of a setting in words: ``max_bridged_s`` is ``max bridged (s)``."""
    found = re.fullmatch(r"(.+?)_((?:mm_)?(?:m|mm|px|s|rad|deg|mib))", key)
    if found is None or found[1].endswith("_per"):
        return key.replace("_", " ")
    return f"{found[1].replace('_', ' ')} ({UNITS_IN_NAMES.get(found[2], found[2])})"


def choice_in_words(choice: object) -> str:
    """Return what a setting is set to, in words: a symbol for a quantity, ``per cycle``."""
    text = "not set" if choice is None else str(choice)
    if text in SYMBOLS:
        return spoken(text)
    return text.replace("_", " ") if re.fullmatch(r"[a-z]+(_[a-z]+)+", text) else text


def _symbol_of(name: str, column: int, other: str) -> str:
    own, rule = under_rule(name)
    if own not in SYMBOLS:
        return other
    if column == 0 and rule:
        return f"{SYMBOLS[own][0]} ({escape(rule)})"
    if column == 2 and rule:
        return f"{SYMBOLS[own][2]}, with {escape(rule)}"
    return SYMBOLS[own][column]
