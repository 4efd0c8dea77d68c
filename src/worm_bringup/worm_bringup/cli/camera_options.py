"""Options of `worm live` about the camera and the record of its pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_bringup.cli.numbers import number
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.nodes import parameters_of
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
    float | None,
    number(
        RECONNECT,
        help="Seconds to look for a camera that was lost; then the trial ends, and exit status "
        "1 says so; 600 where not given.",
        rich_help_panel=_CAMERA,
    ),
]


@dataclass(frozen=True)
class CameraOptions:
    """What films, and where its pictures are recorded."""

    camera: CameraAddress = None
    topic: DriverTopic = None
    record: RecordBag = None
    reconnect_s: ReconnectS = None

    def over(self, told: Mapping[str, Any]) -> "CameraOptions":
        """Return these options, with what a rig file says where they say nothing."""
        film = (self.camera, self.topic)
        if film == (None, None):
            film = (told.get("camera"), told.get("topic"))
        record = self.record or (Path(told["record"]) if told.get("record") else None)
        return replace(self, camera=film[0], topic=film[1], record=record)

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

    def source(self, told: Mapping[str, Any], *, private: bool) -> NodeSpec:
        """Return the node that sends the pictures, told by a rig file what no option says.

        Raises
        ------
        BadInput
            Not one of camera and topic is given, or a topic that could not be heard.
        """
        if (self.camera is None) == (self.topic is None):
            raise BadInput(
                "give either --camera (or WORM_CAMERA) or --topic, or a rig file that has one"
            )
        if self.topic is not None and private:
            raise BadInput("--topic comes from another program: leave out --private")
        if self.topic is not None:
            module, given = _CAMERAS, {"topic": self.topic}
        else:
            module = _SIMULATED if self.camera == SIMULATED else _CAMERAS
            given = {"camera": self.camera or ""}
        simulated = self.camera == SIMULATED
        known = {one.name for one in parameters_of("simulated_camera" if simulated else "camera")}
        own = {k: v for k, v in told.items() if k in known - {"camera", "topic"}}
        return NodeSpec(module, "image_source", own | given | self._more())

    def _more(self) -> dict[str, Any]:
        more: dict[str, Any] = {}
        if self.reconnect_s is not None:
            more["reconnect"] = self.reconnect_s
        if self.record is not None:
            more["record"] = str(self.record)
        return more
