"""The results' own bag: every result topic as it was sent, and what is laid over the picture."""

import shutil
from contextlib import suppress
from pathlib import Path

from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from worm_bringup.overlay.viewer_messages import TYPE_OF_TOPIC, TYPES
from worm_bringup.recorder.copied_pictures import CopiedPictures
from worm_msgs_py import topics
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import LATCHED, RESULT

_FOREVER = QosTime(sec=2147483647, nsec=4294967295)


class ResultBag:
    """A rosbag2 directory that takes serialised messages.

    Its topics are `interfaces.RESULTS`, those of `viewer_messages`, and the pictures' where there
    are any.

    Parameters
    ----------
    path : Path
    pictures : CopiedPictures, optional
    """

    def __init__(self, path: Path, pictures: CopiedPictures | None = None):
        self._path = path
        self._is_open = True
        self._writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.open()
        kinds = {topic: (_type_name(kind), qos) for topic, (kind, qos) in RESULTS.items()}
        for topic, kind in TYPE_OF_TOPIC.items():
            kinds[topic] = (kind, LATCHED if topic == topics.TF_STATIC else RESULT)
        if pictures is not None:
            kinds[pictures.topic] = (pictures.message_type, RESULT)
        self._connections = {
            topic: self._writer.add_connection(
                "/" + topic, kind, typestore=TYPES, offered_qos_profiles=[_offered(qos)]
            )
            for topic, (kind, qos) in kinds.items()
        }

    def write(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """Append one serialised message; the stamp is that of the frame that it comes from."""
        if self._is_open:
            self._writer.write(self._connections[topic], stamp_ns, data)

    def close(self) -> None:
        """Write the index and metadata.yaml."""
        if self._is_open:
            self._writer.close()
            self._is_open = False

    def drop(self) -> None:
        """Remove the bag, which only repeats the tables and the pictures, to make room for them."""
        self._is_open = False
        with suppress(OSError):
            self._writer.storage.bio.close()  # type: ignore[union-attr]  # its own close writes
        shutil.rmtree(self._path, ignore_errors=True)


def _type_name(kind: type) -> str:
    return f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"


def _offered(qos: QoSProfile) -> Qos:
    latched = qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=qos.depth,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=_FOREVER,
        lifespan=_FOREVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOREVER,
        avoid_ros_namespace_conventions=False,
    )
