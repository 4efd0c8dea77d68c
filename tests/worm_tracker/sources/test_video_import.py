"""What is imported is what the film holds: every picture, in order, at its time."""

import cv2
import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from worm_msgs_py.errors import BadInput
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE, PictureDecoder
from worm_tracker.sources.video_import import import_film, open_film

TYPES = get_typestore(Stores.ROS2_JAZZY)


def scene(count, dtype=np.uint8):
    """Pictures of smooth noise, each different from the others."""
    rng = np.random.default_rng(5)
    top = np.iinfo(dtype).max // 2
    return [
        cv2.GaussianBlur(rng.random((48, 64)) * top, (0, 0), 3).astype(dtype) for _ in range(count)
    ]


def video(path, pictures, fps):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), fps, (64, 48))
    assert writer.isOpened()
    for picture in pictures:
        writer.write(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


def read(bag):
    decoder = PictureDecoder()
    with BagPictures(bag) as pictures:
        messages = ((p.stamp_ns, TYPES.deserialize_cdr(p.raw, COMPRESSED_TYPE)) for p in pictures)
        return [(stamp_ns, decoder.decode(message)) for stamp_ns, message in messages]


def folder(path, pictures, name="{}.png"):
    path.mkdir()
    for number, picture in enumerate(pictures):
        cv2.imwrite(str(path / name.format(number)), picture)
    return path


def test_a_video_keeps_its_pictures_and_its_times(tmp_path):
    source = video(tmp_path / "film.avi", scene(9), fps=12.5)
    done = import_film(open_film(source), tmp_path / "bag")
    assert (done.frames, done.duration_s) == (9, pytest.approx(8 / 12.5))
    capture = cv2.VideoCapture(str(source))
    for number, (stamp_ns, picture) in enumerate(read(tmp_path / "bag")):
        _, true = capture.read()
        assert stamp_ns == pytest.approx(number * 80_000_000, abs=1_000_000)
        np.testing.assert_array_equal(picture, cv2.cvtColor(true, cv2.COLOR_BGR2GRAY))


def test_a_folder_is_read_in_the_order_of_its_numbers(tmp_path):
    pictures = scene(12)  # 10.png and 11.png come after 9.png
    source = folder(tmp_path / "stills", pictures)
    import_film(open_film(source), tmp_path / "bag", fps=4.0, start_ns=10**18)
    found = read(tmp_path / "bag")
    assert [stamp for stamp, _ in found] == [10**18 + k * 250_000_000 for k in range(12)]
    np.testing.assert_array_equal([picture for _, picture in found], pictures)


def test_a_stack_of_sixteen_bits_keeps_its_depth(tmp_path):
    pictures = [picture // 8 for picture in scene(3, np.uint16)]  # twelve bits of light
    assert cv2.imwritemulti(str(tmp_path / "stack.tif"), pictures)
    import_film(open_film(tmp_path / "stack.tif"), tmp_path / "bag", fps=1.0)
    for (_, found), true in zip(read(tmp_path / "bag"), pictures, strict=True):
        np.testing.assert_array_equal(found, true >> 4)


def test_the_same_film_gives_the_same_bytes(tmp_path):
    source = folder(tmp_path / "stills", scene(4))
    bags = [tmp_path / name / "bag" for name in "ab"]
    for bag in bags:
        bag.parent.mkdir()
        import_film(open_film(source), bag, fps=4.0)
    files = [{file.name: file.read_bytes() for file in bag.iterdir()} for bag in bags]
    assert files[0] == files[1]


@pytest.mark.parametrize("quality", [None, 90])
def test_jpeg_is_smaller_and_near(tmp_path, quality):
    pictures = scene(3)
    source = folder(tmp_path / "stills", pictures)
    import_film(open_film(source), tmp_path / "bag", fps=1.0, jpeg_quality=quality)
    off = [
        np.abs(found.astype(int) - true).max()
        for (_, found), true in zip(read(tmp_path / "bag"), pictures, strict=True)
    ]
    assert max(off) == 0 if quality is None else 0 < max(off) < 12


def nothing_there(tmp_path):
    return tmp_path / "missing.avi", {}


def no_video(tmp_path):
    (tmp_path / "notes.txt").write_text("no film")
    return tmp_path / "notes.txt", {}


def empty_folder(tmp_path):
    (tmp_path / "empty").mkdir()
    return tmp_path / "empty", {"fps": 1.0}


def no_rate(tmp_path):
    return folder(tmp_path / "stills", scene(2)), {}


def two_sizes(tmp_path):
    return folder(tmp_path / "stills", [*scene(2), scene(1)[0][:20]]), {"fps": 1.0}


def damaged_still(tmp_path):
    source = folder(tmp_path / "stills", scene(3))
    (source / "1.png").write_bytes(b"\x89PNG\r\n")
    return source, {"fps": 1.0}


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (nothing_there, "no such file"),
        (no_video, "cannot be read as a video"),
        (empty_folder, "holds no pictures"),
        (no_rate, "--fps"),
        (two_sizes, "one size"),
        (damaged_still, "1.png"),
    ],
)
def test_what_cannot_be_imported_leaves_nothing_behind(tmp_path, make, says):
    source, options = make(tmp_path)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(BadInput, match=says) as caught:
        import_film(open_film(source), tmp_path / "bag", **options)
    assert "\n" not in str(caught.value)
    assert str(source.name) in str(caught.value)
    assert sorted(tmp_path.iterdir()) == before


def test_a_bag_that_is_there_is_not_overwritten(tmp_path):
    source = folder(tmp_path / "stills", scene(2))
    (tmp_path / "bag").mkdir()
    with pytest.raises(BadInput, match="exists already"):
        import_film(open_film(source), tmp_path / "bag", fps=1.0)
