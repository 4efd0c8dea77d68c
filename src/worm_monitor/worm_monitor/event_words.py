"""What the analysis says of an event, in a line for people."""

from math import isfinite

from worm_msgs_py import Attempt, Episode, Event, Visit
from worm_msgs_py.contract.episodes import EpisodeKind
from worm_msgs_py.units import MM_PER_M, NS_PER_S

_EPISODES = {EpisodeKind.CONTACT: "contact", EpisodeKind.FREE: "excursion"}


def event_in_words(event: Event) -> tuple[str, str]:
    """Return an event's kind, and a line on it."""
    seconds = (event.end_ns - event.start_ns) / NS_PER_S
    if isinstance(event, Episode):
        kind = _EPISODES[event.kind]
        text = f"{event.distance_m * MM_PER_M:.2f} mm along the wall in {seconds:.1f} s"
        if isfinite(event.delta_r_m):
            text += f", up to {event.delta_r_m * MM_PER_M:.2f} mm from it"
    elif isinstance(event, Visit):
        kind = "visit"
        skips = f"{event.skips} skip{'' if event.skips == 1 else 's'}"
        found = f"exit found after {event.tau_h_s:.1f} s" if isfinite(event.tau_h_s) else "no exit"
        text = f"{found}, {skips}"
    else:
        assert isinstance(event, Attempt)
        kind = "escape" if event.success else "attempt"
        text = f"{event.penetration_m * MM_PER_M:.2f} mm into the passage in {seconds:.1f} s"
    cut = "" if event.complete else " (cut short)"
    return kind, f"{text}{cut}, {event.chamber.replace('_', ' ')}"
