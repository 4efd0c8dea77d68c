"""What a lab notes of a trial, which no picture shows; it goes into the summary as it is."""

from dataclasses import asdict, dataclass
from datetime import date as calendar_date
from math import nan
from typing import Any

from worm_msgs_py.declarations import declare
from worm_msgs_py.limits import Limit


def _no_date(text: str) -> str:
    """Return what is wrong with a date."""
    try:
        calendar_date.fromisoformat(text or "2000-01-01")
    except ValueError:
        return f"is {text!r}: give year, month and day, such as 2026-03-21"
    return ""


@dataclass(frozen=True, slots=True)
class TrialMetadata:
    """Names and circumstances of a trial; no number rests on them, so they may change."""

    trial: str = declare("", "What the trial is called.", changes=True)
    animal: str = declare("", "Which animal it is: species, clone, number.", changes=True)
    date: str = declare("", "Day of the trial, as in 2026-03-21.", check=_no_date, changes=True)
    temperature_c: float = declare(
        nan,
        "Temperature of the water.",
        Limit(-5.0, 60.0, "°C"),
        or_else=nan,
        means="not known",
        changes=True,
    )
    operator: str = declare("", "Who made it.", changes=True)
    notes: str = declare("", "Anything else.", changes=True)

    def given(self) -> dict[str, Any]:
        """Return what is known, for the summary."""
        return {k: v for k, v in asdict(self).items() if v not in ("", None) and v == v}
