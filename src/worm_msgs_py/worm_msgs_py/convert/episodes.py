"""Events as `diagnostic_msgs/DiagnosticArray`, one status an event, named by its kind."""

from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticArray

from worm_msgs_py.contract.episodes import Attempt, Episode, EpisodeKind, Event, Visit
from worm_msgs_py.convert.diagnostics import record_to_status, status_to_record
from worm_msgs_py.convert.message_checks import strict
from worm_msgs_py.convert.stamp import header
from worm_msgs_py.units import MM_PER_M

_TYPE_OF_NAME: dict[str, type[Event]] = {"episode": Episode, "visit": Visit, "attempt": Attempt}
_NAME_OF_TYPE = {kind: name for name, kind in _TYPE_OF_NAME.items()}


def events_to_msg(events: Sequence[Event], stamp_ns: int) -> DiagnosticArray:
    """Write events that closed at the frame of this stamp."""
    return DiagnosticArray(
        header=header(stamp_ns, ""),
        status=[
            record_to_status(_NAME_OF_TYPE[type(event)], _describe(event), event, event.chamber)
            for event in events
        ],
    )


@strict
def events_from_msg(msg: DiagnosticArray) -> tuple[Event, ...]:
    """Read events; KeyError where a status is not of a kind that we know."""
    return tuple(status_to_record(status, _TYPE_OF_NAME[status.name]) for status in msg.status)


def _describe(event: Event) -> str:
    if isinstance(event, Episode):
        kind = "contact" if event.kind is EpisodeKind.CONTACT else "out of contact"
        text = f"{kind} over {event.distance_m * MM_PER_M:.2f} mm"
    elif isinstance(event, Visit):
        text = f"visit, exit found after {event.tau_h_s:.1f} s, {event.skips} skips"
    else:
        outcome = "escape" if event.success else "withdrawal"
        text = f"{outcome} after {event.penetration_m * MM_PER_M:.2f} mm in the passage"
    return text if event.complete else text + " (cut short)"
