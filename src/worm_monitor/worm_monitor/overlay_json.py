"""What the page draws over a picture, as JSON: the rig, and where the body is."""

from collections.abc import Iterable, Mapping
from typing import Any

from worm_monitor.json_numbers import rounded, rounded_all
from worm_msgs_py import Chamber
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


def drawn_pose(
    frame: int,
    status: str,
    certainty: float,
    points: Mapping[str, tuple[float, float]],
    size_px: tuple[float, float],
) -> dict[str, Any]:
    """Return where head, centroid and tail are, and what decides how they look.

    Parameters
    ----------
    status : str
        Its label.
    certainty : float
        That head and tail are not exchanged.
    points : mapping of name to (u, v)
    size_px : (float, float)
        Width and length of the body.
    """
    return {
        **{name: rounded_all(point) for name, point in points.items()},
        "frame": frame,
        "status": status,
        "sure": certainty >= SURE_HEAD_CERTAINTY,
        "width_px": rounded(size_px[0], 3),
        "length_px": rounded(size_px[1], 4),
    }
