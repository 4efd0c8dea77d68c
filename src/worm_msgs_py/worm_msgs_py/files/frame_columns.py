"""The columns of tables with a row a frame: what was tracked and what is true go by one name."""

import pyarrow as pa

from worm_msgs_py.contract.frames import Where
from worm_msgs_py.contract.status import Status
from worm_msgs_py.files.table_schema import NO_UNIT, PLAIN, column

_POINTS = {
    "head": ("The head tip", "along the midline's first tenth, outward"),
    "centroid": ("The centroid of the body's area", "from the centroid to the head"),
    "tail": ("The tail tip", "along the midline's last tenth, towards the head"),
}
_RIGHT = "to the right from the centre of the picture's first pixel"
_DOWN = "downwards from the centre of the picture's first pixel"

_COLUMNS = {
    "stamp_ns": ("ns", "Time of capture, by the clock of the bag or the camera."),
    "frame": (PLAIN, "Number of the frame, from 0."),
    "where": (
        NO_UNIT,
        f"Part of the rig that holds the head: {', '.join(each.label for each in Where)}.",
    ),
    "chamber": (NO_UNIT, "The chamber in whose frame the coordinates in mm are."),
    "status": (
        NO_UNIT,
        f"What came of the frame: {', '.join(each.label for each in Status)}; see statuses.md.",
    ),
    "confidence": (PLAIN, "0 to 1: how well the body explains the picture."),
    "head_certainty": (
        PLAIN,
        "0.5 (a coin's toss) to 1: how sure it is that head and tail are not exchanged.",
    ),
    "head_sd_mm": (
        "mm",
        "How far the head tip may be, along the body, from where it is given: a standard "
        "deviation; 0 where its outline shows it. A head on the body is known less well.",
    ),
    "midline_u_px": ("px", f"The midline from head to tail, {_RIGHT}."),
    "midline_v_px": ("px", f"The same points, {_DOWN}."),
    "midline_width_px": ("px", "The body's width across the midline at these points."),
    "length_mm": ("mm", "Length along the midline from tip to tip."),
    "width_mm": ("mm", "Mean width of the body's middle part, d_w."),
    "length_px": ("px", "Length along the midline from tip to tip."),
    "width_px": ("px", "Mean width of the body's middle part."),
    "r_h_mm": ("mm", "r_h, distance of the head tip from the chamber's centre."),
    "r_c_mm": ("mm", "r_c, distance of the centroid from the chamber's centre."),
    "r_t_mm": ("mm", "r_t, distance of the tail tip from the chamber's centre."),
    "theta_h_rad": (
        "rad",
        "θ_h, polar angle of the head, counter-clockwise from the exit's middle as seen in the "
        "picture; unwrapped in time since the chamber was entered.",
    ),
    "psi_b_deg": (
        "deg",
        "ψ_b, angle from the outward normal at the head to the body (head − centroid), "
        "counter-clockwise positive.",
    ),
    "psi_h_deg": ("deg", "ψ_h, the same with the head's own direction."),
    "theta_dot_rad_s": ("rad/s", "Δθ_h/Δt over the last Δt = 1 s."),
    "v_b_mm_s": ("mm/s", "v_b = R·θ̇_h, speed along the wall, counter-clockwise positive."),
    "contact": (
        NO_UNIT,
        "Whether R − r_h < 0.3·d_w, the head's radius taken without noise where it was measured; "
        "null where it cannot be told: no head, no wall, in the passage, or a head on the body "
        "whose place (`head_sd_mm`) is not known well enough.",
    ),
    "circle_u_px": ("px", f"Centre of the chamber's wall, {_RIGHT}."),
    "circle_v_px": ("px", f"Centre of the chamber's wall, {_DOWN}."),
    "circle_radius_px": ("px", "Radius of the chamber's wall in the picture."),
    "exit_deg": (
        "deg",
        "Direction of the exit's middle, counter-clockwise from the picture's right.",
    ),
}
for _name, (_what, _heading) in _POINTS.items():
    _COLUMNS |= {
        f"{_name}_u_px": ("px", f"{_what}, {_RIGHT}."),
        f"{_name}_v_px": ("px", f"{_what}, {_DOWN}."),
        f"{_name}_x_mm": (
            "mm",
            f"{_what}, from the chamber's centre towards the middle of its exit.",
        ),
        f"{_name}_y_mm": (
            "mm",
            f"{_what}, across that, counter-clockwise from x as seen in the picture.",
        ),
        f"{_name}_yaw_deg": ("deg", f"Heading, counter-clockwise from x: {_heading}."),
    }


def frame_column(name: str, kind: pa.DataType) -> pa.Field:
    """Return a column of a table with a row a frame; KeyError where it is not described here."""
    return column(name, kind, *_COLUMNS[name])
