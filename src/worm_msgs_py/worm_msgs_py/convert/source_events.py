"""What happened to a source as `diagnostic_msgs/DiagnosticArray`, one status an event."""

from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticArray

from worm_msgs_py.contract.source_events import SourceEvent
from worm_msgs_py.convert.diagnostics import record_to_status, status_to_record
from worm_msgs_py.convert.message_checks import strict
from worm_msgs_py.convert.stamp import header


def source_events_to_msg(events: Sequence[SourceEvent], stamp_ns: int) -> DiagnosticArray:
    """Write events that were noticed at this stamp."""
    return DiagnosticArray(
        header=header(stamp_ns, ""),
        status=[record_to_status(event.kind, event.why, event) for event in events],
    )


@strict
def source_events_from_msg(msg: DiagnosticArray) -> tuple[SourceEvent, ...]:
    """Read events; KeyError where a field is missing, ValueError where one is bad."""
    return tuple(status_to_record(status, SourceEvent) for status in msg.status)
