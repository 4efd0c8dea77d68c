"""Options of `worm live` about the camera and the record of its pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from worm_bringup.cli.number_options import declared_number, number, numbers
from worm_bringup.cli.usage_errors import refuse_without
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.graph.nodes import parameters_of
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.camera_parameters import CAMERA_PARAMETERS, RECONNECT
from worm_tracker.sources.cameras.camera_address import Kind, kind_of, shown_address
from worm_tracker.sources.cameras.camera_settings import (
    CAMERA_RATE,
    EXPOSURE_MS,
    PLACE_IN_PICTURE_PX,
    SIDE_PX,
)
from worm_tracker.sources.cameras.live_record import GOOD_QUALITY, RecordAs

_CAMERA, _RECORD = "The camera", "The record of the pictures"
_CAMERAS, _SIMULATED = "worm_tracker.sources.camera_node", "worm_bringup.simulated_camera"
_REGION = tuple(f"region_{part}_px" for part in ("u", "v", "width", "height"))
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
SizePx = Annotated[
    tuple[int, int] | None,
    numbers(
        "Size that the camera is asked for. What it does not take is told, and stands in the "
        "results.",
        rich_help_panel=_CAMERA,
        W=SIDE_PX,
        H=SIDE_PX,
    ),
]
FramesPerS = Annotated[
    float | None,
    number(
        CAMERA_RATE, "--fps", help="Rate that the camera is asked for.", rich_help_panel=_CAMERA
    ),
]
ExposureMs = Annotated[
    float | None,
    number(EXPOSURE_MS, help="Exposure that it is asked for.", rich_help_panel=_CAMERA),
]
RegionPx = Annotated[
    tuple[int, int, int, int] | None,
    numbers(
        "The part of each picture that is used, from whichever source: left and upper edge, width "
        "and height.",
        rich_help_panel=_CAMERA,
        U=PLACE_IN_PICTURE_PX,
        V=PLACE_IN_PICTURE_PX,
        W=SIDE_PX,
        H=SIDE_PX,
    ),
]
RecordBag = Annotated[
    Path | None,
    typer.Option(
        help="Bag to record the pictures into, as they go; its replay gives the same results.",
        rich_help_panel=_RECORD,
    ),
]
RecordedAs = Annotated[
    RecordAs | None,
    typer.Option(
        help="How the record is compressed. zstd, where not given, and png keep every pixel; a "
        "replay of jpeg gives other numbers, and the results say so.",
        rich_help_panel=_RECORD,
    ),
]
_OF_CAMERA = {declared.name: declared for declared in CAMERA_PARAMETERS}
JpegQuality = Annotated[int | None, declared_number(_OF_CAMERA["jpeg_quality"], _RECORD)]
SplitMib = Annotated[float | None, declared_number(_OF_CAMERA["split_mib"], _RECORD)]
SplitMin = Annotated[float | None, declared_number(_OF_CAMERA["split_min"], _RECORD)]
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
    size_px: SizePx = None
    fps: FramesPerS = None
    exposure_ms: ExposureMs = None
    region_px: RegionPx = None
    record: RecordBag = None
    record_as: RecordedAs = None
    jpeg_quality: JpegQuality = None
    split_mib: SplitMib = None
    split_min: SplitMin = None
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
        """Return the parameters that options give."""
        about_the_record = ("record_as", "jpeg_quality", "split_mib", "split_min")
        for name in about_the_record:
            refuse_without(vars(self), name, "record", "is about the record")
        size, region = self.size_px or (None,) * 2, self.region_px or (None,) * 4
        given: dict[str, Any] = {
            **dict(zip(("width_px", "height_px"), size, strict=True)),
            "frames_per_s": self.fps,
            "exposure_ms": self.exposure_ms,
            **dict(zip(_REGION, region, strict=True)),
            "reconnect": self.reconnect_s,
            "record": None if self.record is None else str(self.record),
            **{name: vars(self)[name] for name in about_the_record},
            "record_as": None if self.record_as is None else str(self.record_as),
        }
        return {name: value for name, value in given.items() if value is not None}

    def origin(self, source: NodeSpec) -> dict[str, str]:
        """Return where the pictures come from, for the results, and that a record is another."""
        told = source.parameters
        origin = {"camera" if self.topic is None else "topic": self.shown}
        if told.get(_REGION[2]):
            origin["region_px"] = " ".join(str(told.get(name, 0)) for name in _REGION)
        if told.get("record") and told.get("record_as") == RecordAs.JPEG:
            quality = told.get("jpeg_quality", GOOD_QUALITY)
            origin["record"] = f"jpeg of quality {quality}: its replay gives other numbers"
        return origin
