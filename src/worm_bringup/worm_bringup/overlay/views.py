"""What a viewer needs of each frame, put together from topics that come in any order."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace

from worm_bringup.overlay.shapes import shapes_of
from worm_bringup.overlay.viewer_messages import shapes_to_cdr, transforms_to_cdr
from worm_msgs_py import BodyState, Geometry, Midline, convert, topics
from worm_msgs_py.contract.camera_view import CAMERA_OVER_RIG, chamber_transforms, pinhole

Write = Callable[[str, int, bytes], None]
"""Takes a topic, the stamp of the frame, and a serialised message."""


class FrameViews:
    """Gives `camera_info`, `tf_static`, `tf` and `worm/annotations` of every frame, in order.

    State and midline of a frame and the geometry that it rests on come on three topics. Frames wait
    until the first geometry is known, or the stream is over; so what is written depends on the
    frames alone. One that names no geometry (a bad picture) has that of the frame before.

    Parameters
    ----------
    write : callable
        Takes each message.
    begin : callable, optional
        Told the stamp of each frame before its messages are written.
    """

    def __init__(self, write: Write, begin: Callable[[int], None] | None = None) -> None:
        self._write = write
        self._begin = begin
        self._states: deque[BodyState] = deque()
        self._midlines: deque[Midline] = deque()
        self._geometries: dict[int, Geometry] = {}
        self._version = 0
        self._camera_stands = False

    def add_state(self, state: BodyState) -> None:
        """Take the next frame's state."""
        self._states.append(state)
        self._write_known()

    def add_midline(self, midline: Midline) -> None:
        """Take the next frame's midline."""
        self._midlines.append(midline)
        self._write_known()

    def add_geometry(self, geometry: Geometry) -> None:
        """Take a version of the geometry."""
        self._geometries[geometry.version] = geometry
        self._write_known()

    def finish(self) -> None:
        """Write the frames for which no geometry has come."""
        while self._states and self._midlines:
            self._write_frame(self._states.popleft(), self._midlines.popleft())

    def _write_known(self) -> None:
        while self._states and self._midlines and self._geometries:
            version = self._states[0].geometry
            if version and version not in self._geometries:
                return
            self._write_frame(self._states.popleft(), self._midlines.popleft())

    def _write_frame(self, state: BodyState, midline: Midline) -> None:
        if self._begin is not None:
            self._begin(state.stamp_ns)
        self._version = state.geometry or self._version
        geometry = self._geometries.get(self._version)
        if geometry is not None and geometry.chambers:
            if not self._camera_stands:
                self._camera_stands = True
                self._put(
                    topics.TF_STATIC, state, transforms_to_cdr([CAMERA_OVER_RIG], state.stamp_ns)
                )
            places = chamber_transforms(geometry)
            self._put(topics.TF, state, transforms_to_cdr(places, state.stamp_ns))
        self._write_camera(state, geometry)
        shapes = shapes_of(state, midline, geometry)
        self._put(topics.WORM_ANNOTATIONS, state, shapes_to_cdr(shapes, state.stamp_ns))

    def _write_camera(self, state: BodyState, geometry: Geometry | None) -> None:
        """Write the camera; of pictures before the rig is found the size alone is known."""
        if geometry is None and self._geometries:
            geometry = replace(next(iter(self._geometries.values())), chambers=())
        if geometry is not None:
            camera = convert.camera_info_to_cdr(pinhole(geometry), state.stamp_ns)
            self._put(topics.CAMERA_INFO, state, camera)

    def _put(self, topic: str, state: BodyState, data: bytes) -> None:
        self._write(topic, state.stamp_ns, data)
