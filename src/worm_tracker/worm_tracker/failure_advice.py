"""Why a film gives no poses, told from looks at a few of its pictures, and what to try then."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Floats32, Picture
from worm_msgs_py.contract.status import Status
from worm_tracker.calibration.circle_fit import CircleFitSettings, FittedCircle, find_circles
from worm_tracker.detection.blobs import (
    Blob,
    BlobSettings,
    draw_blob,
    find_blobs,
    noise_sd,
    thickness,
    whole_picture,
)
from worm_tracker.detection.glare import SATURATED
from worm_tracker.detection.polarity import Polarity
from worm_tracker.parameters import TrackerParameters


class Cause(StrEnum):
    """What one picture shows that the tracker cannot go on with; a person can mend each."""

    BLACK = "black"
    WHITE = "white"
    RIM = "rim"
    OTHER_CIRCLE = "other_circle"
    POLARITY = "polarity"
    SEVERAL = "several"
    FAINT = "faint"


@dataclass(frozen=True, slots=True)
class FailureAdviceSettings:
    """What is looked at, and from when on it is a cause."""

    most_looks: int = 16
    """Pictures that are looked at, spread over the film; from half as many on there are enough."""
    longest_side_px: int = 512
    """Of the picture that is looked at; larger ones are reduced."""
    ground_over_side: float = 0.1
    """Side of the median that shows the ground alone, over the picture's: a worm is less than half
    as wide."""
    darkest_grey: int = 16
    """A picture that is nowhere brighter is black to a person too."""
    most_white: float = 0.15
    """Part of the water that may be saturated: a reflection is less."""
    signal_over_noise: float = 5.0
    least_signal_grey: float = 6.0
    """What stands out from the ground by as much is an object, in a picture as it comes."""
    faint_blur_px: float = 2.0
    least_faint_grey: float = 1.0
    """The same in a picture that is blurred by as much."""
    least_slenderness: float = 4.0
    """Area over squared thickness from which an object is long as a worm is, no bubble or spot."""
    most_area_ratio_of_worms: float = 2.5
    """Largest over smallest of objects that may be worms alike."""
    bright_over_dark: float = 3.0
    """Area of what is bright over that of what is dark from which a worm is the bright one."""
    rim_over_radius: float = 1.5
    """Extent of an object, both ways, over a wall's radius, from which it is that wall."""
    circle_off_over_radius: float = 0.1
    """How far from a wall that is seen a circle is another one, over the radius."""


FAILURE_ADVICE = FailureAdviceSettings()


@dataclass(frozen=True, eq=False, slots=True)
class _Look:
    """A picture that is kept, to be weighed up once that is asked for: that takes long.

    Attributes
    ----------
    picture : ndarray of uint8, shape (h, w)
        Reduced where it was large.
    arena : ndarray of uint8, shape (h, w), or None
        Not zero where a worm can be.
    scale : float
        Side of the picture over what it was.
    has_pose, is_rim : bool
        What the tracker made of it, and whether the worm is a round wall.
    """

    picture: Picture
    arena: Picture | None
    scale: float
    has_pose: bool
    is_rim: bool


class FailureAdvice:
    """Looks at some of a film's pictures and says at its end what to try, where most have failed.

    Parameters
    ----------
    parameters : TrackerParameters
        What the user said of the film.
    settings : FailureAdviceSettings
    """

    def __init__(
        self, parameters: TrackerParameters, settings: FailureAdviceSettings = FAILURE_ADVICE
    ) -> None:
        self._parameters = parameters
        self._settings = settings
        self._looks: list[_Look] = []
        self._frames = 0
        self._stride = 1
        self._wall: FittedCircle | None = None

    def see(
        self, picture: Picture, arena: Picture | None, status: Status, blob: Blob | None
    ) -> None:
        """Take the next picture that could be read; one in a while is looked at.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
            As the tracker takes it: inverted where the worm is said to be bright.
        arena : ndarray of uint8, shape (h, w), or None
            Not zero where a worm can be; None where that is not known.
        status : Status
            What the tracker makes of it.
        blob : Blob or None
            The object that it takes for the worm.
        """
        due = self._frames % self._stride == 0
        self._frames += 1
        if not due:
            return
        self._looks.append(self._look(picture, arena, status, blob))
        if len(self._looks) >= self._settings.most_looks:
            self._looks = self._looks[::2]
            self._stride *= 2

    def sentence(self, statuses: Mapping[Status, int]) -> str:
        """Return what to try; empty where most frames have a pose that can be believed.

        Parameters
        ----------
        statuses : mapping of Status to int
            All frames of the film.
        """
        frames = sum(statuses.values())
        failed = {status: n for status, n in statuses.items() if n and not status.has_pose}
        without = sum(failed.values())
        causes = [self._cause(look) for look in self._looks]
        believed = Counter(cause for cause in causes if cause in _NEVER_BELIEVED)
        mostly = 2 * without > frames
        said = f"{without} of {frames} frames have no pose" if mostly else "the poses are no worm's"
        for cause, looks in believed.most_common(1):
            if 2 * looks > len(self._looks):
                return f"{said}: {self._remedy(cause)}"
        if not mostly:
            return ""
        of_failed = [
            cause for look, cause in zip(self._looks, causes, strict=True) if not look.has_pose
        ]
        for cause, looks in Counter(cause for cause in of_failed if cause).most_common(1):
            if 2 * looks > len(of_failed):
                return f"{said}: {self._remedy(cause)}"
        status = max(failed, key=lambda one: failed[one])
        return f"{said}: {_BY_STATUS[status]}" if 2 * failed[status] > frames else ""

    def _look(
        self, picture: Picture, arena: Picture | None, status: Status, blob: Blob | None
    ) -> _Look:
        """Return what is kept of a picture."""
        is_rim = self._is_rim(picture, blob)
        scale = min(self._settings.longest_side_px / max(picture.shape), 1.0)
        if scale < 1:
            picture = _reduced(picture, scale)
            arena = None if arena is None else _reduced(arena, scale, cv2.INTER_NEAREST)
        else:
            picture = picture.copy()
        return _Look(picture, arena, scale, status.has_pose, is_rim)

    def _cause(self, look: _Look) -> Cause | None:
        """Return what is wrong with a picture; of one with a pose only what makes it a mistake."""
        picture, arena = look.picture, look.arena
        if look.is_rim:
            return Cause.RIM
        if arena is not None:  # a pixel's width of wall may be in it
            arena = np.asarray(cv2.erode(arena, np.ones((5, 5), np.uint8)), np.uint8)
            if not arena.any():
                return None
        seen = _StandsOut.of(picture, arena, self._settings)
        if seen.is_bright:
            return Cause.POLARITY
        if look.has_pose:
            return None
        inside = picture if arena is None else picture[arena > 0]
        exposure = self._exposure(inside)
        if exposure is not None:
            return exposure
        if self._parameters.chamber_given and self._is_other_circle(picture, look.scale):
            return Cause.OTHER_CIRCLE
        if seen.several:
            return Cause.SEVERAL
        return Cause.FAINT if seen.is_faint else None

    def _exposure(self, inside: Picture) -> Cause | None:
        bright = self._parameters.polarity is Polarity.BRIGHT
        as_filmed = 255 - inside if bright else inside
        if np.quantile(as_filmed, 0.98) < self._settings.darkest_grey:
            return Cause.BLACK
        white = float(np.mean(as_filmed >= SATURATED))
        return Cause.WHITE if white > self._settings.most_white else None

    def _is_rim(self, picture: Picture, blob: Blob | None) -> bool:
        """Tell whether the object that is taken for the worm is a round wall."""
        if blob is None or not self._parameters.no_chamber:
            return False
        u0, v0, u1, v1 = blob.box
        if 4 * min(u1 - u0, v1 - v0) < 3 * max(u1 - u0, v1 - v0) and not blob.hole_area:
            return False
        for wall in find_circles(picture, CircleFitSettings(), most=1):
            if min(u1 - u0, v1 - v0) > self._settings.rim_over_radius * wall.radius:
                self._wall = wall
                return True
        return False

    def _is_other_circle(self, picture: Picture, scale: float) -> bool:
        """Tell whether the wall that is seen is elsewhere than the circle that was given."""
        given = self._parameters
        walls = find_circles(picture, CircleFitSettings())
        for wall in walls:
            off = np.hypot(
                wall.u / scale - given.centre_u_px, wall.v / scale - given.centre_v_px
            ) + abs(wall.radius / scale - given.radius_px)
            if off < self._settings.circle_off_over_radius * wall.radius / scale:
                return False
        for wall in walls[:1]:
            self._wall = FittedCircle(wall.u / scale, wall.v / scale, wall.radius / scale)
        return bool(walls)

    def _remedy(self, cause: Cause) -> str:
        """Return the cause and what to try, in words."""
        given = self._parameters.polarity
        ground, worm = ("dark", "bright") if given is Polarity.DARK else ("bright", "dark")
        circle = ""
        if self._wall is not None:
            circle = f"{self._wall.u:.0f} {self._wall.v:.0f} {self._wall.radius:.0f}"
        return {
            Cause.BLACK: "the pictures are nearly black: give more light or a longer exposure",
            Cause.WHITE: "much of the ground is overexposed: lower the light or the exposure until "
            f"clear water is below {SATURATED} of 255 everywhere",
            Cause.RIM: "the rim of a round chamber is taken for the worm: leave out --no-chamber, "
            f"or give the rim as --circle-px {circle}",
            Cause.OTHER_CIRCLE: "the wall is not where --circle-px says: leave it out, or try "
            f"--circle-px {circle}",
            Cause.POLARITY: f"the worm seems to be {worm} on {ground} ground: try --polarity "
            f"{worm}",
            Cause.SEVERAL: "several objects of one size are in view, and one worm is tracked: film "
            "one alone, cut the pictures to it, or give the chamber that it is in as --circle-px",
            Cause.FAINT: "something as thin as a worm stands out only where a picture is blurred: "
            "give more contrast or more pixels per mm, focus, and compress the pictures less",
        }[cause]


_NEVER_BELIEVED = (Cause.POLARITY, Cause.RIM)
"""Causes that make a pose a mistake, however sure it is."""
_BY_STATUS = {
    Status.COILED: "what stands out is one object without two free ends: film one worm alone, at "
    "more pixels per mm (five to its width), and see that nothing dark touches it",
    Status.NO_WORM: "nothing stands out: see that the worm is in view and, with a chamber, within "
    "the circle that was found (else --circle-px); give more contrast",
    Status.TOUCHES_BORDER: "what stands out reaches beyond the picture: take all of the worm's "
    "ground into view; where that is a dark rim, give the circle within as --circle-px",
    Status.BAD_IMAGE: "the pictures cannot be decoded, are empty, or differ in size or brightness "
    "from the first: see what made them, and that the lamp was on at the start (--start-offset)",
    Status.NO_CHAMBER: "no round wall stands out: give it as --circle-px, or say --no-chamber",
    Status.TOO_SMALL: "what stands out is only a part of the worm seen at first: give even light "
    "and more contrast, or leave out the start (--start-offset)",
    Status.TOO_LARGE: "what stands out is larger than the worm: take away what touches it, or give "
    "the chamber that it is in as --circle-px",
    Status.AMBIGUOUS: "several objects could be the worm: film one alone, or give the chamber that "
    "it is in as --circle-px",
    Status.END_HIDDEN: "glare hides an end of the worm: lower the exposure, or move the lamp",
}


@dataclass(frozen=True, slots=True)
class _StandsOut:
    """What stands out from the ground of one picture.

    Attributes
    ----------
    is_bright : bool
        It is long as a worm, and next to nothing is dark.
    several : bool
        There are several dark objects of about one size, long as worms.
    is_faint : bool
        Nothing, or only pieces, stand out unless the picture is blurred; then something long does.
    """

    is_bright: bool
    several: bool
    is_faint: bool

    @classmethod
    def of(
        cls, picture: Picture, arena: Picture | None, settings: FailureAdviceSettings
    ) -> "_StandsOut":
        """Look at a picture."""
        side = 2 * (round(settings.ground_over_side * max(picture.shape)) // 2) + 1
        if arena is not None:  # the walls are no ground, or a passage would stand out from them
            water = round(float(np.median(_some_of(picture, arena))))
            picture = np.where(arena > 0, picture, np.uint8(water))
        ground = cv2.medianBlur(picture, max(side, 15)).astype(np.float32)
        signal = ground - cv2.GaussianBlur(picture, (3, 3), 0)
        least = settings.least_signal_grey
        dark, bright = (_objects(sign * signal, arena, least, settings) for sign in (1.0, -1.0))
        dark_area, long_bright = sum(blob.area for blob in dark), _long_blobs(bright, settings)
        bright_area = sum(blob.area for blob in long_bright)
        alike = [
            blob
            for blob in _long_blobs(dark, settings)
            if blob.area * settings.most_area_ratio_of_worms > dark[0].area
        ]
        is_bright = bright_area > settings.bright_over_dark * dark_area
        several = len(alike) > 1
        is_faint = False
        if (several or not dark) and not is_bright:
            blurred = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), settings.faint_blur_px)
            faint = _objects(ground - blurred, arena, settings.least_faint_grey, settings)
            joined = [
                blob for blob in _long_blobs(faint, settings) if _holds_all_but_one(blob, alike)
            ]
            is_faint = bool(joined)
        return cls(is_bright, several and not is_faint, is_faint)


def _holds_all_but_one(whole: Blob, pieces: list[Blob]) -> bool:
    """Tell whether objects, but for one of them, lie in the box of another."""
    u0, v0, u1, v1 = whole.box
    inside = sum(u0 <= blob.u <= u1 and v0 <= blob.v <= v1 for blob in pieces)
    return inside >= max(len(pieces) - 1, min(len(pieces), 2))


def _objects(
    signal: Floats32, arena: Picture | None, least: float, settings: FailureAdviceSettings
) -> list[Blob]:
    """Return what stands out, the largest first."""
    noise = noise_sd(np.rint(16 * _some_of(signal, arena)).astype(np.int16)) / 16
    above = signal > max(settings.signal_over_noise * noise, least)
    if arena is not None:
        above &= arena > 0
    mask = above.astype(np.uint8) * 255
    return find_blobs(mask, 128, whole_picture(mask.shape), BlobSettings())


def _long_blobs(blobs: list[Blob], settings: FailureAdviceSettings) -> list[Blob]:
    """Return the objects that are long as a worm is."""
    found = []
    for blob in blobs:
        u0, v0, u1, v1 = blob.box
        window = slice(max(v0 - 1, 0), v1 + 2), slice(max(u0 - 1, 0), u1 + 2)
        if blob.area > settings.least_slenderness * thickness(draw_blob(blob, window)) ** 2:
            found.append(blob)
    return found


def _some_of(picture: Picture | Floats32, arena: Picture | None, stride: int = 3) -> Floats:
    """Return enough of a picture's pixels, within the arena, for a median."""
    some = picture[::stride, ::stride]
    inside = some if arena is None else some[arena[::stride, ::stride] > 0]
    return np.asarray(inside if inside.size else some, np.float64)


def _reduced(picture: Picture, scale: float, by: int = cv2.INTER_AREA) -> Picture:
    v, u = (max(1, round(scale * side)) for side in picture.shape)  # a strip keeps a row
    return np.asarray(cv2.resize(picture, (u, v), interpolation=by), np.uint8)
