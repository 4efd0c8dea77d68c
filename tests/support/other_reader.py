"""Reads result bags as other software does: by libraries that are not ours and did not write."""

from collections import defaultdict

import cv2
import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import RigidTransform, Rotation


def messages_by_topic(results):
    """Return (time of recording, message) of each topic of a result's bag, in order."""
    found = defaultdict(list)
    with (results / "bag" / "bag.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found[channel.topic].append((message.log_time, decoded))
    return found


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class View:
    """The camera of each picture and the frames under it, from camera_info and tf alone."""

    def __init__(self, found):
        self._cameras = {stamp_ns(camera): camera for _, camera in found["/camera_info"]}
        self._still = {
            item.child_frame_id: (item.header.frame_id, _pose(item.transform))
            for _, message in found["/tf_static"]
            for item in message.transforms
        }
        self._moving = {
            (item.child_frame_id, stamp_ns(item)): (item.header.frame_id, _pose(item.transform))
            for _, message in found["/tf"]
            for item in message.transforms
        }

    def project(self, points_m, frame_id, at_ns):
        """Return where points of a frame, shape (n, 3), are in the picture, shape (n, 2)."""
        camera = self._cameras[at_ns]
        pose = RigidTransform.identity()
        while frame_id != camera.header.frame_id:
            moving = self._moving.get((frame_id, at_ns))
            frame_id, step = moving if moving is not None else self._still[frame_id]
            pose = step * pose
        inside = np.ascontiguousarray(pose.apply(points_m))[:, None]
        matrix, bent = np.reshape(camera.k, (3, 3)), np.array(camera.d)
        return cv2.projectPoints(inside, np.zeros(3), np.zeros(3), matrix, bent)[0][:, 0]


def _pose(transform):
    at, turn = transform.translation, transform.rotation
    return RigidTransform.from_components(
        (at.x, at.y, at.z), Rotation.from_quat((turn.x, turn.y, turn.z, turn.w))
    )


def cloud(message):
    """Return the fields of a PointCloud2 of float32 by name, points that are nowhere left out."""
    fields = {field.name: field.offset for field in message.fields}
    layout = np.dtype(
        {
            "names": list(fields),
            "formats": ["<f4"] * len(fields),
            "offsets": list(fields.values()),
            "itemsize": message.point_step,
        }
    )
    points = np.frombuffer(bytes(message.data), layout)
    points = points[np.isfinite(points["x"])]
    return {name: points[name].astype(float) for name in fields}


def picture(message):
    """Return the picture of an Image (mono8) or a CompressedImage."""
    if hasattr(message, "encoding"):
        assert message.encoding == "mono8"
        rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
        return rows[:, : message.width]
    return cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_GRAYSCALE)


def distances_px(points, line):
    """Return how far each point, shape (n, 2), is from a line of points, shape (k, 2)."""
    starts, steps = line[:-1], np.diff(line, axis=0)
    long = np.maximum((steps**2).sum(axis=1), 1e-12)
    along = np.einsum("nkd,kd->nk", points[:, None] - starts, steps) / long
    feet = starts + np.clip(along, 0.0, 1.0)[..., None] * steps
    return np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1)
