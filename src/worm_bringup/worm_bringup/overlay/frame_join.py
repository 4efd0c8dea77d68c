"""Puts state, midline and geometry of each frame together, which come in any order."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace

from worm_msgs_py import BodyState, Geometry, Midline


@dataclass(frozen=True, eq=False, slots=True)
class JoinedFrame:
    """All that is drawn of a frame.

    Attributes
    ----------
    state : BodyState
    midline : Midline
    geometry : Geometry or None
        The rig in it. Before it was found, and in pictures without one, it has no chambers; None
        where not even the size of the pictures is known.
    """

    state: BodyState
    midline: Midline
    geometry: Geometry | None


class FrameJoin:
    """Takes three topics, each in its own order, and gives whole frames.

    Frames wait until the first geometry is known, or the stream is over; so what is given depends
    on the frames alone. One that names no geometry (a bad picture) has that of the frame before.
    """

    def __init__(self) -> None:
        self._states: deque[BodyState] = deque()
        self._midlines: deque[Midline] = deque()
        self._geometries: dict[int, Geometry] = {}
        self._version = 0

    def add_state(self, state: BodyState) -> Iterator[JoinedFrame]:
        """Take the next frame's state; give the frames that are whole now."""
        self._states.append(state)
        return self._whole()

    def add_midline(self, midline: Midline) -> Iterator[JoinedFrame]:
        """Take the next frame's midline; give the frames that are whole now."""
        self._midlines.append(midline)
        return self._whole()

    def add_geometry(self, geometry: Geometry) -> Iterator[JoinedFrame]:
        """Take a version of the geometry; give the frames that are whole now."""
        self._geometries[geometry.version] = geometry
        return self._whole()

    def finish(self) -> Iterator[JoinedFrame]:
        """Give the frames for which no geometry has come."""
        while self._states and self._midlines:
            yield self._next()

    def _whole(self) -> Iterator[JoinedFrame]:
        while self._states and self._midlines and self._geometries:
            version = self._states[0].geometry
            if version and version not in self._geometries:
                return
            yield self._next()

    def _next(self) -> JoinedFrame:
        state, midline = self._states.popleft(), self._midlines.popleft()
        self._version = state.geometry or self._version
        geometry = self._geometries.get(self._version)
        if geometry is None and self._geometries:
            geometry = replace(next(iter(self._geometries.values())), chambers=())
        return JoinedFrame(state, midline, geometry)
