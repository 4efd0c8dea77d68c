"""The pinhole camera as `sensor_msgs/CameraInfo`."""

import struct
from functools import lru_cache

from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo

from worm_msgs_py.contract.camera_view import Pinhole
from worm_msgs_py.contract.frames import CAMERA
from worm_msgs_py.convert.stamp import header
from worm_msgs_py.units import NS_PER_S

_STAMP = slice(4, 12)
"""Where a serialised message that begins with a header has its stamp."""


def camera_info_to_msg(camera: Pinhole, stamp_ns: int) -> CameraInfo:
    """Write a camera; where nothing is calibrated K is all 0, as the message's definition asks."""
    focal, u, v = (
        (float(camera.focal_px), float(camera.centre_u_px), float(camera.centre_v_px))
        if camera.focal_px
        else (0.0, 0.0, 0.0)
    )
    one = 1.0 if camera.focal_px else 0.0
    return CameraInfo(
        header=header(stamp_ns, CAMERA),
        height=int(camera.height_px),
        width=int(camera.width_px),
        distortion_model="plumb_bob",
        d=[0.0] * 5,
        k=[focal, 0.0, u, 0.0, focal, v, 0.0, 0.0, one],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[focal, 0.0, u, 0.0, 0.0, focal, v, 0.0, 0.0, 0.0, one, 0.0],
    )


def camera_info_to_cdr(camera: Pinhole, stamp_ns: int) -> bytes:
    """Serialise a camera; all but the stamp is kept from one frame to the next."""
    template = _without_stamp(camera)
    stamp = struct.pack("<iI", *divmod(stamp_ns, NS_PER_S))
    return template[: _STAMP.start] + stamp + template[_STAMP.stop :]


@lru_cache(maxsize=4)
def _without_stamp(camera: Pinhole) -> bytes:
    return bytes(serialize_message(camera_info_to_msg(camera, 0)))
