"""What is told of a fold by the way back through it, and by the way there again."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from crossing_loop import CROSSING, LOOP, NODES, TOUCHING, folded
from waiting_frames import LINE, SEEN, WIDTH, coil, midline, queue_of

from worm_msgs_py import Status


def test_of_a_fold_the_way_back_tells_which_way_round_its_loop_was_passed():
    doubted = replace(midline(in_doubt=(30, 90), unresolved=SEEN), status=Status.LOOP_IN_DOUBT)
    queue = queue_of(doubted, midline())
    queue.go_back(lambda opened, detections: iter([replace(midline(), status=Status.FOLDED)]))
    first, _ = queue.finish()
    assert first.state.status is Status.FOLDED
    assert np.isfinite(first.midline.u_px).all()


@pytest.mark.parametrize("frame", [0, 1, 2])
def test_a_loop_that_both_ways_tell_otherwise_is_told_by_neither(frame):
    """Marks tell it in one frame: the way back is wrong in all of them, or the marks are."""
    doubted = replace(TOUCHING, status=Status.LOOP_IN_DOUBT, in_doubt=(LOOP.start, LOOP.stop))
    by_marks = replace(TOUCHING, by_marks=True)
    there = [by_marks if k == frame else doubted for k in range(3)]
    opened = folded(np.linspace([100, 150], [300, 150], NODES), unresolved=None)
    queue = queue_of(*there, replace(opened, status=Status.TRACKED))
    queue.go_back(lambda opened, detections: iter([CROSSING] * 3))
    *fold, _ = queue.finish()
    assert [each.state.status for each in fold] == [Status.LOOP_IN_DOUBT] * 3
    for each in fold:
        assert np.isnan(each.midline.u_px[LOOP]).all()
        assert np.isfinite(each.midline.u_px[[0, -1]]).all()


@pytest.mark.parametrize("hidden", [(0, 5), (5, 0)])
def test_a_body_whose_ends_are_both_seen_is_told_rather_than_one_whose_loops_are(hidden):
    doubted = replace(midline(in_doubt=(30, 90), unresolved=SEEN), status=Status.LOOP_IN_DOUBT)
    elsewhere = LINE + np.array([0.0, WIDTH])
    back = replace(midline(), points=elsewhere, status=Status.END_HIDDEN, occluded=hidden)
    queue = queue_of(doubted, midline())
    queue.go_back(lambda opened, detections: iter([back]))
    assert queue.finish()[0].state.status is Status.LOOP_IN_DOUBT


FOLLOWED = replace(midline(seen_end_sd_px=(0.0, 0.1 * WIDTH)), status=Status.END_HIDDEN)
"""A body that was followed, whose end lies on it."""


@pytest.mark.parametrize(
    ("apart_widths", "doubt", "is_told"),
    [
        pytest.param(0.2, {}, True, id="the same body"),
        pytest.param(0.4, {}, False, id="another one"),
        pytest.param(0.2, {"over_limits": 1.5}, False, id="something is left over"),
        pytest.param(0.2, {"seen_end_sd_px": (0.0, 0.6 * WIDTH)}, False, id="no end is seen"),
        pytest.param(0.2, {"broad_ends": (True, False)}, False, id="an end is bent back"),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("doubted_way", ["there", "back"])
def test_a_body_that_both_ways_through_a_fold_came_to_is_told(
    apart_widths, doubt, is_told, turned, doubted_way
):
    aside = np.array([0.0, apart_widths * WIDTH])
    there, back = FOLLOWED, replace(FOLLOWED, points=LINE + aside)
    there, back = (
        replace(way, **doubt) if name == doubted_way else way
        for name, way in (("there", there), ("back", back))
    )
    back = back.reversed() if turned else back
    queue = queue_of(coil(followed=there), midline())
    queue.go_back(lambda opened, detections: iter([coil(followed=back)]))
    first, _ = queue.finish()
    assert first.state.status is (Status.FOLDED if is_told else Status.COILED)
    if is_told:
        line = np.stack([first.midline.u_px, first.midline.v_px], axis=1)
        assert line == pytest.approx(LINE + aside / 2)


def ring(apart_widths):
    """A body whose two ends are so near to each other."""
    at = np.linspace(0, 2 * np.pi, len(LINE)) - 0.5 * np.pi
    points = 40 + 20 * np.stack([np.cos(at), np.sin(at)], axis=1)
    return points + np.outer(np.linspace(0, apart_widths * WIDTH, len(LINE)), [0.0, -1.0])


@pytest.mark.parametrize(
    ("apart_widths", "sds_widths", "is_told"),
    [
        pytest.param(0.1, (0.1, 0.3), False, id="each may be the other"),
        pytest.param(0.4, (0.3, 0.1), False, id="each may be the other, a little farther apart"),
        pytest.param(0.1, (0.1, 0.15), True, id="both are seen well"),
        pytest.param(0.7, (0.1, 0.3), True, id="far enough apart"),
    ],
)
def test_ends_on_each_other_are_not_told_because_both_ways_have_them_there(
    apart_widths, sds_widths, is_told
):
    """What is seen of one is taken for both, by either way alike."""
    sds_px = (sds_widths[0] * WIDTH, sds_widths[1] * WIDTH)
    body = replace(FOLLOWED, points=ring(apart_widths), seen_end_sd_px=sds_px)
    queue = queue_of(coil(followed=body), replace(midline(), points=ring(1.0)))
    queue.go_back(lambda opened, detections: iter([coil(followed=body)]))
    first, _ = queue.finish()
    assert first.state.status is (Status.FOLDED if is_told else Status.COILED)


IN_DARK = {"overlaps_tell": True, "seen_end_sd_px": (0.0, 0.48 * WIDTH), "over_limits": 2.0}
"""How sure a body may be where overlaps are darker, which show what lies in them."""


@pytest.mark.parametrize(
    ("doubts", "told_doubt"),
    [
        pytest.param(({}, {}), (0, 0), id="nothing in doubt"),
        pytest.param(({"in_doubt": (20, 40)}, {}), (0, 0), id="known by one"),
        pytest.param(({"in_doubt": (20, 40)}, {"in_doubt": (35, 50)}), (20, 50), id="by none"),
        pytest.param(({"in_doubt": (0, len(LINE))}, {"in_doubt": (5, 9)}), None, id="nothing told"),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("in_dark", [False, True])
def test_what_both_ways_came_to_is_told_but_for_loops_that_either_may_pass_wrongly(
    doubts, told_doubt, turned, in_dark
):
    """Both take the straighter way round a loop; the rest of the body is where both have it."""
    looks = IN_DARK if in_dark else {}
    there, back = (replace(FOLLOWED, **looks, **doubt) for doubt in doubts)
    back = back.reversed() if turned else back
    queue = queue_of(coil(followed=there), midline())
    queue.go_back(lambda opened, detections: iter([coil(followed=back)]))
    first, _ = queue.finish()
    if told_doubt is None:
        assert first.state.status is Status.COILED
        return
    assert first.state.status is (Status.FOLDED if told_doubt == (0, 0) else Status.LOOP_IN_DOUBT)
    untold = np.flatnonzero(np.isnan(first.midline.u_px))
    assert untold.tolist() == list(range(*told_doubt))


@pytest.mark.parametrize(
    ("apart_widths", "end_sd_widths", "is_told"),
    [
        pytest.param(0.6, (0.9, 0.45), True, id="one sees the end"),
        pytest.param(0.6, (0.55, 0.55), False, id="neither sees it"),
        pytest.param(0.3, (0.55, 0.55), True, id="neither does, but they are nearer"),
        pytest.param(0.3, (0.65, 0.55), False, id="neither sees it by far"),
        pytest.param(0.8, (0.3, 0.3), False, id="it is elsewhere"),
    ],
)
def test_in_darker_overlaps_one_of_two_ways_has_to_see_an_end(apart_widths, end_sd_widths, is_told):
    there, back = (
        replace(FOLLOWED, overlaps_tell=True, seen_end_sd_px=(0.0, sd * WIDTH))
        for sd in end_sd_widths
    )
    back = replace(back, points=LINE + np.array([0.0, apart_widths * WIDTH]))
    queue = queue_of(coil(followed=there), midline())
    queue.go_back(lambda opened, detections: iter([coil(followed=back)]))
    assert queue.finish()[0].state.status is (Status.FOLDED if is_told else Status.COILED)


@pytest.mark.parametrize(
    ("end_sd_widths", "is_told"),
    [
        pytest.param((0.5, 0.4), True, id="one sees the end"),
        pytest.param((0.45, 0.45), False, id="neither sees it"),
        pytest.param((0.6, 0.4), False, id="the other does not see it by far"),
    ],
)
@pytest.mark.parametrize("by_marks", [(True, False), (False, True)])
def test_where_marks_alone_tell_of_a_loop_both_ways_have_to_see_an_end_better(
    end_sd_widths, is_told, by_marks
):
    there, back = (
        replace(FOLLOWED, overlaps_tell=True, seen_end_sd_px=(0.0, sd * WIDTH), by_marks=marks)
        for sd, marks in zip(end_sd_widths, by_marks, strict=True)
    )
    queue = queue_of(coil(followed=there), midline())
    queue.go_back(lambda opened, detections: iter([coil(followed=back)]))
    assert queue.finish()[0].state.status is (Status.FOLDED if is_told else Status.COILED)


def there_again(entered, coils, told_back):
    """Return what is told of coils where a way back tells the last, and one there all it is asked.

    And how many of them it was asked.
    """
    asked = []

    def propagate(opened, detections):
        asked.append(len(detections))
        tells = replace(midline(), status=Status.FOLDED)
        return iter([tells] * (told_back if len(asked) == 1 else len(detections)))

    queue = queue_of(entered, *coils, midline())
    queue.go_back(propagate)
    return [one.state.status for one in queue.finish()][1:-1], asked[1:]


def test_a_fold_that_was_not_followed_is_entered_again_from_before_it():
    told, asked = there_again(midline(kept=SEEN), [coil()] * 5, told_back=2)
    assert told == [Status.FOLDED] * 5
    assert asked == [3]


@pytest.mark.parametrize(
    ("apart_widths", "back_over", "again_over", "is_told"),
    [
        pytest.param(0.2, 0.0, 0.8, True, id="the same body"),
        pytest.param(3.0, 0.0, 0.2, False, id="another that leaves more over"),
        pytest.param(3.0, 0.9, 0.2, True, id="another that leaves less over"),
        pytest.param(3.0, 0.9, 0.5, False, id="less, but not little"),
        pytest.param(3.0, 1.5, 0.8, True, id="the first does not explain the picture"),
    ],
)
def test_a_hidden_end_is_told_on_the_way_there_by_a_body_that_is_no_worse(
    apart_widths, back_over, again_over, is_told
):
    bent = LINE + np.outer(np.arange(121) < 12, [0.0, apart_widths * WIDTH])
    hides = {"status": Status.END_HIDDEN, "occluded": (12, 0)}
    ways = [
        [coil(followed=replace(midline(over_limits=back_over), points=bent, **hides))],
        [replace(midline(over_limits=again_over), status=Status.FOLDED)],
    ]
    queue = queue_of(midline(kept=SEEN), coil(), midline())
    queue.go_back(lambda opened, detections: iter(ways.pop(0)))
    assert (queue.finish()[1].state.status is Status.FOLDED) is is_told
    assert not ways


@pytest.mark.parametrize(
    ("entered", "coils"),
    [
        pytest.param(coil(), [coil()] * 5, id="no frame before it shows the body"),
        pytest.param(
            replace(midline(kept=SEEN), status=Status.END_HIDDEN, occluded=(9, 0)),
            [coil()] * 5,
            id="nor all of it",
        ),
        pytest.param(
            midline(kept=SEEN), [coil(followed=midline(over_limits=2.0))] * 5, id="it was followed"
        ),
    ],
)
def test_a_fold_is_not_entered_again_in_vain(entered, coils):
    told, asked = there_again(entered, coils, told_back=2)
    assert told == [Status.COILED] * 3 + [Status.FOLDED] * 2
    assert asked == []


def test_a_body_that_was_lost_is_told_where_the_way_back_comes_to_it():
    lost = coil(followed=replace(midline(), status=Status.FOLDED))
    told = [replace(midline(), status=Status.FOLDED)]
    queue = queue_of(midline(), lost, lost, midline())
    queue.go_back(lambda opened, detections: iter(told))
    assert Status.COILED not in {one.state.status for one in queue.finish()}


class Propagate:
    """Tells two frames on the way back and all on the way there: a callable that can be pickled."""

    def __init__(self):
        self.asked = 0

    def __call__(self, opened, detections):
        self.asked += 1
        tells = replace(midline(), status=Status.FOLDED)
        return iter([tells] * (2 if self.asked == 1 else len(detections)))


@pytest.mark.parametrize("steps", range(7))
def test_a_way_back_goes_on_from_where_it_was_pickled(steps):
    queue = queue_of(midline(kept=SEEN), *[coil()] * 5, midline())
    for _ in range(steps):
        queue.go_back(Propagate(), 1)
    queue = pickle.loads(pickle.dumps(queue))
    queue.go_back(Propagate())
    told = [one.state.status for one in queue.finish()]
    assert told == [Status.TRACKED, *[Status.FOLDED] * 5, Status.TRACKED]
