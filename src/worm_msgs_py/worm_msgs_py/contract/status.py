"""Why a frame has, or has not, a pose: one code for every frame."""

from enum import IntEnum


class Status(IntEnum):
    """The outcome of tracking one frame.

    The value travels in messages and never changes its meaning; new codes are appended.
    `label` is what tables and `summary.json` use, `reason` is for people.
    """

    TRACKED = 0
    COILED = 1
    NO_WORM = 2
    TOUCHES_BORDER = 3
    BAD_IMAGE = 4
    NO_CHAMBER = 5
    TOO_SMALL = 6
    TOO_LARGE = 7
    AMBIGUOUS = 8
    BRIDGED = 9
    END_HIDDEN = 10
    FOLDED = 11
    LOOP_IN_DOUBT = 12

    @property
    def label(self) -> str:
        """Lower-case name, as written to the column `status`."""
        return self.name.lower()

    @property
    def has_pose(self) -> bool:
        """Whether head, centroid and tail are given."""
        with_pose = (Status.TRACKED, Status.BRIDGED, Status.FOLDED, Status.LOOP_IN_DOUBT)
        return self in with_pose

    @property
    def may_have_head(self) -> bool:
        """Whether a head may be given: with `END_HIDDEN` it is where the hidden end is the tail."""
        return self.has_pose or self is Status.END_HIDDEN

    @property
    def reason(self) -> str:
        """One sentence that says what the code means."""
        return _REASONS[self]

    @classmethod
    def from_label(cls, label: str) -> "Status":
        """Return the member with this label; ValueError where there is none."""
        try:
            return cls[label.upper()]
        except KeyError:
            known = ", ".join(member.label for member in cls)
            raise ValueError(f"no status is called {label!r}; known: {known}") from None


_REASONS = {
    Status.TRACKED: "Head, centroid, tail and midline were found.",
    Status.COILED: "The body touches or crosses itself and its midline could not be resolved; "
    "the centroid is given.",
    Status.NO_WORM: "Nothing in the picture stands out from the background.",
    Status.TOUCHES_BORDER: "The body reaches beyond the picture; the centroid of what is seen "
    "is given.",
    Status.BAD_IMAGE: "The picture is empty, saturated, of another size than the first one, or "
    "repeats the one before.",
    Status.NO_CHAMBER: "The chamber has not been found yet.",
    Status.TOO_SMALL: "What stands out is too small to be the worm seen so far.",
    Status.TOO_LARGE: "What stands out is too large to be one worm.",
    Status.AMBIGUOUS: "Several objects could be the worm.",
    Status.BRIDGED: "A part of the body between its ends was hidden; the midline there is "
    "interpolated.",
    Status.FOLDED: "The body touches or crosses itself; head, centroid, tail and midline were "
    "found.",
    Status.LOOP_IN_DOUBT: "The body touches or crosses itself, and a loop of it may be passed "
    "either way round; head, centroid and tail were found, the midline in the loop is not given.",
    Status.END_HIDDEN: "An end of the body was hidden; it is not given, nor is the midline there.",
}
