"""A film that gives no poses for one reason is told what to try; one that gives them is not."""

from functools import partial
from itertools import islice
from pathlib import Path

import failing_films as films
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage

from worm_model.simulator import scenes
from worm_model.simulator.take import Take
from worm_msgs_py.contract.status import Status
from worm_tracker.detection.polarity import Polarity
from worm_tracker.failure_advice import FailureAdvice
from worm_tracker.parameters import TrackerParameters
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.image_decoder import PictureDecoder
from worm_tracker.tracker import Tracker

LARVA = Path(__file__).parents[2] / "bags" / "larva"

NO_CHAMBER = TrackerParameters(no_chamber=True)
BRIGHT = TrackerParameters(no_chamber=True, polarity=Polarity.BRIGHT)
ELSEWHERE = TrackerParameters(centre_u_px=100.0, centre_v_px=235.0, radius_px=22.0)


def tracked(film, parameters):
    tracker = Tracker(parameters)
    for picture, stamp_ns in film:
        tracker.push(picture, stamp_ns)
    tracker.finish()
    assert sum(tracker.statuses.values()) == films.FRAMES
    return tracker


def without_pose(tracker):
    return sum(n for status, n in tracker.statuses.items() if not status.has_pose)


@pytest.mark.parametrize(
    ("film", "parameters", "words"),
    [
        pytest.param(films.bright_on_dark, NO_CHAMBER, "--polarity bright", id="bright worm"),
        pytest.param(films.seen_well, BRIGHT, "--polarity dark", id="dark worm"),
        pytest.param(films.overexposed, NO_CHAMBER, "overexposed", id="overexposed"),
        pytest.param(films.barely_overexposed, NO_CHAMBER, "lower the exposure", id="some glare"),
        pytest.param(films.underexposed, NO_CHAMBER, "nearly black", id="underexposed"),
        pytest.param(films.six_worms, NO_CHAMBER, "several objects of one size", id="six worms"),
        pytest.param(films.in_a_well, NO_CHAMBER, "leave out --no-chamber", id="a rim"),
        pytest.param(films.in_an_open_well, NO_CHAMBER, "--circle-px 161 158", id="a broken rim"),
        pytest.param(films.in_a_well, ELSEWHERE, "--circle-px 161 158", id="circle elsewhere"),
        pytest.param(films.faint, NO_CHAMBER, "where a picture is blurred", id="thin and faint"),
        pytest.param(films.dithered, NO_CHAMBER, "where a picture is blurred", id="dithered"),
    ],
)
def test_what_to_try_is_the_cure_of_what_is_wrong(film, parameters, words):
    tracker = tracked(films.pictures(film), parameters)
    assert words in tracker.advice
    assert "\n" not in tracker.advice
    believed = 2 * without_pose(tracker) <= films.FRAMES
    assert tracker.advice.startswith("the poses are no worm's: ") == believed


@pytest.mark.parametrize(
    ("film", "cured"),
    [
        pytest.param(films.bright_on_dark, BRIGHT, id="polarity"),
        pytest.param(films.in_a_well, TrackerParameters(), id="rim"),
        pytest.param(
            films.in_a_well,
            TrackerParameters(centre_u_px=161.0, centre_v_px=158.0, radius_px=122.0),
            id="circle",
        ),
    ],
)
def test_the_cure_helps(film, cured):
    tracker = tracked(films.pictures(film), cured)
    assert without_pose(tracker) < films.FRAMES / 4
    assert tracker.advice == ""


@pytest.mark.parametrize(
    "scene", ["glare", "debris", "bubbles", "reflection", "hand", "coil", "there_and_back"]
)
def test_a_scene_in_which_most_frames_are_tracked_is_told_nothing(scene):
    take = Take(px_per_mm=20.0, frames=films.FRAMES)
    film = ((frame.picture, frame.stamp_ns) for frame in getattr(scenes, scene)(take))
    tracker = tracked(film, TrackerParameters())
    if 2 * without_pose(tracker) <= films.FRAMES:
        assert tracker.advice == ""
    else:
        assert "have no pose: " in tracker.advice
    assert "polarity" not in tracker.advice


def test_one_real_larva_in_its_dish_is_not_told_to_be_several_worms():
    decoder, film = PictureDecoder(), []
    with BagPictures(LARVA) as pictures:
        for picture in islice(pictures, films.FRAMES):
            image = decoder.decode(deserialize_message(picture.raw, CompressedImage))
            film.append((image, picture.stamp_ns))
    advice = tracked(film, NO_CHAMBER).advice
    assert advice
    assert "several" not in advice


@pytest.mark.parametrize("shape", [(16, 20000), (20000, 16), (16, 16)])
def test_a_strip_of_a_picture_is_told_what_to_try(shape):
    empty = np.random.default_rng(0).integers(195, 206, shape).astype(np.uint8)
    film = [(empty, k * 33_000_000) for k in range(films.FRAMES)]
    assert "nothing stands out" in tracked(film, NO_CHAMBER).advice


def test_half_of_the_frames_is_not_most():
    advice = FailureAdvice(NO_CHAMBER)
    assert advice.sentence({}) == ""
    assert advice.sentence({Status.TRACKED: 5, Status.NO_WORM: 5}) == ""
    assert "6 of 11 frames have no pose: nothing" in advice.sentence(
        {Status.TRACKED: 5, Status.NO_WORM: 6}
    )
    two_reasons = {Status.TRACKED: 4, Status.NO_WORM: 4, Status.TOO_LARGE: 4}
    assert advice.sentence(two_reasons) == ""


@pytest.mark.parametrize("status", [status for status in Status if not status.has_pose])
def test_every_status_without_a_pose_has_something_to_try(status):
    assert FailureAdvice(NO_CHAMBER).sentence({status: 3}).startswith("3 of 3 frames have no pose")


def test_no_picture_is_weighed_up_before_the_advice_is_asked_for():
    advice = FailureAdvice(NO_CHAMBER)
    weighed = []
    advice._cause = partial(lambda look: weighed.append(look))
    picture = np.full((64, 64), 5, np.uint8)
    for _ in range(40):
        advice.see(picture, None, Status.NO_WORM, None)
    assert not weighed
    picture[:] = 200  # a caller may use its array again
    assert "nothing stands out" in advice.sentence({Status.NO_WORM: 40})
    assert len(weighed) == len(advice._looks)
    assert all((look.picture == 5).all() for look in weighed)


def test_looks_are_few_however_long_the_film_is():
    advice = FailureAdvice(NO_CHAMBER)
    picture = np.full((64, 64), 5, np.uint8)
    looked = []
    advice._look = partial(lambda *seen: looked.append(seen))
    for _ in range(20_000):
        advice.see(picture, None, Status.NO_WORM, None)
    assert len(looked) < 120
