"""Options that take numbers: each is checked when it is read, and its help says its range."""

from collections.abc import Callable
from itertools import cycle
from typing import Any

import typer

from worm_msgs_py.declarations import Declaration
from worm_msgs_py.limits import Limit


def number(limit: Limit, *names: str, help: str = "", **settings: Any) -> Any:
    """Return a typer option for a number, or for several of the same kind.

    Parameters
    ----------
    limit : Limit
        What it may be; NaN and infinity are always refused.
    *names : str
        As it is written, where that is not the argument's name.
    help : str
        For people; the range is added.
    **settings
        Of `typer.Option`.
    """
    said = f"{help} [{limit.in_words()}]".strip()
    return typer.Option(*names, help=said, callback=_checked_by(limit), **settings)


def declared_number(declared: Declaration, panel: str) -> Any:
    """Return the option of a parameter that is a number, as that tells of itself."""
    assert declared.limit is not None
    told = declared.means or f"{declared.default:g}"
    help = f"{declared.description} [default: {told}]"
    return number(declared.limit, help=help, rich_help_panel=panel)


def numbers(help: str, /, *, rich_help_panel: str, **limits: Limit) -> Any:
    """Return a typer option for a tuple of numbers, each with a name and limits of its own."""
    return typer.Option(
        metavar=" ".join(limits),
        help=help,
        rich_help_panel=rich_help_panel,
        callback=_checked_by(*limits.values(), parts=tuple(limits)),
    )


def _checked_by(*limits: Limit, parts: tuple[str, ...] = ("",)) -> Callable[[Any], Any]:
    def check(value: Any) -> Any:
        given = value if isinstance(value, list | tuple) else (value,)
        for item, limit, part in zip(given, cycle(limits), cycle(parts), strict=False):
            wrong = "" if item is None else limit.refusal(item)
            if wrong:
                raise typer.BadParameter(f"{part} {wrong}".strip())
        return value

    return check
