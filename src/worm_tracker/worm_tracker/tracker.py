"""The tracker: pictures in, one `TrackedFrame` per picture out, in order."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import cv2

from worm_msgs_py.arrays import Picture
from worm_msgs_py.contract.body import TrackedFrame
from worm_msgs_py.contract.chamber import Geometry
from worm_msgs_py.contract.status import Status
from worm_msgs_py.errors import NoChamberFound, NotAPicture, TrackerError
from worm_msgs_py.files.corrections import (
    Correction,
    CorrectionKind,
    why_beyond,
    why_not_of,
    why_not_together,
)
from worm_tracker.calibration.rig_monitor import GeometryChange, RigMonitor, RigMonitorSettings
from worm_tracker.detection.blobs import around_all
from worm_tracker.detection.detection import Detection
from worm_tracker.detection.detector import Detector, DetectorSettings
from worm_tracker.detection.picture_checks import (
    PictureCheckSettings,
    is_informative,
    why_no_picture,
)
from worm_tracker.detection.polarity import dark_on_bright
from worm_tracker.detection.repeated_pictures import RepeatedPictures, RepeatedPicturesSettings
from worm_tracker.failure_advice import FailureAdvice
from worm_tracker.following.follower import Follower
from worm_tracker.following.follower_settings import FollowerSettings
from worm_tracker.frame_intervals import FrameIntervals, FrameIntervalSettings
from worm_tracker.head_tail.identity import Exchange, ExchangeKind, HeadTail, HeadTailSettings
from worm_tracker.observation import Observation
from worm_tracker.parameters import TrackerParameters
from worm_tracker.propagation.backwards import PastDetection
from worm_tracker.propagation.opening import AgreementSettings
from worm_tracker.waiting.brief_gaps import BriefGapSettings
from worm_tracker.waiting.frame_queue import FrameQueue
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.waiting.leaping_ends import LeapingEnds, LeapingEndsSettings
from worm_tracker.waiting.lone_poses import LonePoses, LonePoseSettings
from worm_tracker.waiting.repeated_frames import RepeatedFrames
from worm_tracker.waiting.sudden_lengths import SuddenLengths, SuddenLengthSettings
from worm_tracker.worm_track import WormTrack


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """The constants of every stage: a user leaves them alone, a test may change one."""

    intervals: FrameIntervalSettings = field(default_factory=FrameIntervalSettings)
    rig: RigMonitorSettings = field(default_factory=RigMonitorSettings)
    detector: DetectorSettings = field(default_factory=DetectorSettings)
    follower: FollowerSettings = field(default_factory=FollowerSettings)
    head_tail: HeadTailSettings = field(default_factory=HeadTailSettings)
    most_frames_for_body: int = 256
    """More frames of a fold do not wait until the body is known well: of a worm that lies double
    for longer what is known by then has to do, and telling its head may take longer."""
    frames_back_per_frame: int = 1
    """Once a worm opens, its fold is gone back through by so many frames with every new one: what
    that takes fits beside a new frame of 30 a second, and a live trial skips none for it."""
    agreement: AgreementSettings = field(default_factory=AgreementSettings)
    """When the way into a fold and the way back out of it confirm each other."""
    brief_gaps: BriefGapSettings = field(default_factory=BriefGapSettings)
    leaping_ends: LeapingEndsSettings = field(default_factory=LeapingEndsSettings)
    lone_poses: LonePoseSettings = field(default_factory=LonePoseSettings)
    sudden_lengths: SuddenLengthSettings = field(default_factory=SuddenLengthSettings)
    opencv_threads: int | None = 1
    """Threads of OpenCV in this process; None leaves them as they are. On windows as small as a
    worm's a second one takes as much of the processor again (a folded frame 10 ms, 17 with two),
    and the frame is there no sooner."""
    checks: PictureCheckSettings = field(default_factory=PictureCheckSettings)
    repeats: RepeatedPicturesSettings = field(default_factory=RepeatedPicturesSettings)


TRACKER = TrackerSettings()


@dataclass(frozen=True, eq=False, slots=True)
class _Stages:
    """What a picture passes, once the rig has been found in one of this shape."""

    shape: tuple[int, ...]
    rig: RigMonitor
    detector: Detector
    follower: Follower


class Tracker:
    """Tracks one worm.

    Parameters
    ----------
    parameters : TrackerParameters
        What a user may tell it; the defaults suit the paper's rig.
    settings : TrackerSettings
    corrections : sequence of Correction
        What people have set right of these pictures (`read_corrections`).

    Raises
    ------
    TrackerError
        The corrections exclude each other.

    Notes
    -----
    OpenCV is left with one thread in this process, unless the settings say otherwise.

    Attributes
    ----------
    changes : list of GeometryChange
        Every later version of the geometry, and why.

    Examples
    --------
    >>> tracker, analysis = Tracker(), Analysis()  # doctest: +SKIP
    >>> for picture, stamp_ns in pictures_of_bag("bags/larva"):  # doctest: +SKIP
    ...     for frame in tracker.push(picture, stamp_ns):
    ...         observables, events = analysis.push(frame)
    """

    def __init__(
        self,
        parameters: TrackerParameters | None = None,
        settings: TrackerSettings = TRACKER,
        corrections: Sequence[Correction] = (),
    ) -> None:
        wrong = why_not_together(corrections)
        if wrong:
            raise TrackerError(wrong)
        self._parameters = parameters = parameters or TrackerParameters()
        self._settings = settings
        if settings.opencv_threads is not None:
            cv2.setNumThreads(settings.opencv_threads)
        self._stages: _Stages | None = None
        self._track = WormTrack()
        head_tail = HeadTail(self._track, settings.head_tail)
        self._corrections = tuple(corrections)
        self._queue = FrameQueue(
            head_tail,
            parameters.hold_back_frames,
            parameters.px_per_mm,
            self._corrections,
            most_frames_for_body=settings.most_frames_for_body,
            agreement=settings.agreement,
            brief_gaps=settings.brief_gaps,
        )
        self._leaping_ends = LeapingEnds(settings.leaping_ends)
        self._lone_poses = LonePoses(settings.lone_poses)
        self._sudden_lengths = SuddenLengths(settings.sudden_lengths)
        self._statuses = Counter[Status]()
        self._advice = FailureAdvice(parameters)
        self._intervals = FrameIntervals(settings.intervals)
        self._repeated = RepeatedPictures(settings.repeats)
        self.changes: list[GeometryChange] = []
        self._not_found: list[NoChamberFound] = []
        self._repeats = RepeatedFrames()
        self._frames = 0
        self._last_ns = 0

    @property
    def geometry(self) -> Geometry | None:
        """The rig, once it has been found; a new version whenever it is found again."""
        return None if self._stages is None else self._stages.rig.geometry

    @property
    def exchanges(self) -> list[Exchange]:
        """Each time that head and tail were exchanged, by the tracker or by an operator."""
        return self._queue.exchanges

    @property
    def statuses(self) -> Counter[Status]:
        """Frames given so far, by status."""
        return self._statuses

    @property
    def advice(self) -> str:
        """What to try where most frames have failed, a given circle is off or pictures repeat."""
        shown = self.statuses - Counter({Status.BAD_IMAGE: self.repeated})
        failed = self._advice.sentence(shown)
        return failed or (self._stages.rig.advice if self._stages else "") or self._repeated.advice

    @property
    def repeated(self) -> int:
        """Pictures taken so far that repeat the one before: those frames have no pose."""
        return self._repeated.count

    @property
    def swaps(self) -> int:
        """Times that the tracker has exchanged head and tail from one given frame to the next."""
        return sum(exchange.kind is ExchangeKind.SWAP for exchange in self.exchanges)

    @property
    def held(self) -> int:
        """Frames taken that have not been given yet."""
        judged = len(self._leaping_ends) + len(self._lone_poses)
        return len(self._queue) + judged + len(self._repeats)

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Height and width that every picture must have; None until the rig is known."""
        return None if self._stages is None else self._stages.shape

    def push(self, picture: Picture, stamp_ns: int) -> list[TrackedFrame]:
        """Take the next picture.

        Parameters
        ----------
        picture : ndarray of uint8, shape (h, w)
            Grey levels. One of another size than the first, black, saturated, empty (0, 0: it
            stands for one that could not be read) or all but the same as the one before, in a film
            that moves, is a frame with the status `BAD_IMAGE`.
        stamp_ns : int
            Time of capture.

        Returns
        -------
        list of TrackedFrame
            Frames that are ready, in order; none while which end is the head is being decided.

        Raises
        ------
        NotAPicture
            Where it is in colour, of other numbers than uint8, or no array; nothing was taken.
        NoChamberFound
            Where the first pictures show no chamber (and `no_chamber` was not set).
        TrackerError
            Where a correction is of another recording; nothing was taken.
        """
        wrong = why_no_picture(picture)
        if wrong:
            raise NotAPicture(wrong)
        wrong = why_not_of(self._corrections, self._frames, stamp_ns)
        if wrong:
            raise TrackerError(wrong)
        self._obey_requests()
        frame, self._frames = self._frames, self._frames + 1
        self._last_ns = stamp_ns
        if self._stages is not None and self._repeated.push(picture):
            self._repeats.hold(frame, stamp_ns, self.geometry)
            return self._give(self._release())
        elapsed = self._intervals.push(stamp_ns)
        self._track.skip(elapsed.steps - 1, elapsed.over_steps)
        bodies_begun = self._track.bodies_begun
        observation = self._observe(picture, stamp_ns)
        if self._track.bodies_begun != bodies_begun:
            self._queue.reopen()
        self._queue.push(PendingFrame(frame, stamp_ns, observation, self.geometry, elapsed))
        model = self._track.model
        if self._queue.is_due(model is not None and model.is_learned and not model.varies):
            self._go_back(self._settings.frames_back_per_frame)
        return self._give(self._release())

    def swap_head(self) -> Exchange | None:
        """Exchange head and tail on an operator's word, for the rest of the trial.

        Returns
        -------
        Exchange or None
            What it applies to: the frames held back and all that come. None where no worm has been
            seen that could be turned round.
        """
        return self._queue.swap_head(self._frames, self._last_ns)

    @property
    def _body_in_doubt(self) -> bool:
        """Whether what is known of the worm's body may be that of one laid double."""
        model = self._track.model
        return model is not None and model.may_be_doubled

    def finish(self) -> list[TrackedFrame]:
        """Return the frames that are still held back; the film is over.

        Raises
        ------
        NoChamberFound
            Where pictures came, but none with a chamber.
        TrackerError
            Where a correction is of frames that did not come.
        """
        wrong = why_beyond(self._corrections, self._frames)
        if wrong:
            raise TrackerError(wrong)
        self._obey_requests()
        if self._stages is None and self._not_found:
            raise self._not_found[-1]
        self._go_back()
        return self._give(self._queue.finish(self._body_in_doubt), is_end=True)

    def _give(self, frames: list[TrackedFrame], *, is_end: bool = False) -> list[TrackedFrame]:
        """Return the frames of which it is known by now whether they can be believed, and count."""
        most = self._parameters.hold_back_frames - len(self._queue) - len(self._repeats)
        judged = self._leaping_ends.push(frames, most, is_end=is_end)
        judged = self._lone_poses.push(judged, most - len(self._leaping_ends), is_end=is_end)
        given = self._repeats.among(self._sudden_lengths.push(judged))
        self._statuses.update(frame.state.status for frame in given)
        return given

    def _release(self) -> list[TrackedFrame]:
        return self._queue.release(self._body_in_doubt, len(self._repeats))

    def _obey_requests(self) -> None:
        """Do what an operator asked for after the last picture, when these were first tracked."""
        for told in self._corrections:
            is_request = told.what is CorrectionKind.SWAP_REQUEST
            if is_request and told.first_frame == self._frames - 1:
                self.swap_head()

    def _go_back(self, most: int | None = None) -> None:
        """Go back through the coils that wait, by so many frames at most; None: all."""
        if self._stages is not None:
            self._queue.go_back(self._resolve_back, most)

    def _resolve_back(
        self, opened: Observation, detections: Sequence[PastDetection]
    ) -> Iterator[Observation]:
        """Go back through pictures by what is known by now of the worm and of dirt under it."""
        stages = self._stages
        if stages is None or not detections:
            return iter(())
        window = around_all([past.detection.view.window for past in detections])
        dirt = stages.detector.dirt_in(window)
        if dirt is not None:
            detections = [
                replace(past, detection=past.detection.with_dirt(dirt, window))
                for past in detections
            ]
        return stages.follower.resolve_back(opened, detections)

    def _observe(self, picture: Picture, stamp_ns: int) -> Observation:
        """Return what the picture says, calibrating first."""
        stages = self._stages
        too_small = min(picture.shape) < self._settings.checks.least_side_px
        if too_small or (stages and picture.shape != stages.shape):
            return Observation(Status.BAD_IMAGE)
        picture = dark_on_bright(picture, self._parameters.polarity)
        if stages is None:
            return self._begin(picture, stamp_ns)
        if not is_informative(picture, self._settings.checks):
            return self._shows_nothing(picture)
        picture = stages.rig.stabilised(picture, stamp_ns)
        change = stages.rig.check(picture, stamp_ns, self._track.contour)
        if change is not None:
            self._adopt(change, picture, stages)
        return self._follow(picture, stages)

    def _follow(self, picture: Picture, stages: _Stages) -> Observation:
        """Detect the worm, find its midline, and let the background follow."""
        detection = stages.detector.detect(picture, self._track.prior)
        observation = stages.follower.push(detection)
        blob = detection.blob if isinstance(detection, Detection) else None
        self._advice.see(picture, stages.detector.arena, observation.status, blob)
        if observation.status is not Status.BAD_IMAGE:
            all_worm = stages.follower.all_of_worm(observation)
            stages.detector.update_background(picture, detection, self._track.prior, all_worm)
        return observation

    def _shows_nothing(self, picture: Picture) -> Observation:
        self._advice.see(picture, None, Status.BAD_IMAGE, None)
        return Observation(Status.BAD_IMAGE)

    def _adopt(self, change: GeometryChange, picture: Picture, stages: _Stages) -> None:
        """Take a new geometry, and all that is remembered along with it."""
        self.changes.append(change)
        if change.motion is not None:
            self._go_back()
            self._queue.link_all()  # what waits lies where the rig was
        stages.detector.transform(picture, stages.rig.assumed, change.motion)
        if change.motion is not None:
            self._track.transform(change.motion)

    def _begin(self, picture: Picture, stamp_ns: int) -> Observation:
        """Calibrate on one of the first pictures and start to follow the worm."""
        informative, settings = is_informative(picture, self._settings.checks), self._settings
        if self._parameters.no_chamber and not informative:
            return self._shows_nothing(picture)
        try:
            rig = RigMonitor(picture, self._parameters, stamp_ns, settings.rig)
        except NoChamberFound as error:
            self._not_found.append(error)
            if len(self._not_found) >= self._parameters.calibration_frames:
                raise
            return Observation(Status.NO_CHAMBER if informative else Status.BAD_IMAGE)
        detector = Detector(picture, rig.assumed, settings.detector)
        following = settings.follower.seen_as(self._parameters.polarity)
        follower = Follower(self._track, picture.shape, following)
        self._stages = _Stages(picture.shape, rig, detector, follower)
        observation = self._follow(picture, self._stages)
        rig.mark_hidden_exits(self._track.contour)
        return observation
