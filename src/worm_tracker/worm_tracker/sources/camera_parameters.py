"""All that a camera node may be told."""

from worm_msgs_py.declarations import Declaration
from worm_msgs_py.limits import JPEG_QUALITY, Limit
from worm_tracker.sources.cameras.camera_address import shown_address
from worm_tracker.sources.cameras.camera_settings import (
    CAMERA_RATE,
    EXPOSURE_MS,
    PLACE_IN_PICTURE_PX,
    SIDE_PX,
)
from worm_tracker.sources.cameras.live_record import (
    GOOD_QUALITY,
    SPLIT_MIB,
    SPLIT_MIN,
    RecordAs,
)
from worm_tracker.sources.image_decoder import MAX_MEGAPIXELS, MEGAPIXELS

RECONNECT = Limit(0.0, 86400.0, "s")
SECONDS = Limit(1e-3, 3600.0, "s")

CAMERA_PARAMETERS: tuple[Declaration, ...] = (
    Declaration(
        "camera",
        "",
        "A V4L2 device, an HTTP (MJPEG) or RTSP address, or a video file; ROS shows no "
        "password of it.",
        shown=shown_address,
    ),
    Declaration(
        "topic",
        "",
        "Instead of a camera: the topic of a driver that runs on its own, raw or compressed, "
        "reliable or best effort.",
    ),
    Declaration(
        "max_megapixels",
        MAX_MEGAPIXELS,
        "Larger pictures of a driver are bad ones.",
        MEGAPIXELS,
    ),
    Declaration(
        "record",
        "",
        "Directory into which every picture that is sent is recorded; empty: none. Its replay "
        "gives the same frames with the same stamps, and so the same results.",
    ),
    Declaration(
        "record_as",
        str(RecordAs.ZSTD),
        "How the record is compressed: zstd and png keep every pixel; a replay of jpeg gives "
        "other numbers.",
        choices=tuple(map(str, RecordAs)),
    ),
    Declaration("jpeg_quality", GOOD_QUALITY, "Of a record that is jpeg.", JPEG_QUALITY),
    Declaration(
        "split_mib",
        4096.0,
        "Size at which the record goes on in another file; 0: never.",
        SPLIT_MIB,
    ),
    Declaration(
        "split_min",
        30.0,
        "Time after which the record goes on in another file; 0: never.",
        SPLIT_MIN,
    ),
    Declaration(
        "pictures",
        "",
        "Directory in which some of the pictures are kept, for a report; empty: none.",
    ),
    Declaration(
        "reconnect",
        600.0,
        "Time for which a device or stream that has stopped is opened anew.",
        RECONNECT,
    ),
    Declaration("reconnect_delay", 0.5, "Time before the first attempt.", SECONDS),
    Declaration("stall", 5.0, "Time without a frame: the stream has stopped.", SECONDS),
    Declaration("width_px", 0, "Width that the camera is asked for; 0: its own.", SIDE_PX),
    Declaration("height_px", 0, "Height that it is asked for; 0: its own.", SIDE_PX),
    Declaration("frames_per_s", 0.0, "Rate that it is asked for; 0: its own.", CAMERA_RATE),
    Declaration(
        "exposure_ms",
        0.0,
        "Exposure that it is asked for; 0: by itself. What a camera does not take is told.",
        EXPOSURE_MS,
        changes=True,
    ),
    Declaration("region_u_px", 0, "Left edge of the part that is used.", PLACE_IN_PICTURE_PX),
    Declaration("region_v_px", 0, "Upper edge of it.", PLACE_IN_PICTURE_PX),
    Declaration("region_width_px", 0, "Its width; 0: the whole picture.", SIDE_PX),
    Declaration("region_height_px", 0, "Its height; 0: the whole picture.", SIDE_PX),
)
