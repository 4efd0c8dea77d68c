"""What a person sets right is right in those frames, and nothing else is changed by it."""

import numpy as np
import pytest
from crawling_worm import FRAME_NS, SMALL_RIG, crawl, film, wavy_path

from worm_msgs_py import Chamber, Geometry, Status
from worm_msgs_py.errors import TrackerError
from worm_msgs_py.files.corrections import Correction, CorrectionKind
from worm_tracker.head_tail.identity import ExchangeKind, HeadTail, HeadTailSettings
from worm_tracker.observation import Observation
from worm_tracker.parameters import TrackerParameters
from worm_tracker.propagation.opening import AgreementSettings
from worm_tracker.tracker import Tracker
from worm_tracker.waiting.brief_gaps import BriefGapSettings
from worm_tracker.waiting.frame_queue import FrameQueue
from worm_tracker.waiting.frame_state import PendingFrame
from worm_tracker.worm_track import WormTrack

FRAMES, AHEAD = 24, 60
"""Frames of most tests, and those in which the worm goes ahead before it goes back for longer."""
PARAMETERS = TrackerParameters(hold_back_frames=0)


@pytest.fixture(scope="module")
def there_and_back():
    """A worm that goes ahead and then back: where no frame may wait its head is exchanged then."""
    ahead = np.arange(AHEAD)
    heads = 110.0 + 4.0 * np.concatenate([5 + ahead, np.arange(AHEAD + 5)[::-1]])
    return film(SMALL_RIG, crawl(wavy_path(SMALL_RIG), 110.0, 12.0, heads))


@pytest.fixture(scope="module")
def pictures(there_and_back):
    return there_and_back[:FRAMES]


def said(what, first, last):
    last_ns = None if last is None else last * FRAME_NS
    return Correction(what, first, first * FRAME_NS, last, last_ns, "Mia", "2026-03-21T09:30Z")


def swap(first, last):
    return said(CorrectionKind.SWAP_HEAD, first, last)


def track(pictures, corrections=(), asked=()):
    """Return what is given; after some frames an operator asks for an exchange."""
    tracker = Tracker(PARAMETERS, corrections=corrections)
    given = []
    for frame, picture in enumerate(pictures):
        given += tracker.push(picture, frame * FRAME_NS)
        for _ in range(asked.count(frame)):
            tracker.swap_head()
    return given + tracker.finish(), tracker


def same(one, other):
    """Tell whether two frames are the same to the last bit; NaN is NaN."""
    lines = [
        (frame.midline.u_px.tobytes(), frame.midline.x_m.tobytes(), frame.midline.s_px.tobytes())
        for frame in (one, other)
    ]
    return repr(one.state) == repr(other.state) and lines[0] == lines[1]


@pytest.fixture(scope="module")
def uncorrected(pictures):
    return track(pictures)[0]


def test_a_stretch_that_the_tracker_exchanged_is_set_right(there_and_back):
    """Truth: the worm never turns round, so the head stays within a step of where it was."""
    plain, tracker = track(there_and_back)
    (wrong,) = (each.frame for each in tracker.exchanges if each.kind is ExchangeKind.SWAP)
    right, _ = track(there_and_back, [swap(wrong, None)])

    def jumps(given):
        heads = np.array([(each.state.head.u_px, each.state.head.v_px) for each in given])
        return np.hypot(*np.diff(heads, axis=0).T).max()

    assert jumps(plain) > 60.0
    assert jumps(right) < 10.0


def test_frames_outside_are_the_same_and_those_inside_are_turned_round(pictures, uncorrected):
    inside = (range(3), (7,), range(9, 13), range(FRAMES - 2, FRAMES))
    ranges = [swap(0, 2), swap(7, 7), swap(9, 12), swap(FRAMES - 2, None)]
    corrected, _ = track(pictures, ranges)
    for plain, told in zip(uncorrected, corrected, strict=True):
        if not any(told.state.frame in frames for frames in inside):
            assert same(plain, told)
            continue
        assert (told.state.head.u_px, told.state.tail.u_px) == (
            plain.state.tail.u_px,
            plain.state.head.u_px,
        )
        np.testing.assert_array_equal(told.midline.u_px, plain.midline.u_px[::-1])
        np.testing.assert_array_equal(told.midline.width_px, plain.midline.width_px[::-1])
        assert told.state.head_certainty > 0.9999
        assert told.state.head_certainty < 1.0
        assert told.state.centroid.u_px == plain.state.centroid.u_px
        turned = np.cos(told.state.centroid.yaw_rad - plain.state.centroid.yaw_rad)
        assert turned < 0.0


@pytest.mark.parametrize("asked", [[5, 18], [12, 12, FRAMES - 1]])
def test_what_an_operator_asked_for_is_done_again_at_the_same_frame(pictures, asked):
    live, _ = track(pictures, asked=asked)
    requests = [said(CorrectionKind.SWAP_REQUEST, frame, None) for frame in asked]
    again, tracker = track(pictures, requests)
    assert all(same(one, other) for one, other in zip(live, again, strict=True))
    assert len([e for e in tracker.exchanges if e.kind is ExchangeKind.CORRECTION]) == len(asked)


def test_a_request_and_a_range_hold_together(pictures):
    request = said(CorrectionKind.SWAP_REQUEST, 10, None)
    live, _ = track(pictures, [request])
    both, _ = track(pictures, [swap(15, 17), request])
    for one, other in zip(live, both, strict=True):
        assert same(one, other) == (not 15 <= one.state.frame <= 17)


def test_corrections_of_another_recording_are_refused(pictures):
    other = Correction(
        CorrectionKind.SWAP_HEAD, 1, 7, 2, 2 * FRAME_NS, "Mia", "2026-03-21T09:30:00Z"
    )
    tracker = Tracker(PARAMETERS, corrections=[other])
    tracker.push(pictures[0], 0)
    for _ in range(2):  # nothing was taken
        with pytest.raises(TrackerError, match="of another recording: its frame 1"):
            tracker.push(pictures[1], FRAME_NS)
    short = Tracker(PARAMETERS, corrections=[swap(1, 5)])
    for frame in range(3):
        short.push(pictures[frame], frame * FRAME_NS)
    with pytest.raises(TrackerError, match="this one has 3 frames"):
        short.finish()


def test_corrections_that_exclude_each_other_are_refused():
    with pytest.raises(TrackerError, match="exchanged twice"):
        Tracker(PARAMETERS, corrections=[swap(0, 5), swap(5, None)])


def test_a_head_in_the_passage_comes_from_the_chamber_that_the_corrected_head_was_in():
    chambers = tuple(
        Chamber(name, u, 100.0, 80.0, exit_rad, 0.01, 0.004)
        for name, u, exit_rad in (("chamber_a", 100.0, 0.0), ("chamber_b", 400.0, np.pi))
    )
    rig = Geometry(1, 0, 500, 200, chambers, passage_length_m=0.0175)

    def frame_ids(corrections):
        head_tail = HeadTail(WormTrack(), HeadTailSettings())
        queue = FrameQueue(
            head_tail,
            0,
            np.nan,
            corrections,
            most_frames_for_body=0,
            agreement=AgreementSettings(),
            brief_gaps=BriefGapSettings(),
        )
        for frame, (first_u, last_u) in enumerate([(60, 440), (240, 260)]):
            line = np.stack([np.linspace(first_u, last_u, 121), np.full(121, 100.0)], axis=1)
            widths = np.full(121, 12.0)
            seen = Observation(Status.TRACKED, 250.0, 100.0, line, widths, 1.0, 12.0)
            queue.push(PendingFrame(frame, frame * FRAME_NS, seen, rig))
        return [told.state.frame_id for told in queue.finish()]

    plain, corrected = frame_ids([]), frame_ids([swap(0, 0)])
    assert plain[0] == plain[1]
    assert corrected[0] == corrected[1] != plain[0]
