"""Real bags of small pictures that tell their number, for the tests of sources and graph."""

import cv2
import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

TYPESTORE = get_typestore(Stores.ROS2_JAZZY)
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 50_000_000


def numbered_picture(number, shape=(48, 64)):
    """A picture that no other number has: its number in the first pixels, noise elsewhere."""
    picture = np.random.default_rng(number).integers(0, 256, shape, np.uint8)
    picture[0, :4] = np.frombuffer(np.uint32(number).tobytes(), np.uint8)
    return picture


def number_of(picture):
    return int(np.ascontiguousarray(picture[0, :4]).view(np.uint32)[0])


def header(stamp_ns, frame_id="camera_optical_frame"):
    types = TYPESTORE.types
    stamp = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame_id)


def image(picture, stamp_ns, encoding="mono8"):
    return TYPESTORE.types[IMAGE](
        header=header(stamp_ns),
        height=picture.shape[0],
        width=picture.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=picture.strides[0],
        data=np.frombuffer(picture.tobytes(), np.uint8),
    )


def compressed(picture, stamp_ns, kind="png"):
    done, data = cv2.imencode("." + kind, picture)
    assert done
    return TYPESTORE.types[COMPRESSED](header=header(stamp_ns), format=kind, data=data.ravel())


def serialised(message):
    return bytes(TYPESTORE.serialize_cdr(message, message.__msgtype__))


def stamps(count, start_ns=START_NS, period_ns=PERIOD_NS):
    return [start_ns + i * period_ns for i in range(count)]


def write_messages(path, messages, storage=StoragePlugin.MCAP, compression=None):
    """Write (topic, time of recording, message) as a rosbag2 directory; return the path."""
    writer = Writer(path, version=9, storage_plugin=storage)
    if compression:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, log_ns, message in messages:
            kind = message if isinstance(message, str) else message.__msgtype__
            if (topic, kind) not in connections:
                connections[topic, kind] = writer.add_connection(topic, kind, typestore=TYPESTORE)
            if not isinstance(message, str):
                writer.write(connections[topic, kind], log_ns, serialised(message))
    return path


def write_bag(path, count=20, *, topic="/image_raw", make=image, shape=(48, 64), **kwargs):
    """Write `count` numbered pictures, 20 a second."""
    return write_messages(
        path,
        [(topic, t, make(numbered_picture(i, shape), t)) for i, t in enumerate(stamps(count))],
        **kwargs,
    )


def storage_file(bag):
    """Return the one storage file in a rosbag2 directory."""
    (file,) = [file for file in bag.iterdir() if file.suffix in (".mcap", ".db3")]
    return file
