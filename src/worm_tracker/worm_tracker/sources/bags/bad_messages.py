"""Puts bad pictures that follow each other for one reason into one event, and counts them all."""

from worm_msgs_py.contract.source_events import SourceEvent, SourceEventKind

MOST_EVENTS = 100
"""Events that are listed one by one; the rest is told as one."""


class BadMessages:
    """Collects bad pictures; each method returns the events that are complete by now."""

    def __init__(self) -> None:
        self._run: SourceEvent | None = None
        self._told = 0
        self._rest: SourceEvent | None = None

    def bad(self, frame: int, stamp_ns: int, why: str) -> list[SourceEvent]:
        """Take note of a bad picture."""
        run = self._run
        if run is not None and run.why == why and run.frame + run.count == frame:
            self._run = _more(run, 1)
            return []
        ended = self.good()
        self._run = SourceEvent(SourceEventKind.BAD_MESSAGE, frame, stamp_ns, why, count=1)
        return ended

    def good(self) -> list[SourceEvent]:
        """Take note of a good picture."""
        run, self._run = self._run, None
        if run is None:
            return []
        if self._told < MOST_EVENTS:
            self._told += 1
            return [run]
        if self._rest is None:
            why = f"more than {MOST_EVENTS} bad messages; of this and later ones: {run.why}"
            self._rest = SourceEvent(run.kind, run.frame, run.stamp_ns, why, count=run.count)
        else:
            self._rest = _more(self._rest, run.count)
        return []

    def end(self) -> list[SourceEvent]:
        """Return what has not been told yet; nothing comes any more."""
        events = self.good()
        rest, self._rest = self._rest, None
        return events if rest is None else [*events, rest]


def _more(event: SourceEvent, count: int) -> SourceEvent:
    return SourceEvent(
        event.kind, event.frame, event.stamp_ns, event.why, count=event.count + count
    )
