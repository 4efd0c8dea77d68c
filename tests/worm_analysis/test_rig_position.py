"""Visits, skips and attempts at the exit, told from tracks in which each is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from walked_tracks import BODY_WIDTH, GEOMETRY, THRESHOLD, R, Track, polar

from worm_analysis.analysis import Analysis
from worm_analysis.events.attempts import Attempts
from worm_analysis.events.exit_region import ExitCorridor
from worm_analysis.events.visits import exits_passed
from worm_msgs_py import Attempt, Episode, StrokePhase, Visit, Where

RATE_HZ = 20
NS = 10**9
DEEP = 1.5e-3
ALONG_WALL = THRESHOLD / 3


class Path:
    """A track put together piece by piece, in the chambers' own frames."""

    def __init__(self):
        self.head, self.centroid, self.chamber, self.where, self.length = [], [], [], [], []

    def along(self, start_rad, end_rad, depth_m, frames, chamber="chamber_a"):
        """Move along the wall at a depth, the body inside the chamber."""
        head = polar(np.full(frames, R - depth_m), np.linspace(start_rad, end_rad, frames))
        where = Where.CHAMBER_A if chamber == "chamber_a" else Where.CHAMBER_B
        return self._add(head, 0.5 * head, chamber, where)

    def into_exit(self, x_p_m, frames, chamber="chamber_a", y_m=0.0, body_follows=False):
        """Put the head into the passage, x_p beyond the mouth; W = 1 mm."""
        mouth = np.sqrt(R**2 - (0.5e-3) ** 2)
        head = np.tile([mouth + x_p_m, y_m], (frames, 1))
        centroid = head - [2e-3, 0.0] if body_follows else 0.3 * head
        return self._add(head, centroid, chamber, Where.PASSAGE)

    def in_and_out(self, x_p_m, y_m=0.0, step_m=1e-4):
        """Go into the passage from before it at some distance from its axis, and back."""
        mouth = np.sqrt(R**2 - (0.5e-3) ** 2)
        x = np.r_[np.arange(-4e-4, x_p_m, step_m), x_p_m]
        head = np.column_stack([mouth + np.r_[x, x[::-1]], np.full(2 * len(x), y_m)])
        for point in head:
            inside = np.hypot(*point) < R
            where = Where.CHAMBER_A if inside else Where.PASSAGE
            self._add(point[None], 0.3 * point[None], "chamber_a", where)
        return self

    def lose(self, frames):
        nothing = np.full((frames, 2), np.nan)
        return self._add(nothing, nothing, "chamber_a", Where.UNKNOWN)

    def _add(self, head, centroid, chamber, where):
        self.head.append(head)
        self.centroid.append(centroid)
        self.chamber += [chamber] * len(head)
        self.where += [where] * len(head)
        return self

    def events(self, length=None):
        head = np.concatenate(self.head)
        n = len(head)
        t = np.arange(n) / RATE_HZ
        track = Track(
            stamp_ns=np.round(t * NS).astype(np.int64),
            head=head,
            centroid=np.concatenate(self.centroid),
            tail=np.zeros((n, 2)),
            yaw=np.zeros(n),
            width=np.full(n, BODY_WIDTH),
            length=np.full(n, 0.02) if length is None else length(t),
            chamber=np.array(self.chamber),
            where=np.array(self.where),
        )
        analysis = Analysis()
        analysis.set_geometry(GEOMETRY)
        events = [event for state in track.states() for event in analysis.push(state)[1]]
        events += analysis.finish()
        found = {quantity.name: quantity for quantity in analysis.summary()}
        return events, found


def of(kind, events):
    return [event for event in events if isinstance(event, kind)]


def test_tau_h_counts_from_first_contact_to_the_first_entry():
    path = Path().along(1.0, 1.2, DEEP, 10).along(1.2, 0.2, ALONG_WALL, 50).into_exit(1e-3, 5)
    (visit,) = of(Visit, path.events()[0])
    assert visit.first_contact_ns == visit.start_ns + 10 * NS // RATE_HZ
    assert visit.theta_h0_rad == pytest.approx(1.2)
    assert visit.tau_h_s == pytest.approx(50 / RATE_HZ)
    assert not visit.complete, "the trial began within the visit"


def test_a_withdrawal_is_a_failed_attempt_and_starts_no_new_visit():
    path = Path().along(1.0, 0.2, ALONG_WALL, 30)
    path.into_exit(1e-3, 5).into_exit(2.5e-3, 5).into_exit(0.5e-3, 5)
    path.along(0.2, 1.0, ALONG_WALL, 30).into_exit(0.7e-3, 5).along(-0.2, -1.0, DEEP, 30)
    events, _ = path.events()
    first, second = of(Attempt, events)
    assert first.penetration_m == pytest.approx(2.5e-3)
    assert second.penetration_m == pytest.approx(0.7e-3)
    assert (first.success, first.complete) == (False, True)
    assert first.end_ns - first.start_ns == 15 * NS // RATE_HZ
    assert len(of(Visit, events)) == 1


def test_a_passage_to_the_other_chamber_is_a_success_and_a_new_visit():
    path = Path().along(1.0, 0.2, ALONG_WALL, 30).into_exit(1e-3, 5)
    path.into_exit(8e-3, 20, body_follows=True)
    path.into_exit(8e-3, 20, "chamber_b", body_follows=True)
    path.along(0.3, 2.0, ALONG_WALL, 40, "chamber_b").into_exit(1e-3, 4, "chamber_b")
    events, _ = path.events()
    attempt, pending = of(Attempt, events)
    assert (attempt.success, attempt.complete, attempt.chamber) == (True, True, "chamber_a")
    assert attempt.end_ns - attempt.start_ns == 5 * NS // RATE_HZ
    assert (pending.complete, pending.chamber) == (False, "chamber_b")
    first, second = of(Visit, events)
    assert (first.chamber, second.chamber) == ("chamber_a", "chamber_b")
    assert second.complete, "both its ends were seen"
    assert second.tau_h_s == pytest.approx(40 / RATE_HZ)
    assert second.theta_h0_rad == pytest.approx(0.3)


@pytest.mark.parametrize(("depth_m", "skips"), [(DEEP, 1), (ALONG_WALL, 0)], ids=["hop", "slide"])
@pytest.mark.parametrize("frames", [4, 200], ids=["fast", "slow"])
@pytest.mark.parametrize("turns", [0, 2])
def test_a_skip_is_a_hop_over_the_exit(depth_m, skips, frames, turns):
    start = 2 * np.pi * turns
    path = Path().along(-1.0, start - 0.5, ALONG_WALL, 400)  # sliding over the exit is no skip
    path.along(start - 0.3, start + 0.3, depth_m, frames)
    path.along(start + 0.5, start + 1, ALONG_WALL, 40)
    events, found = path.events()
    (visit,) = of(Visit, events)
    assert visit.skips == skips
    assert found["n_s"].n == skips


@pytest.mark.parametrize(("depth_m", "skips"), [(0.3 * R, 1), (0.8 * R, 0)])
def test_a_way_through_the_middle_of_the_chamber_skips_nothing(depth_m, skips):
    """Both come from the wall at -1.2 rad; one comes back to it beyond the exit, one before."""
    for end_rad, passed in ((1.2, skips), (-0.3, 0)):
        path = Path().along(-2.0, -1.2, ALONG_WALL, 40).along(-1.1, 0.4, depth_m, 10)
        path.along(0.4, end_rad, depth_m, 10).along(end_rad, end_rad, ALONG_WALL, 10)
        assert of(Visit, path.events()[0])[0].skips == passed


@pytest.mark.parametrize("y_m", [-3.2e-3, 3.2e-3])
def test_a_body_that_bends_round_the_corner_of_the_exit_has_not_escaped(y_m):
    """Its centroid leaves the circle beside the passage while the head goes on and withdraws."""
    path = Path().along(1.0, 0.2, ALONG_WALL, 30)
    for x_p_m in (1e-3, 3e-3, 5.15e-3, 5.8e-3, 3e-3):
        path.into_exit(x_p_m, 5)
        path.centroid[-1][:] = [np.sqrt((R + 0.1e-3) ** 2 - y_m**2), y_m]
    events, _ = path.along(0.2, 1.0, ALONG_WALL, 30).events()
    (attempt,) = of(Attempt, events)
    assert (attempt.success, attempt.complete) == (False, True)
    assert attempt.penetration_m == pytest.approx(5.8e-3, abs=1e-5)


def test_a_hop_that_ends_in_the_exit_or_never_ends_is_no_skip():
    over = Path().along(-1.0, -0.3, ALONG_WALL, 40).along(-0.3, 0.3, DEEP, 20)
    assert of(Visit, over.events()[0])[0].skips == 0, "it is not known to come back to the wall"
    into = Path().along(-1.0, -0.3, ALONG_WALL, 40).along(-0.3, 0.2, DEEP, 20)
    into.into_exit(1e-3, 5).along(0.2, 0.4, ALONG_WALL, 20)
    _, found = into.events()
    assert found["n_s"].n == 0, "it entered"


@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(0.01, 0.5), st.sampled_from([-1.0, 1.0]))
def test_exits_passed_are_counted_alike_in_the_mirror_and_backwards(before, end, half_arc, sign):
    passed = exits_passed(before, end, half_arc)
    assert exits_passed(sign * end, sign * before, half_arc) == passed
    low, high = min(before, end), max(before, end)
    whole = [k for k in range(-9, 10) if low + half_arc <= 2 * np.pi * k <= high - half_arc]
    assert passed == len(whole)


@pytest.mark.parametrize("lost_frames", [0, 30], ids=["seen", "lost"])
@pytest.mark.parametrize(("depth_m", "complete"), [(DEEP, True), (ALONG_WALL, False)])
def test_a_hop_into_the_exit_has_its_length_and_a_slide_would_have_gone_on(
    depth_m, complete, lost_frames
):
    path = Path().along(-2.0, -1.5, ALONG_WALL, 20).along(-1.5, -1.0, DEEP, 20)
    path.along(-1.0, -0.6, ALONG_WALL, 20).along(-0.6, 0.0, depth_m, 20)
    path.lose(lost_frames).into_exit(1e-3, 5).along(0.2, 0.4, DEEP, 10)
    episodes = of(Episode, path.events()[0])
    at_exit = next(e for e in episodes if e.end_ns == 80 * NS // RATE_HZ - NS // RATE_HZ)
    assert at_exit.complete is (complete and not lost_frames)
    assert at_exit.distance_m == pytest.approx((0.6 if depth_m == DEEP else 1.0) * R, rel=0.05)


def test_turning_back_before_the_exit_is_no_skip():
    path = Path().along(-2.0, -1.0, ALONG_WALL, 20).along(-1.0, 0.01, DEEP, 40)
    path.along(0.01, -1.0, DEEP, 40).along(-1.0, -2.0, ALONG_WALL, 20)
    assert of(Visit, path.events()[0])[0].skips == 0


def test_what_the_head_did_while_it_was_lost_is_no_skip():
    path = Path().along(-1.0, -0.5, ALONG_WALL, 40).along(-0.5, -0.3, DEEP, 5).lose(30)
    path.along(0.3, 0.5, DEEP, 5).along(0.5, 1.0, ALONG_WALL, 40)
    assert of(Visit, path.events()[0])[0].skips == 0


def test_a_visit_whose_start_was_not_seen_is_incomplete():
    path = Path().along(1.0, 0.2, ALONG_WALL, 30).into_exit(8e-3, 5, body_follows=True).lose(30)
    path.along(1.3, 0.3, ALONG_WALL, 40, "chamber_b").into_exit(1e-3, 4, "chamber_b")
    first, second = of(Visit, path.events()[0])
    assert (first.complete, second.complete) == (False, False)
    assert second.tau_h_s == pytest.approx(40 / RATE_HZ)


def test_skips_after_a_withdrawal_count_for_the_trial():
    path = Path().along(1.0, 0.2, ALONG_WALL, 300).into_exit(1e-3, 5)
    path.along(-0.3, -0.5, ALONG_WALL, 10).along(-0.5, 0.5, DEEP, 20)
    path.along(0.6, 0.8, ALONG_WALL, 10)
    events, found = path.events()
    assert of(Visit, events)[0].skips == 0
    assert found["n_s"].n == 1
    assert found["n_s"].low < found["n_s"].value < found["n_s"].high


@pytest.mark.parametrize(
    ("y_m", "step_m", "touched"),
    [
        (0.0, 1e-4, False),
        (0.0, 9e-4, None),
        (0.45e-3, 1e-4, True),
        (-0.45e-3, 9e-4, True),
        (0.5e-3 - THRESHOLD + 5e-6, 1e-5, None),
        (0.5e-3 - THRESHOLD - 5e-6, 1e-5, None),
    ],
    ids=["slow", "fast", "at the wall", "at the wall and fast", "by a hair", "not by a hair"],
)
def test_contact_with_the_walls_of_the_passage_is_told_where_it_is_known(y_m, step_m, touched):
    """A fast head may touch between two frames; what is less than half a pixel says nothing."""
    path = Path().along(1.0, 0.2, ALONG_WALL, 30).in_and_out(1.5e-3, y_m, step_m)
    (attempt,) = of(Attempt, path.along(0.3, 1.0, DEEP, 30).events()[0])
    assert attempt.wall_contact is touched


@pytest.mark.parametrize(("rate_hz", "touched"), [(30, False), (10, None)])
def test_a_head_that_sways_from_frame_to_frame_may_touch_between_frames_that_are_far_apart(
    rate_hz, touched
):
    """In truth such heads touched in a tenth of the attempts of 10 frames/s that were told not."""
    exit_, attempts = ExitCorridor.of(GEOMETRY.chambers[0], 1.5e-3), Attempts(0.3)
    for row, step in enumerate([*range(-2, 5), *range(5, -3, -1)]):
        head = (exit_.mouth_x_m + 1e-4 * step, 2.9e-4 * (row % 2))
        attempt = attempts.push(
            "chamber_a", exit_, round(row * NS / rate_hz), head, (0.0, 0.0), 0.02, THRESHOLD,
            error_m=1.25e-5, in_passage=False,
        )  # fmt: skip
    assert attempt.wall_contact is touched


def test_a_head_that_is_lost_for_a_moment_may_have_touched():
    path = Path().in_and_out(1.5e-3)
    assert of(Attempt, path.events()[0])[0].wall_contact is False
    path.head[12] = np.full((1, 2), np.nan)
    assert of(Attempt, path.events()[0])[0].wall_contact is False, "a frame is not long enough"
    for row in range(12, 18):
        path.head[row] = np.full((1, 2), np.nan)
    (attempt,) = of(Attempt, path.events()[0])
    assert (attempt.complete, attempt.wall_contact) == (True, None)


@pytest.mark.parametrize("phase", [StrokePhase.ELONGATION, StrokePhase.CONTRACTION])
def test_the_phase_of_the_stroke_is_read_off_the_length_where_the_head_turns_back(phase):
    path = Path().along(1.0, 0.2, ALONG_WALL, 30)
    for step in range(6):
        path.into_exit(0.2e-3 * (step + 1), 1)
    path.into_exit(0.5e-3, 5).along(0.3, 1.0, DEEP, 30)
    turn_s = 35 / RATE_HZ
    sign = 1 if phase is StrokePhase.ELONGATION else -1

    def length(t):
        return 0.02 + sign * 1e-3 * np.sin(2 * np.pi / 1.2 * (t - turn_s + 0.15))

    (attempt,) = of(Attempt, path.events(length)[0])
    assert attempt.stroke_phase is phase
    (attempt,) = of(Attempt, path.events()[0])
    assert attempt.stroke_phase is StrokePhase.UNKNOWN, (
        "a length that does not change tells nothing"
    )


def test_an_attempt_in_which_the_head_is_lost_is_undecided():
    path = Path().along(1.0, 0.2, ALONG_WALL, 30).into_exit(1e-3, 5).lose(40)
    events, found = path.along(0.2, 1.0, ALONG_WALL, 30).events()
    (attempt,) = of(Attempt, events)
    assert not attempt.complete
    assert found["success"].n == 0


def test_a_head_that_rests_on_the_circle_does_not_enter_again_and_again():
    path = Path().along(1.0, 0.2, ALONG_WALL, 30).into_exit(1e-3, 3)
    for _ in range(10):
        path.along(0.0, 0.0, -1e-5, 2).along(0.0, 0.0, 1e-5, 2)
    events, _ = path.along(0.0, 0.0, DEEP, 5).events()
    assert len(of(Attempt, events)) == 1


def test_success_and_beta_need_enough_attempts_and_then_have_intervals():
    rng = np.random.default_rng(5)
    path = Path()
    for depth in 2e-5 + rng.exponential(2e-3, 60):  # beyond the circle, not only the mouth
        path.along(0.5, 0.2, ALONG_WALL, 4).in_and_out(depth)
        path.along(0.0, 0.5, DEEP, 4)
    _, found = path.events()
    assert found["success"].value == 0.0
    assert found["success"].low == 0.0
    assert found["success"].n == 60
    assert found["beta"].low < 0.5 < found["beta"].high
    assert found["const"].low <= 0.0 <= found["const"].value < 0.05
    assert found["alpha"].low < 0.5 < found["alpha"].high
    assert found["failures_without_contact"].value == 1.0
    assert found["failures_of_unknown_phase"].value == 1.0, "the length does not change"
    assert found["beta"].paper == 0.50, "W = 1 mm"
    assert found["tau_h"].value is None
    assert "1 finding" in found["tau_h"].why
