"""Sends frames as source, tracker and analysis do, for tests of nodes that only look."""

import numpy as np
from sensor_msgs.msg import Image

from worm_model.simulator.scenes import Take, at_the_wall
from worm_msgs_py import (
    BodyState,
    Correlation,
    Keypoint,
    Midline,
    Observables,
    Status,
    convert,
    topics,
)
from worm_msgs_py.ros.interfaces import RESULTS
from worm_msgs_py.ros.qos import IMAGE_REPLAY
from worm_msgs_py.ros.worm_node import WormNode

TAKE = Take(px_per_mm=16.0, frames=6)
SENT = (
    topics.CHAMBER, topics.CHAMBER_GEOMETRY, topics.WORM_STATE, topics.WORM_MIDLINE,
    topics.ANALYSIS_STATE, topics.ANALYSIS_CORRELATION,
)  # fmt: skip


def film():
    """Picture and true state, midline and observables of some frames."""
    (chamber,) = TAKE.chamber.chambers
    for number, frame in enumerate(at_the_wall(TAKE)):
        truth, stamp_ns = frame.truth, 10**9 + frame.stamp_ns
        u, v = (np.array(each) for each in (truth.midline_u_px, truth.midline_v_px))
        x, y = chamber.to_metres(u, v)
        points = {
            name: Keypoint(getattr(truth, f"{name}_u_px"), getattr(truth, f"{name}_v_px"), 0.0, 0.0)
            for name in ("head", "centroid", "tail")
        }
        state = BodyState(
            number, stamp_ns, "chamber_a", status=Status.TRACKED, geometry=1, head_certainty=1.0,
            width_px=6.0, length_px=300.0, length_m=0.02, **points,
        )  # fmt: skip
        midline = Midline(u, v, x, y, np.zeros_like(u), np.full_like(u, 6.0))
        observables = Observables(number, stamp_ns, r_h_m=truth.r_h_mm * 1e-3, psi_b_rad=0.5)
        yield frame.picture, state, midline, observables


class Sender(WormNode):
    """Stands for all nodes that a viewer looks at."""

    def __init__(self, context):
        super().__init__("sender", context=context)
        self.geometry = TAKE.chamber.geometry()
        self._out = {topic: self.create_publisher(RESULTS[topic][0], topic, RESULTS[topic][1])
                     for topic in SENT}  # fmt: skip
        self._pictures = self.create_publisher(Image, topics.IMAGE, IMAGE_REPLAY)
        self._out[topics.CHAMBER_GEOMETRY].publish(convert.geometry_to_msg(self.geometry))
        self._out[topics.CHAMBER].publish(convert.geometry_to_markers(self.geometry))

    def send(self, picture, state, midline, observables):
        self._pictures.publish(convert.picture_to_msg(picture, state.stamp_ns))
        self._out[topics.WORM_STATE].publish(convert.body_state_to_msg(state))
        self._out[topics.WORM_MIDLINE].publish(convert.midline_to_msg(midline, state))
        self._out[topics.ANALYSIS_STATE].publish(convert.observables_to_msg(observables))
        lags = np.array([0.0, 1.0, 2.0])
        curve = Correlation(lags, np.array([1.0, 0.5, np.nan]), lags, np.array([9, 9, 0]), lags)
        self._out[topics.ANALYSIS_CORRELATION].publish(
            convert.correlation_to_msg(curve, state.stamp_ns)
        )
