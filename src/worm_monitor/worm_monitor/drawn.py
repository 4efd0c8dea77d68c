"""What the page draws over a picture, as JSON: the rig, and where the body is."""

from collections.abc import Iterable
from typing import Any

from worm_monitor.json_numbers import rounded, rounded_all
from worm_msgs_py import BodyState, Chamber
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.units import MM_PER_M


def drawn_chambers(chambers: Iterable[Chamber]) -> list[dict[str, Any]]:
    """Return circles and exits."""
    return [
        {
            "name": chamber.name,
            "u": rounded(chamber.centre_u_px, 6),
            "v": rounded(chamber.centre_v_px, 6),
            "radius_px": rounded(chamber.radius_px, 6),
            "exit_rad": rounded(chamber.exit_rad),
            "R_mm": rounded(chamber.radius_m * MM_PER_M),
            "W_mm": rounded(chamber.exit_width_m * MM_PER_M, 3),
            "px_per_mm": rounded(chamber.px_per_m / MM_PER_M, 4),
        }
        for chamber in chambers
    ]


def drawn_pose(state: BodyState) -> dict[str, Any]:
    """Return head, centroid and tail, and what decides how they look."""
    points = {
        name: rounded_all((point.u_px, point.v_px))
        for name, point in (
            ("head", state.head),
            ("centroid", state.centroid),
            ("tail", state.tail),
        )
    }
    return {
        **points,
        "frame": state.frame,
        "status": state.status.label,
        "sure": state.head_certainty >= SURE_HEAD_CERTAINTY,
        "width_px": rounded(state.width_px, 3),
        "length_px": rounded(state.length_px, 4),
    }
