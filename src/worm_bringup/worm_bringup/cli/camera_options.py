"""Options of `worm live` about the camera and the record of its pictures."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_bringup.cli.numbers import number
from worm_bringup.graph.node_spec import NodeSpec
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.camera_node import RECONNECT
from worm_tracker.sources.cameras.camera_address import Kind, kind_of, shown_address

_CAMERA = "The camera"
_CAMERAS, _SIMULATED = "worm_tracker.sources.camera_node", "worm_bringup.simulated_camera"
SIMULATED = "sim"
"""The address of the simulated rig."""

CameraAddress = Annotated[
    str | None,
    typer.Option(
        help="A device (/dev/video0 or 0), an http:// (MJPEG) or rtsp:// address, or a video "
        "file, played in real time; `sim` films a simulated worm. An address with a password "
        "is better given as WORM_CAMERA: everybody on this machine can read a command line.",
        envvar="WORM_CAMERA",
        rich_help_panel=_CAMERA,
    ),
]
DriverTopic = Annotated[
    str | None,
    typer.Option(
        help="Instead of a camera, the topic of a driver that runs on its own, such as "
        "/camera/image_raw or /camera/image_raw/compressed.",
        rich_help_panel=_CAMERA,
    ),
]
RecordBag = Annotated[
    Path | None,
    typer.Option(
        help="Bag to record the pictures into, as they go; its replay gives the same results.",
        rich_help_panel=_CAMERA,
    ),
]
ReconnectS = Annotated[
    float,
    number(
        RECONNECT,
        help="Seconds to look for a camera that was lost; then the trial ends, and exit status "
        "1 says so.",
        rich_help_panel=_CAMERA,
    ),
]


@dataclass(frozen=True)
class CameraOptions:
    """What films, and where its pictures are recorded."""

    camera: CameraAddress = None
    topic: DriverTopic = None
    record: RecordBag = None
    reconnect_s: ReconnectS = 600.0

    @property
    def shown(self) -> str:
        """How what films is shown to people."""
        return self.topic or shown_address(self.camera or "")

    @property
    def inputs(self) -> dict[str, Path]:
        """Files that outputs must be apart from: a video that is played as a camera."""
        if self.camera in (None, SIMULATED) or kind_of(self.camera or "") is not Kind.FILE:
            return {}
        return {"--camera": Path(self.camera or "")}

    def source(self, *, private: bool) -> NodeSpec:
        """Return the node that sends the pictures.

        Raises
        ------
        BadInput
            Not one of camera and topic is given, or a topic that could not be heard.
        """
        if (self.camera is None) == (self.topic is None):
            raise BadInput("give either --camera (or WORM_CAMERA) or --topic")
        if self.topic is not None and private:
            raise BadInput("--topic comes from another program: leave out --private")
        if self.topic is not None:
            module, given = _CAMERAS, {"topic": self.topic}
        else:
            module = _SIMULATED if self.camera == SIMULATED else _CAMERAS
            given = {"camera": self.camera or ""}
        return NodeSpec(module, "image_source", given | self._more())

    def _more(self) -> dict[str, Any]:
        more: dict[str, Any] = {"reconnect": self.reconnect_s}
        if self.record is not None:
            more["record"] = str(self.record)
        return more
