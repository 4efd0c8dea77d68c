"""A camera driver of somebody else's: publishes pictures in a process of its own.

    python driver.py TOPIC ENCODING reliable|best_effort [FIRST]

It says `publishes` and waits until somebody listens. Then each line on standard input is a
command: `COUNT` publishes so many pictures, a hundredth of a second apart, `burst COUNT` all at
once.
"""

import sys
import time

import numpy as np
import rclpy
from mjpeg_server import jpeg_picture
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage, Image

PERIOD_NS = 10_000_000
START_NS = 1_700_000_000_000_000_000


def raw_picture(number, encoding):
    """A picture as a driver fills it; mono8 and mono16 show its number exactly."""
    grey = jpeg_picture(number)
    pixels = {
        "mono8": grey,
        "mono16": grey.astype("<u2") << 4,  # twelve bits of light
        "bgr8": np.repeat(grey[:, :, None], 3, axis=2),
        "rgb8": np.repeat(grey[:, :, None], 3, axis=2),
        "bayer_rggb8": grey,
    }[encoding]
    message = Image(encoding=encoding, height=grey.shape[0], width=grey.shape[1])
    message.step = pixels.nbytes // grey.shape[0]
    message.data.frombytes(pixels.tobytes())
    return message


def compressed_picture(number):
    import cv2

    message = CompressedImage(format="jpeg")
    message.data.frombytes(cv2.imencode(".jpg", jpeg_picture(number))[1].tobytes())
    return message


def main():
    topic, encoding, reliability, *first = sys.argv[1:]
    rclpy.init(args=[])
    node = Node("driver", start_parameter_services=False)
    kind = CompressedImage if encoding == "jpeg" else Image
    policy = ReliabilityPolicy[reliability.upper()]
    qos = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=10, reliability=policy)
    publisher = node.create_publisher(kind, topic, qos)
    print("publishes", flush=True)
    while not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.05)
    number = int(first[0]) if first else 0
    for line in sys.stdin:
        pause_s = 0.0 if line.startswith("burst") else PERIOD_NS / 1e9
        for _ in range(int(line.split()[-1])):
            is_jpeg = encoding == "jpeg"
            message = compressed_picture(number) if is_jpeg else raw_picture(number, encoding)
            stamp_ns = START_NS + number * PERIOD_NS
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
            publisher.publish(message)
            number += 1
            time.sleep(pause_s)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
