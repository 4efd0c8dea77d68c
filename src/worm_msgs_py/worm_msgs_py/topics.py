"""Topic names, relative, so that a namespace such as /rig1 works (docs/architecture.md)."""

IMAGE = "image_raw"
IMAGE_COMPRESSED = "image_raw/compressed"

CHAMBER = "chamber"
CHAMBER_GEOMETRY = "chamber/geometry"

WORM_STATE = "worm/state"
WORM_HEAD = "worm/head"
WORM_CENTROID = "worm/centroid"
WORM_TAIL = "worm/tail"
WORM_MIDLINE = "worm/midline"

ANALYSIS_STATE = "analysis/state"
ANALYSIS_EVENTS = "analysis/events"
ANALYSIS_CORRELATION = "analysis/correlation"
ANALYSIS_DISTRIBUTIONS = "analysis/distributions"
ANALYSIS_SUMMARY = "analysis/summary"
ANALYSIS_SUMS = "analysis/sums"
"""At the end: what the numbers rest on, a message a sum."""

MODEL_FORECAST = "model/forecast"
MODEL_COMPARISON = "model/comparison"
MODEL_CORRELATION = "model/correlation"

SOURCE_EVENTS = "source/events"
"""What happened to the pictures: outages, damage, an early end."""

DIAGNOSTICS = "/diagnostics"

FLOW_TRACKED = "flow/tracked"
"""From the tracker: frames taken and states given (UInt64MultiArray of two)."""
FLOW_RECORDED = "flow/recorded"
"""From the recorder: states written (UInt64)."""
FLOW_FINISHED = "flow/finished"
"""From each node as it finishes, latched: how many messages it has sent on each topic."""
FLOW_END = "flow/end"
"""From the source, latched: the number of frames that were sent; nothing comes after them."""
