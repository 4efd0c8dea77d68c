"""Topic names, relative, so that a namespace such as /rig1 works (docs/architecture.md)."""

IMAGE = "image_raw"
IMAGE_COMPRESSED = "image_raw/compressed"

CAMERA_INFO = "camera_info"
"""The pinhole camera that chambers and worm are seen through, with the stamp of each picture."""
TF_STATIC = "tf_static"
"""The camera over the sheet: never moves. Relative, as all names are: two rigs are two trees."""
TF = "tf"
"""Where the chambers lie on the sheet, with the stamp of each frame."""

CHAMBER = "chamber"
CHAMBER_GEOMETRY = "chamber/geometry"

WORM_STATE = "worm/state"
WORM_HEAD = "worm/head"
WORM_CENTROID = "worm/centroid"
WORM_TAIL = "worm/tail"
WORM_MIDLINE = "worm/midline"
WORM_ANNOTATIONS = "worm/annotations"
"""What Foxglove draws over the picture, a message a frame."""

WORM_OVERLAY = "worm/overlay/compressed"
"""The pictures with all of that drawn over them, while somebody looks."""

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
