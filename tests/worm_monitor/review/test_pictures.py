"""Each frame is shown with the picture of its own stamp, or with none."""

from contextlib import ExitStack, closing
from dataclasses import replace

import cv2
import numpy as np
import pytest
from picture_bags import PERIOD_NS, START_NS, numbered_picture, stamps, write_bag
from report_trial import record, states
from reviewed_trials import change_summary

from worm_monitor.review.pictures import find_pictures as find_pictures_of
from worm_monitor.review.trial import read_reviewed_trial
from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.frame_pictures import frame_picture_path

COUNT = 40


@pytest.fixture
def find_pictures():
    """Find pictures, and let go of them at the end."""
    with ExitStack() as stack:
        yield lambda *of: stack.enter_context(closing(find_pictures_of(*of)))


def trial_of(directory, first=0, count=COUNT, source=None):
    """Results whose frames have the stamps of a bag's pictures from the first on."""
    stamped = [
        (replace(state, stamp_ns=stamp_ns), midline)
        for (state, midline), stamp_ns in zip(
            states(count / 12.0, 12.0), stamps(count, START_NS + first * PERIOD_NS), strict=True
        )
    ]
    record(directory, stamped)
    told = {"bag": "film", "topic": "image_raw", "start_offset_s": first * PERIOD_NS / 1e9}
    change_summary(directory, lambda s: s["provenance"].update(source=told | (source or {})))
    return read_reviewed_trial(directory)


def shown_number(pictures, row):
    """Return which of the numbered pictures a frame is shown with."""
    jpeg, scale, why_blank = pictures.jpeg(row)
    assert (scale, why_blank) == (1.0, "")
    seen = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE).astype(float)
    apart = [np.abs(seen - numbered_picture(number)).mean() for number in range(COUNT)]
    return int(np.argmin(apart))


def test_a_frame_is_shown_with_its_own_picture_in_whatever_order_one_asks(find_pictures, tmp_path):
    trial = trial_of(tmp_path / "out")
    pictures = find_pictures(trial, write_bag(tmp_path / "mine", COUNT))
    for row in (0, COUNT - 1, 7, 8, 7, 20):
        assert shown_number(pictures, row) == row


def test_a_trial_that_begins_later_in_its_bag_has_the_later_pictures(find_pictures, tmp_path):
    trial = trial_of(tmp_path / "out", first=11, count=20)
    pictures = find_pictures(trial, write_bag(tmp_path / "mine", COUNT))
    assert [shown_number(pictures, row) for row in (0, 19)] == [11, 30]


@pytest.mark.parametrize("place", ["film", "bags/film", "results/film"])
def test_the_bag_that_the_results_name_is_found_around_them(
    find_pictures, tmp_path, place, monkeypatch
):
    trial = trial_of(tmp_path / "results" / "out")
    (tmp_path / place).parent.mkdir(exist_ok=True)
    write_bag(tmp_path / place, COUNT)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert find_pictures(trial, None).bag.resolve() == tmp_path / place


def test_a_bag_of_that_name_with_other_stamps_is_not_taken(find_pictures, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trial = trial_of(tmp_path / "out", first=COUNT)
    other = write_bag(tmp_path / "film", COUNT)
    pictures = find_pictures(trial, None)
    assert pictures.bag is None
    assert "--bag" in pictures.jpeg(3)[2]
    with pytest.raises(BadInput, match="is not the bag of"):
        find_pictures(trial, other)


def test_a_bag_that_begins_at_the_same_moment_and_ends_earlier_is_not_taken(
    find_pictures, tmp_path
):
    """As films do whose stamps begin with zero; but a record may end before its live trial."""
    other = write_bag(tmp_path / "other", COUNT - 1)
    replayed = trial_of(tmp_path / "replayed", source={"sha256": "0" * 64})
    with pytest.raises(BadInput, match="other: is not the bag of"):
        find_pictures(replayed, other)
    pictures = find_pictures(trial_of(tmp_path / "live"), other)
    assert shown_number(pictures, 7) == 7
    assert "no picture" in pictures.jpeg(COUNT - 1)[2]


def test_a_name_that_leads_elsewhere_is_not_followed(find_pictures, tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    monkeypatch.chdir(tmp_path / "deep")
    write_bag(tmp_path / "film", COUNT)
    trial = trial_of(tmp_path / "deep" / "a" / "b" / "out", source={"bag": "../film"})
    assert find_pictures(trial, None).bag is None


def test_the_results_own_bag_may_hold_the_pictures(find_pictures, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trial = trial_of(tmp_path / "out")
    bag = write_bag(tmp_path / "out" / "bag", COUNT)
    pictures = find_pictures(trial, None)
    assert pictures.bag == bag
    assert shown_number(pictures, 5) == 5


def test_without_a_bag_the_picture_of_the_report_is_shown_where_it_is_of_that_frame(
    find_pictures, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    trial = trial_of(tmp_path / "out")
    cv2.imwrite(str(frame_picture_path(trial.directory, 6)), numbered_picture(6))
    pictures = find_pictures(trial, None)
    assert shown_number(pictures, 6) == 6
    assert "--bag" in pictures.jpeg(7)[2]


def test_a_bag_that_is_none_is_refused_in_a_line(find_pictures, tmp_path):
    trial = trial_of(tmp_path / "out")
    with pytest.raises(BadInput, match="nowhere"):
        find_pictures(trial, tmp_path / "nowhere")
    (tmp_path / "text.mcap").write_text("no bag")
    with pytest.raises(BadInput, match=r"text\.mcap"):
        find_pictures(trial, tmp_path / "text.mcap")
