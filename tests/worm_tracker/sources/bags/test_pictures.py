"""A plain loop over a bag gets every picture that its replay sends, in the same order."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from picture_bags import START_NS, compressed, image, number_of, numbered_picture, stamps
from picture_bags import write_messages as write

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.pictures import pictures_of_bag
from worm_tracker.tracker import Tracker

BAGS = Path(__file__).parents[4] / "bags"


@pytest.mark.parametrize("kind", [image, compressed])
def test_every_picture_comes_once_grey_and_with_its_stamp(kind, tmp_path):
    times = stamps(12)
    messages = [
        ("/image_raw", at, kind(numbered_picture(number), at)) for number, at in enumerate(times)
    ]
    found = list(pictures_of_bag(write(tmp_path / "bag", messages)))
    assert [at for _, at in found] == times
    assert [number_of(picture) for picture, _ in found] == list(range(12))
    assert {(picture.dtype, picture.shape) for picture, _ in found} == {
        (np.dtype(np.uint8), (48, 64))
    }


def test_a_message_that_cannot_be_read_is_an_empty_picture_and_a_frame(tmp_path):
    messages = [
        ("/image_raw", at, image(numbered_picture(number), at))
        for number, at in enumerate(stamps(12))
    ]
    messages[5][2].height = 4000  # more rows than bytes
    found = list(pictures_of_bag(write(tmp_path / "bag", messages)))
    assert [picture.size for picture, _ in found] == [3072] * 5 + [0] + [3072] * 6


def test_a_part_of_a_bag_and_a_topic_can_be_chosen(tmp_path):
    messages = [
        (topic, at, image(numbered_picture(number), at))
        for number, at in enumerate(stamps(20))
        for topic in ("/left", "/right")
    ]
    bag = write(tmp_path / "bag", messages)
    with pytest.raises(BadInput, match="several topics"):
        next(pictures_of_bag(bag))
    part = pictures_of_bag(bag, "left", start_offset_s=0.2, playback_duration_s=0.25)
    assert [at for _, at in part] == [at for at in stamps(20) if 2e8 <= at - START_NS < 4.5e8]


def test_the_tracker_takes_what_it_gives():
    tracker, given = Tracker(), []
    for picture, stamp_ns in islice(pictures_of_bag(str(BAGS / "larva")), 3):
        given += tracker.push(picture, stamp_ns)
    given += tracker.finish()
    assert [frame.state.status.has_pose for frame in given] == [True] * 3
