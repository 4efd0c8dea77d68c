"""Numbers of items in words."""

import re

_NOUN = re.compile(r"(.*?)(ies|ches|s)?( (?:of|with|whose|in|that|from|above|after)\b.*|,.*|$)")
_SINGULAR = {"ies": "y", "ches": "ch", "s": ""}


def items_in_words(number: int, items: str) -> str:
    """Return the items' name for a number of them.

    Parameters
    ----------
    number : int
        How many.
    items : str
        In the plural, what they are first: ``findings of the exit``, ``searches``.
    """
    found = _NOUN.fullmatch(items)
    if number != 1 or found is None:
        return items
    return found[1] + _SINGULAR.get(found[2] or "", "") + found[3]


def not_enough(number: int, items: str, needed: int) -> str:
    """Say that there are too few items, such as ``visits``, and how many are needed."""
    return f"not enough data: {number} {items_in_words(number, items)}, {needed} are needed"
