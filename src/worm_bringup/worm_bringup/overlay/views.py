"""What a viewer needs beside a frame's results: camera, transforms and annotations."""

from collections.abc import Iterator

from worm_bringup.overlay.frame_join import JoinedFrame
from worm_bringup.overlay.shapes import shapes_of
from worm_bringup.overlay.viewer_messages import (
    camera_to_cdr,
    shapes_to_cdr,
    transforms_to_cdr,
    warm_up,
)
from worm_msgs_py import topics
from worm_msgs_py.contract.camera_view import CAMERA_OVER_RIG, chamber_transforms, pinhole


class FrameViews:
    """Gives `camera_info`, `tf_static`, `tf` and `worm/annotations` of one frame after the other.

    Where the chambers are not known there are no transforms, and where not even the size of the
    pictures is, no camera.
    """

    def __init__(self) -> None:
        self._camera_stands = False
        warm_up()  # before the first frame: it takes 50 ms

    def of(self, frame: JoinedFrame) -> Iterator[tuple[str, bytes]]:
        """Yield topic and serialised message of all that belongs to a frame."""
        stamp_ns, geometry = frame.state.stamp_ns, frame.geometry
        if geometry is not None:
            yield topics.CAMERA_INFO, camera_to_cdr(pinhole(geometry), stamp_ns)
            if geometry.chambers and not self._camera_stands:
                self._camera_stands = True
                yield topics.TF_STATIC, transforms_to_cdr([CAMERA_OVER_RIG], stamp_ns)
            if geometry.chambers:
                yield topics.TF, transforms_to_cdr(chamber_transforms(geometry), stamp_ns)
        shapes = shapes_of(frame.state, frame.midline, geometry)
        yield topics.WORM_ANNOTATIONS, shapes_to_cdr(shapes, stamp_ns)
