"""Detects the worm in the picture: the one dark object that continues the one seen before."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_msgs_py.contract.chamber import Geometry
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.background import Background, BackgroundSettings
from worm_tracker.detection.blobs import (
    Blob,
    BlobSettings,
    Window,
    draw_blob,
    find_blobs,
    first_threshold,
    most_likely_worm,
    noise_sd,
    several_of_area,
    smoothed,
    thickness,
    whole_picture,
    window_around,
)
from worm_tracker.detection.debris import DebrisSettings, Surroundings, absorb_debris
from worm_tracker.detection.detection import Detection, DetectionPrior, Missed, SignalView
from worm_tracker.detection.dirt import LastPicture, dark_beside
from worm_tracker.detection.glare import (
    GlareSettings,
    glare_in,
    glare_limit,
    look_through_glare,
    may_occlude,
)
from worm_tracker.detection.illumination import (
    IlluminationSettings,
    arena_of,
    clear_water,
    empty_rig,
    evened,
    evening_of,
    passage_rims,
)
from worm_tracker.detection.kept_out import dark_mask, either_of, worm_mask
from worm_tracker.detection.occlusion import OcclusionSettings
from worm_tracker.detection.pale_ends import PaleEndSettings, with_pale_ends
from worm_tracker.detection.reconnection import drawn, reconnected
from worm_tracker.midline.body_model import BodyModel


@dataclass(frozen=True, slots=True)
class DetectorSettings:
    """What counts as the worm in a picture."""

    least_area_over_worm: float = 0.1
    """Smaller objects are none."""
    cut_off_area_over_worm: float = 0.95
    """Area below which a part of the worm may have been cut off."""
    search_margin_px: int = 24
    """How far around the last object it is looked for first."""
    least_reach_px: float = 20.0
    """How far a worm can have got in a frame, at least; a longer one gets as far as it is long."""
    search_in_glare_widths: float = 6.0
    """The same where there is glare, which hides how far it goes."""
    glare_reach_widths: float = 2.0
    """How near to the worm glare must be for anything of it to be occluded."""
    width_of_unknown_worm_px: float = 3.0
    """Width of a worm of which nothing has been seen yet."""
    first_worm_margin_px: int = 6
    """How far about the first object its blur may darken the first background."""
    dark_over_threshold: float = 0.5
    dark_over_noise: float = 3.0
    """Signal that is kept out of the background as long as no worm is seen: it may be one."""
    blobs: BlobSettings = field(default_factory=BlobSettings)
    background: BackgroundSettings = field(default_factory=BackgroundSettings)
    illumination: IlluminationSettings = field(default_factory=IlluminationSettings)
    glare: GlareSettings = field(default_factory=GlareSettings)
    occlusion: OcclusionSettings = field(default_factory=OcclusionSettings)
    pale_ends: PaleEndSettings = field(default_factory=PaleEndSettings)
    debris: DebrisSettings = field(default_factory=DebrisSettings)


class Detector:
    """Detects the worm from picture to picture, and keeps the background that it is told by.

    What the worm was like and where it was comes with each picture, as a `DetectionPrior`.

    Parameters
    ----------
    picture : ndarray of uint8, shape (h, w)
        The first picture, dark worm on bright background.
    geometry : Geometry
        The rig.
    settings : DetectorSettings
    """

    def __init__(self, picture: Picture, geometry: Geometry, settings: DetectorSettings) -> None:
        self._settings = settings
        empty, arena, light = empty_rig(picture, geometry, settings.illumination)
        self._arena = arena.astype(np.uint8) * 255
        self._empty = np.rint(empty).astype(np.uint8)
        evening = evening_of(light, arena, settings.illumination)
        signal = evened(np.asarray(cv2.subtract(self._empty, picture), np.uint8), evening)
        signal = smoothed(np.asarray(cv2.bitwise_and(signal, self._arena), np.uint8))
        self._noise = noise_sd((empty - picture).astype(np.int16)[arena])
        self._first_threshold = first_threshold(signal, self._noise, settings.blobs)
        worm = self._first_worm(picture, signal, geometry)
        water = clear_water(arena, geometry)
        self._background = Background(picture, empty, worm, water, evening, settings.background)
        self._frames_of_all_worm = 0
        self._last: LastPicture | None = None

    @property
    def arena(self) -> Picture:
        """Where a worm can be; not zero there."""
        return self._arena

    def dirt_in(self, window: Window) -> Picture | None:
        """Return where dirt is known to lie in a window, 0 or 255; None where nowhere.

        It makes the background dim, or is dark in the last picture away from the worm.
        """
        dim, last = self._background.dim.picture(window), self._last
        if last is None:
            return dim
        signal = smoothed(self._signal(last.picture, last.gain, window))
        dark = dark_beside(signal, window, last, self._settings.debris)
        return dark if dim is None else np.asarray(cv2.bitwise_or(dark, dim), np.uint8)

    def transform(self, picture: Picture, geometry: Geometry, motion: Floats | None) -> None:
        """Take a new geometry, before the picture that it holds from is looked at.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        geometry : Geometry
        motion : ndarray, shape (2, 3), or None
            Affine map of old picture coordinates to new ones; None where nothing has moved.
        """
        arena = arena_of(picture, geometry, self._settings.illumination)
        if motion is None:
            opened = arena & (self._arena == 0)
            self._background.reset(picture, self._background.gain(picture), opened)
        else:
            self._background.transform(motion)
            size = self._empty.shape[::-1]
            self._empty = np.asarray(cv2.warpAffine(self._empty, motion, size), np.uint8)
        self._arena = arena.astype(np.uint8) * 255

    def detect(self, picture: Picture, prior: DetectionPrior) -> Detection | Missed:
        """Find the worm, near where it was, else in all of the picture."""
        gain = self._background.gain(picture)
        if not self._background.is_view(gain):
            return Missed(Status.BAD_IMAGE, gain)
        found = self._detect_in_glare(picture, gain, prior)
        if found is None and prior.blob is not None:
            near = window_around(prior.blob.box, self._settings.search_margin_px, picture.shape)
            found = self._detect_in(self._view(picture, gain, near, prior), picture.shape, prior)
        if found is not None:
            return found
        view = self._view(picture, gain, whole_picture(picture.shape), prior)
        return self._detect_in(view, picture.shape, prior) or self._missed(view, prior)

    def update_background(
        self,
        picture: Picture,
        detection: Detection | Missed,
        prior: DetectionPrior,
        all_worm: Floats | None,
    ) -> None:
        """Let the background follow a picture where the worm is not.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
        detection : Detection or Missed
            What was found in it.
        prior : DetectionPrior
            What is known of the worm now, this picture included.
        all_worm : ndarray, shape (TRACKED_POINTS, 2), or None
            The midline where it is that of all of the worm: what is elsewhere is something else.
        """
        threshold, settings = self._threshold(prior), self._settings
        level = settings.dark_over_threshold * min(threshold, 255.0)
        level = max(level, settings.dark_over_noise * self._noise)
        dark = dark_mask(self._background, picture, detection.gain, level)
        if isinstance(detection, Missed):
            self._background.average(picture, detection.gain, dark)
            self._last = None
            return
        self._last = LastPicture(picture.copy(), detection.gain, detection.blob, threshold)
        if detection.occlusion is None:  # else not all of the worm may be known
            worm = worm_mask(detection.blob, settings.debris.worm_blur_px)
            least = settings.cut_off_area_over_worm * prior.area
            # The rest may be paler than the threshold.
            unknown = prior.model is None or prior.may_be_in_part
            part = unknown or detection.blob.area < least
            mask = either_of(worm, dark) if part else worm
            self._background.average(picture, detection.gain, mask)
        if all_worm is not None and prior.model is not None:
            self._absorb_debris(picture, detection, prior, prior.model, all_worm)

    def _absorb_debris(
        self,
        picture: Picture,
        detection: Detection,
        prior: DetectionPrior,
        model: BodyModel,
        all_worm: Floats,
    ) -> None:
        """Take debris beside all of the worm for background, where there may be any."""
        settings = self._settings
        self._frames_of_all_worm += 1
        near = window_around(detection.blob.box, settings.search_margin_px, picture.shape)
        due = self._frames_of_all_worm % settings.debris.check_every_frames == 0
        if due or detection.crowded or self._background.dim.any_in(near):
            seen = Surroundings(
                picture,
                detection.gain,
                self._arena,
                self._empty,
                model,
                detection.blob,
                all_worm,
                self._threshold(prior),
                self._noise,
            )
            absorb_debris(self._background, seen, settings.debris)

    def _first_worm(self, picture: Picture, signal: Picture, geometry: Geometry) -> Picture:
        """Return where in the first picture a worm may be, not zero there."""
        everything, margin = whole_picture(picture.shape), self._settings.first_worm_margin_px
        blobs = self._blobs(signal, self._first_threshold, everything)
        if blobs and blobs[0].touches(everything):  # by the rims of a passage, maybe
            rims = passage_rims(picture, geometry, self._settings.illumination)
            signal = np.where(rims, np.uint8(0), signal)
            blobs = self._blobs(signal, self._first_threshold, everything)
        if not blobs:
            return np.zeros_like(picture)
        settings = self._settings
        threshold, noise = self._first_threshold, self._noise
        view = SignalView(everything, signal, signal, threshold, 1.0, settings.blobs, noise)
        first, ends = Detection(view, blobs[0]), settings.pale_ends
        whole = with_pale_ends(first, DetectionPrior(), ends, may_be_cut=False) or first
        worm = draw_blob(whole.blob, everything, margin)
        limit = glare_limit(self._empty, settings.background.glare_over_clear_grey)
        white = glare_in(picture, limit)
        if white.any():  # what is near glare may be another part of the worm
            size = 2 * self._settings.search_margin_px + 1
            near_white = cv2.dilate(white, np.ones((size, size), np.uint8))
            for blob in blobs[1:]:
                fragment = draw_blob(blob, everything, margin)
                if cv2.bitwise_and(fragment, near_white).any():
                    worm |= fragment
        return worm

    def _threshold(self, prior: DetectionPrior) -> float:
        """Return the signal, grey levels, above which a pixel belongs to an object."""
        if prior.model is None:
            return self._first_threshold
        settings = self._settings.blobs
        over_noise = settings.threshold_over_noise * self._noise
        return max(settings.threshold_over_body * prior.model.level, over_noise)

    def _blobs(self, signal: Picture, threshold: float, window: Window) -> list[Blob]:
        return find_blobs(signal, threshold, window, self._settings.blobs)

    def _signal(self, picture: Picture, gain: float, window: Window) -> Picture:
        """Return how much darker than the background a window is, where a worm can be."""
        signal = self._background.signal(picture, gain, window)
        cv2.bitwise_and(signal, self._arena[window], dst=signal)
        return signal

    def _view(
        self, picture: Picture, gain: float, window: Window, prior: DetectionPrior
    ) -> SignalView:
        signal = self._signal(picture, gain, window)
        return self._view_of(window, signal, smoothed(signal), self._threshold(prior), gain)

    def _view_of(
        self, window: Window, signal: Picture, smooth: Picture, threshold: float, gain: float
    ) -> SignalView:
        blobs, dim = self._settings.blobs, self._background.dim.picture(window)
        return SignalView(window, signal, smooth, threshold, gain, blobs, self._noise, dim=dim)

    def _detect_in(
        self, view: SignalView, shape: tuple[int, ...], prior: DetectionPrior
    ) -> Detection | None:
        """Find the worm in a window; None where it is not there, or not all of it."""
        blobs, whole = view.blobs(), whole_picture(shape)
        blob = self._pick(blobs, prior)
        if blob is None or (blob.touches(view.window) and not blob.touches(whole)):
            return None
        found = Detection(view, blob, self._is_crowded(blobs, blob, prior))
        found = self._with_cut_off(found, len(blobs), prior)
        ends = self._settings.pale_ends
        return with_pale_ends(found, prior, ends, may_be_cut=view.window != whole)

    def _missed(self, view: SignalView, prior: DetectionPrior) -> Missed:
        """Say why there is no worm in the whole picture."""
        blobs = view.blobs()
        if prior.model is None:  # no worm has been seen yet: the threshold may be wrong
            self._first_threshold = first_threshold(view.signal, self._noise, self._settings.blobs)
        rivals = prior.blob is None and self._several_worms(blobs, prior)
        return Missed(Status.AMBIGUOUS if rivals else Status.NO_WORM, view.gain)

    def _is_crowded(self, blobs: list[Blob], blob: Blob, prior: DetectionPrior) -> bool:
        """Tell whether there is more than the worm, beside it or hanging on to it."""
        most = self._settings.debris.crowded_area_over_known * prior.area
        return len(blobs) > 1 or blob.area > most

    def _detect_in_glare(
        self, picture: Picture, gain: float, prior: DetectionPrior
    ) -> Detection | None:
        """Find a worm that glare may occlude in part; None where there is none near it."""
        threshold, settings = self._threshold(prior), self._settings
        if not np.isfinite(threshold):
            return None
        window, body = whole_picture(picture.shape), prior.body
        width = prior.model.width if prior.model else 0.0
        if body is not None and prior.blob is not None:
            around = round(settings.search_in_glare_widths * width)
            window = window_around(prior.blob.box, around, picture.shape)
        if not self._background.any_glare(picture, gain, window):
            return None
        now, limit = picture[window], self._background.glare_limit(gain, window)
        background = self._background.scaled(gain, window)
        width = width or self._first_width(picture, gain)
        # The signal in it is not evened: what lights the worm there is not told by the rig's light.
        through = look_through_glare(
            now, limit, background, self._arena[window], width, threshold, settings.glare
        )
        view = self._view_of(window, through.signal, through.smooth, threshold, gain)
        reach = settings.glare_reach_widths * width
        if body is not None and not may_occlude(through.occluder, view.in_window(body), reach):
            return None
        level = threshold / settings.blobs.threshold_over_body
        body_seen = reconnected(view, through.occluder, width, level, prior, settings.occlusion)
        if body_seen is not None:
            return drawn(view, through.occluder, body_seen, width, level)
        blobs = view.blobs()
        blob = self._pick(blobs, prior)
        if blob is None:
            return None
        crowded = self._is_crowded(blobs, blob, prior)
        return Detection(view, blob, crowded, occluder=through.occluder)

    def _with_cut_off(self, found: Detection, objects: int, prior: DetectionPrior) -> Detection:
        """Return a detection with what is cut off by dirt in the background that has moved on."""
        view, settings = found.view, self._settings
        small = found.blob.area < settings.cut_off_area_over_worm * prior.area
        if prior.body is None or prior.model is None or objects < 2 or not small:
            return found
        if not self._background.dim.any_in(view.window):
            return found
        occluder = self._background.dim.mask(view.window).astype(np.uint8)
        width, level = prior.model.width, view.threshold / settings.blobs.threshold_over_body
        body = reconnected(view, occluder, width, level, prior, settings.occlusion)
        if body is None or any(body.occluded_ends):
            return found
        whole = drawn(view, occluder, body, width, level)
        return found if whole is None or whole.blob.area < found.blob.area else whole

    def _first_width(self, picture: Picture, gain: float) -> float:
        """Return a first guess of the worm's width: the thickness of the largest object."""
        everything = whole_picture(picture.shape)
        signal = smoothed(self._signal(picture, gain, everything))
        blobs = self._blobs(signal, self._first_threshold, everything)
        if not blobs:
            return self._settings.width_of_unknown_worm_px
        return thickness(draw_blob(blobs[0], everything))

    def _large_enough(self, blobs: list[Blob], prior: DetectionPrior) -> list[Blob]:
        least = self._settings.least_area_over_worm * prior.area
        return [blob for blob in blobs if blob.area > least]

    def _several_worms(self, blobs: list[Blob], prior: DetectionPrior) -> bool:
        """Tell whether several objects could each be the worm, by their size."""
        return several_of_area(self._large_enough(blobs, prior), prior.area, self._settings.blobs)

    def _pick(self, blobs: list[Blob], prior: DetectionPrior) -> Blob | None:
        """Return the object that is the worm, if any can be."""
        blobs = self._large_enough(blobs, prior)
        if prior.blob is None:
            # With nothing to go by but the size, two of the worm's size could each be the worm.
            if self._several_worms(blobs, prior):
                return None
            return most_likely_worm(blobs, prior.area, 0.0, 0.0, 0.0)
        u0, v0, u1, v1 = prior.blob.box
        reach = max(float(u1 - u0), float(v1 - v0), self._settings.least_reach_px)
        return most_likely_worm(blobs, prior.area, prior.blob.u, prior.blob.v, reach)
