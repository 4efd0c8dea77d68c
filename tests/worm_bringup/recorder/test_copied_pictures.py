"""Pictures are copied byte for byte, under the camera's name, each for its own frame."""

import pytest
from picture_bags import COMPRESSED, IMAGE, compressed, image, numbered_picture, stamps, write_bag

from worm_bringup.recorder.copied_pictures import CopiedPictures
from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.serialized_images import read_picture


@pytest.mark.parametrize(
    ("make", "kind", "topic"),
    [(image, IMAGE, topics.IMAGE), (compressed, COMPRESSED, topics.IMAGE_COMPRESSED)],
)
def test_what_is_copied_is_what_was_recorded(tmp_path, make, kind, topic):
    pictures = CopiedPictures({"bag": str(write_bag(tmp_path / "bag", 5, make=make))})
    assert (pictures.message_type, pictures.topic) == (kind, topic)
    for number, stamp_ns in enumerate(stamps(5)):
        fields = read_picture(pictures.next_picture(stamp_ns), kind)
        assert bytes(fields.data) == bytes(make(numbered_picture(number), stamp_ns).data)
    pictures.close()


def test_a_loop_goes_round(tmp_path):
    pictures = CopiedPictures({"bag": str(write_bag(tmp_path / "bag", 2)), "loop": True})
    first = [pictures.next_picture(stamp_ns) for stamp_ns in stamps(2)]
    again = [pictures.next_picture(stamp_ns) for stamp_ns in stamps(4)[2:]]
    assert [bytes(read_picture(raw, IMAGE).data) for raw in first] == [
        bytes(read_picture(raw, IMAGE).data) for raw in again
    ]
    pictures.close()


def test_a_bag_that_was_changed_meanwhile_is_refused(tmp_path):
    pictures = CopiedPictures({"bag": str(write_bag(tmp_path / "bag", 3))})
    with pytest.raises(BadInput, match="changed while it was replayed"):
        pictures.next_picture(stamps(2)[1])
    pictures.close()
