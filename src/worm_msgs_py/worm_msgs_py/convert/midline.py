"""Midline as `sensor_msgs/PointCloud2`: x, y, z, s, width in metres, and the picture's u, v.

A cloud costs microseconds where a list of Pose objects costs more than the tracking. Viewers ask
for z, which is 0.
"""

import array
from itertools import count

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2, PointField

from worm_msgs_py.contract.body import BodyState, Midline
from worm_msgs_py.convert.message_checks import strict
from worm_msgs_py.convert.stamp import header

_FIELD_NAMES = ("x", "y", "z", "s", "width", "u_px", "v_px", "s_px", "width_px")
_BYTES = 4
_FLOAT = PointField.FLOAT32
_FIELDS = [
    PointField(name=name, offset=_BYTES * index, datatype=PointField.FLOAT32, count=1)
    for name, index in zip(_FIELD_NAMES, count(), strict=False)
]
_STEP = _BYTES * len(_FIELD_NAMES)


def midline_to_msg(midline: Midline, state: BodyState) -> PointCloud2:
    """Write a midline, head first, in the state's frame; single precision."""
    metres_per_px = state.length_m / state.length_px if state.length_px > 0 else float("nan")
    columns = np.stack(
        [
            midline.x_m,
            midline.y_m,
            np.zeros_like(midline.x_m),
            midline.s_px * metres_per_px,
            midline.width_px * metres_per_px,
            midline.u_px,
            midline.v_px,
            midline.s_px,
            midline.width_px,
        ],
        axis=1,
    ).astype("<f4")
    data = array.array("B")
    data.frombytes(columns.tobytes())
    points = len(columns)
    return PointCloud2(
        header=header(state.stamp_ns, state.frame_id),
        height=1,
        width=points,
        fields=_FIELDS,
        is_bigendian=False,
        point_step=_STEP,
        row_step=_STEP * points,
        data=data,
        is_dense=bool(np.isfinite(columns).all()),
    )


@strict
def midline_from_msg(msg: PointCloud2) -> Midline:
    """Read a midline; KeyError where a field is missing, names that we do not know are ignored."""
    offsets = {field.name: field.offset for field in msg.fields if field.datatype == _FLOAT}
    layout = np.dtype(
        {
            "names": list(_FIELD_NAMES),
            "formats": [">f4" if msg.is_bigendian else "<f4"] * len(_FIELD_NAMES),
            "offsets": [offsets[name] for name in _FIELD_NAMES],
            "itemsize": msg.point_step,
        }
    )
    points = np.frombuffer(bytes(msg.data), layout)

    def column(name: str) -> NDArray[np.float64]:
        return points[name].astype(np.float64)

    return Midline(
        u_px=column("u_px"),
        v_px=column("v_px"),
        x_m=column("x"),
        y_m=column("y"),
        s_px=column("s_px"),
        width_px=column("width_px"),
    )
