"""Contact by one threshold on the radius, told at once: in the place of the hidden state."""

from worm_analysis.events.contact_state import ResolvedFrame
from worm_analysis.statistics.depth_law import LEAST_NOISE, DepthLaw


class ThresholdContact:
    """Stands in for `HiddenContact`, so that what follows it can be held to plain computations."""

    law = DepthLaw(noise=LEAST_NOISE)
    threshold_m = 0.0

    def __init__(self, settings):
        """Take the settings of what it stands in for: one threshold has none."""

    def push(self, stamp_ns, theta_rad, depth_m, head_m, threshold_m, *, in_mouth):
        if threshold_m != threshold_m:
            return None, []
        contact = depth_m < threshold_m
        frame = ResolvedFrame(
            stamp_ns, theta_rad, depth_m, head_m, contact, False, float(contact), 0.0, 0.0
        )
        return contact, [frame]

    def cut(self):
        return []
