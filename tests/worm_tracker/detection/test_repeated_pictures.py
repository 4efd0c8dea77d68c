"""A film with repeated pictures is told as the film without them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from crawling_worm import SMALL_RIG, crawl, film, wall_path
from hypothesis import given
from hypothesis import strategies as st

from worm_model.simulator.folded_worms import LOOKS, film_worm, read_folded_worms, rig_for
from worm_msgs_py import Status
from worm_tracker.detection.repeated_pictures import RepeatedPictures, RepeatedPicturesSettings
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

WORMS = Path(__file__).parents[3] / "bags" / "source" / "folded_worms.npz"
LENGTH, WIDTH = 110.0, 12.0
FRAME_NS = 40_000_000
MOST = RepeatedPicturesSettings().most_repeats


def repeats_of(pictures):
    repeated = RepeatedPictures(RepeatedPicturesSettings())
    return [repeated.push(picture) for picture in pictures]


def numbered(number):
    return np.full((40, 50), number, np.uint8)


@given(times=st.lists(st.integers(1, MOST + 1), min_size=2, max_size=20))
def test_of_pictures_shown_several_times_each_later_one_is_a_repeat(times):
    pictures = [numbered(k) for k, count in enumerate(times, 1) for _ in range(count)]
    first_of = np.cumsum([0, *times[:-1]])
    is_first = np.isin(np.arange(len(pictures)), first_of)
    is_first[: times[0]] = True  # nothing has moved yet: that may be a worm at rest
    assert repeats_of(pictures) == (~is_first).tolist()


@given(shown=st.integers(1, 40))
def test_a_film_that_stands_still_is_not_repeated(shown):
    assert not any(repeats_of([numbered(7)] * shown))


@given(frozen=st.integers(MOST + 2, 40))
def test_a_film_that_freezes_stands_still_after_a_few_repeats(frozen):
    told = repeats_of([numbered(1), numbered(2), *[numbered(3)] * frozen])
    assert told == [False] * 3 + [True] * MOST + [False] * (frozen - 1 - MOST)


@given(grey=st.integers(1, 40), rows=st.integers(2, 40))
def test_until_it_is_known_what_usually_changes_the_least_change_is_another_picture(grey, rows):
    other = numbered(2)
    other[:rows] += np.uint8(grey)
    assert repeats_of([numbered(1), numbered(2), other]) == [False] * 3


@given(little=st.integers(0, 20), seed=st.integers(0, 9))
def test_what_a_codec_changes_in_a_repeated_picture_is_little_beside_what_is_usual(little, seed):
    rng = np.random.default_rng(seed)
    pictures = list(rng.integers(0, 200, (20, 40, 50)).astype(np.uint8))
    again = pictures[-1].copy()
    again[:: max(1, 31 - little)] += np.uint8(little)
    assert repeats_of([*pictures, again])[-1]
    assert not any(repeats_of(pictures))


def test_noise_of_a_camera_is_what_usually_changes_though_the_worm_rests():
    rng = np.random.default_rng(1)
    moving = film(
        SMALL_RIG, crawl(wall_path(SMALL_RIG, WIDTH), LENGTH, WIDTH, 200 + np.arange(20.0))
    )
    resting = [moving[-1].astype(float) + rng.normal(0, 2.0, moving[-1].shape) for _ in range(20)]
    pictures = [*moving, *(np.clip(np.rint(each), 0, 255).astype(np.uint8) for each in resting)]
    assert not any(repeats_of(pictures))


def test_a_camera_may_write_each_picture_over_the_last_one():
    picture, told = numbered(0), []
    repeated = RepeatedPictures(RepeatedPicturesSettings())
    for number in (1, 2, 3, 3, 4):
        picture[:] = number
        told.append(repeated.push(picture))
    assert told == [False, False, False, True, False]


def told(pictures, stamps_ns, parameters=None):
    tracker, states = Tracker(parameters or TrackerParameters()), []
    for picture, stamp_ns in zip(pictures, stamps_ns, strict=True):
        states += [frame.state for frame in tracker.push(picture, int(stamp_ns))]
        assert tracker.held <= tracker._parameters.hold_back_frames
    return tracker, states + [frame.state for frame in tracker.finish()]


def crawling_film(frames):
    heads = LENGTH + 0.9 * SMALL_RIG.radius_px + 2.5 * np.arange(frames)
    return film(SMALL_RIG, crawl(wall_path(SMALL_RIG, WIDTH), LENGTH, WIDTH, heads))


def folding_film(frames):
    look, worm = LOOKS["darker"], read_folded_worms(WORMS)["4003"]
    worm = replace(worm, midlines_mm=worm.midlines_mm[350 : 350 + frames])
    return [frame.picture for frame, _ in film_worm(rig_for(look, seed=4003), worm, look)]


@pytest.mark.parametrize(
    ("film_of", "frames"), [(crawling_film, 60), (folding_film, 100)], ids=["open", "fold"]
)
def test_all_but_the_repeats_are_told_as_without_them(film_of, frames):
    pictures = film_of(frames)
    shown = [k - (k % 5 == 4) for k in range(len(pictures))]
    stamps = np.arange(len(pictures)) * FRAME_NS
    tracker, states = told([pictures[k] for k in shown], stamps)
    kept = [k for k in range(len(pictures)) if k % 5 < 4]
    _, without = told([pictures[k] for k in kept], stamps[kept])
    assert [state.frame for state in states] == list(range(len(pictures)))
    assert [state.stamp_ns for state in states] == stamps.tolist()
    as_without = [replace(states[k], frame=n) for n, k in enumerate(kept)]
    assert repr(as_without) == repr(without)
    assert {states[k].status for k in range(4, len(pictures), 5)} == {Status.BAD_IMAGE}
    assert sum(state.status.has_pose for state in states) > len(pictures) / 2
    assert tracker.repeated == len(pictures) // 5
    assert "repeat the one before" in tracker.advice


def test_repeats_wait_no_longer_than_frames_may():
    pictures = [picture for picture in crawling_film(30) for _ in range(MOST)]
    stamps = np.arange(len(pictures)) * FRAME_NS // MOST
    _, states = told(pictures, stamps, TrackerParameters(hold_back_frames=7))
    assert [state.frame for state in states] == list(range(len(pictures)))


def test_a_film_of_which_few_pictures_are_repeated_is_told_nothing():
    pictures = crawling_film(40)
    pictures[20] = pictures[19]
    tracker, _ = told(pictures, np.arange(40) * FRAME_NS)
    assert tracker.repeated == 1
    assert tracker.advice == ""
