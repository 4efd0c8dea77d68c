"""The terminal that the commands print to: what others wrote is shown, and never acts on it."""

from typing import Any

import typer
from rich.console import Console
from rich.text import Text

from worm_msgs_py.text import printable


class Terminal(Console):
    """A rich console for which text is text: no markup, no emoji codes, no control characters.

    Names of bags, topics and quantities come from files of others; `[/x]` is a good name for a
    directory.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(markup=False, emoji=False, **settings)

    def render_str(self, text: str, **settings: Any) -> Text:
        """Return text as rich shows it, its lines made printable; tables ask for their cells."""
        return super().render_str(_lines(text), **settings)


def say(text: object) -> None:
    """Print lines on standard output, as they are for the rest."""
    typer.echo(_lines(str(text)))


def _lines(text: str) -> str:
    return "\n".join(map(printable, text.split("\n")))
