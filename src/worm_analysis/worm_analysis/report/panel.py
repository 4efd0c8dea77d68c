"""One panel of the report: a figure with what it takes to read it, or why there is none."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from worm_analysis.wording import items_in_words

WIDE_IN = 4.0
"""Figures from this width on have a row of the page to themselves."""
WITH_TABLE = ("fig-model",)
THIN_SPACE = "\u2009"


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """A figure of the report.

    Attributes
    ----------
    key : str
        Its anchor in the page, such as ``fig-1d``.
    title : str
        What it shows.
    paper : str
        The paper's figure that it corresponds to; empty where there is none.
    n : str
        The number of items that it rests on, and which.
    reading : str
        How to read it: definitions, units, signs. HTML.
    figure : matplotlib.figure.Figure or None
        None where there is not enough data.
    why : str
        Why there is no figure.
    wrong : tuple of str
        What does not fit, in a law that is drawn or beside the paper. HTML.
    alt : str
        The figure in words.
    label : str
        A short name for the table of contents, where it is none of the paper's figures.
    tables : mapping of str to mapping
        What is drawn, as columns; the tables' names come after the panel's key.
    """

    key: str
    title: str
    paper: str
    n: str
    reading: str
    figure: Any = None
    why: str = ""
    wrong: tuple[str, ...] = ()
    alt: str = ""
    label: str = ""
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def is_column(self) -> bool:
        """Whether it stands beside another: it has a narrow figure and no table below."""
        return (
            self.figure is not None
            and self.figure.get_figwidth() < WIDE_IN
            and self.key not in WITH_TABLE
        )

    @property
    def name(self) -> str:
        """What the table of contents calls it."""
        return self.paper or self.label or self.title


def counted(number: int, items: str) -> str:
    """Write ``n = 18 000 frames`` with thin spaces between thousands."""
    return f"n\u00a0=\u00a0{number_of(number, items)}"


def number_of(number: int, items: str) -> str:
    """Write ``18 000 frames``, or ``1 frame``; items are named in the plural."""
    return f"{thousands(number)} {items_in_words(number, items)}"


def thousands(number: int) -> str:
    """Write a whole number with thin spaces between thousands."""
    return f"{number:,}".replace(",", THIN_SPACE)
