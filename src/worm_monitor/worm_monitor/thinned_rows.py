"""Rows by time in bounded memory: the whole trial is always there, as it grows more coarsely."""

from worm_monitor.json_numbers import JsonRow

MOST_ROWS = 12_000
"""Twenty minutes at ten rows a second; more than a plot has pixels, and 0.7 MB as JSON."""
SPACING_S = 0.1
_ROUNDING_S = 1e-6
"""Times are given in whole microseconds: a row that is due must not wait for the next one."""


class ThinnedRows:
    """Rows at least `spacing_s` apart; where there are too many, every second one is dropped.

    Attributes
    ----------
    rows : list of JsonRow
        Their first number is the time, seconds, ascending.
    spacing_s : float
        Doubles each time that rows are dropped.
    """

    def __init__(self, most: int = MOST_ROWS, spacing_s: float = SPACING_S) -> None:
        self.rows: list[JsonRow] = []
        self.spacing_s = spacing_s
        self._most = most
        self._told = 0
        self._begins_anew = True

    def is_due(self, time_s: float) -> bool:
        """Tell whether a row of this time would be kept."""
        last_s = self.rows[-1][0] if self.rows else None
        return last_s is None or time_s - last_s >= self.spacing_s - _ROUNDING_S

    def add(self, row: JsonRow) -> None:
        """Keep a row if it is due."""
        if row[0] is None or not self.is_due(row[0]):
            return
        self.rows.append(row)
        if len(self.rows) > self._most:
            self.rows = self.rows[::2]
            self.spacing_s *= 2
            self._begins_anew = True

    def news(self) -> tuple[bool, list[JsonRow]]:
        """Return the rows since the last time; True first where they replace all earlier ones."""
        anew = self._begins_anew
        rows = self.rows if anew else self.rows[self._told :]
        self._begins_anew = False
        self._told = len(self.rows)
        return anew, list(rows)
