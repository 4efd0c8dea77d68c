"""Names of the coordinate frames, and the parts of the rig in which a worm can be.

Each chamber has a frame of its own: origin at the centre, x towards the middle of its exit, z
towards the camera, right-handed, metres (docs/science.md). Angles grow counter-clockwise as seen in
the picture. The camera's optical frame has x right and y down (REP 103).
"""

from enum import IntEnum

CHAMBER_A = "chamber_a"
CHAMBER_B = "chamber_b"
CAMERA = "camera_optical_frame"
RIG_FRAME = "rig"
"""The sheet under the camera: x right and y up in the picture, z towards the camera, origin in the
middle of the picture, on the sheet."""


class Where(IntEnum):
    """The part of the rig that holds the worm's head.

    The value travels in messages; `label` is what tables and people read.
    """

    UNKNOWN = 0
    CHAMBER_A = 1
    CHAMBER_B = 2
    PASSAGE = 3

    @property
    def label(self) -> str:
        """Lower-case name, as written to the column `where`."""
        return self.name.lower()

    @classmethod
    def from_label(cls, label: str) -> "Where":
        """Return the member with this label; ValueError where there is none."""
        try:
            return cls[label.upper()]
        except KeyError:
            known = ", ".join(member.label for member in cls)
            raise ValueError(f"no part of the rig is called {label!r}; known: {known}") from None
