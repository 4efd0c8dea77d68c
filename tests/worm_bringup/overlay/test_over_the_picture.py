"""A result bag with pictures, read by other libraries, shows worm and wall where they truly are.

Nothing but camera_info and tf takes metres to pixels here, and the truth is the simulator's.
"""

from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from forked_commands import worm
from other_reader import View, cloud, distances_px, messages_by_topic, picture, stamp_ns
from picture_bags import image, write_messages

from worm_model.simulator.film import FilmFrame, write_film
from worm_model.simulator.rig import write_truth
from worm_model.simulator.scenes import Take, at_the_wall, bumped_camera, there_and_back
from worm_msgs_py.paper import RADIUS_MM

pytestmark = pytest.mark.xdist_group("over the picture")  # four replays, shared by all of them
TAKE = Take(px_per_mm=20.0, frames=24)
MM = 1e-3


def replay(bag, out, *options):
    worm("replay", bag, "--out", out, *options).check_returncode()


def mirrored(film):
    """The film as a camera with a mirror before it takes it."""
    for frame in film:
        last = frame.picture.shape[1] - 1
        truth = replace(
            frame.truth,
            midline_u_px=[last - u for u in frame.truth.midline_u_px],
            circle_u_px=last - frame.truth.circle_u_px,
        )
        yield FilmFrame(frame.stamp_ns, np.ascontiguousarray(frame.picture[:, ::-1]), truth)


def write_bare(path, film):
    """Write a film as bare pixels of a driver that has its own name for the camera."""
    frames = list(film)
    messages = [("/left/image_raw", f.stamp_ns, image(f.picture, f.stamp_ns)) for f in frames]
    for _, _, message in messages:
        message.header.frame_id = "left_cam"
    write_messages(path, messages)
    write_truth([frame.truth for frame in frames], path.with_name(path.name + "_truth.parquet"))


FILMS = {
    "one chamber": lambda path: write_film(path, at_the_wall(TAKE)),
    "in a mirror": lambda path: write_bare(path, mirrored(at_the_wall(TAKE))),
    "both chambers": lambda path: write_film(
        path, there_and_back(replace(TAKE, px_per_mm=40.0, frames=60))
    ),
    "bumped": lambda path: write_film(path, bumped_camera(TAKE)),
}


@pytest.fixture(scope="module", params=FILMS)
def trial(request, tmp_path_factory):
    """What other libraries read of a trial, and the truth of its frames."""
    folder = tmp_path_factory.mktemp("trial")
    FILMS[request.param](folder / "film")
    replay(folder / "film", folder / "out", "--with-pictures")
    truth = pq.read_table(folder / "film_truth.parquet").to_pylist()
    return folder, messages_by_topic(folder / "out"), {row["stamp_ns"]: row for row in truth}


def true_midline(row):
    return np.stack([row["midline_u_px"], row["midline_v_px"]], axis=1)


def test_the_midline_lies_on_the_worm(trial):
    _, found, truth = trial
    view, shown = View(found), 0
    for at_ns, message in found["/worm/midline"]:
        points = cloud(message)
        there = true_midline(truth[at_ns])
        pixels = np.stack([points["u_px"], points["v_px"]], axis=1)
        if not len(pixels) or distances_px(pixels, there).max() > 1.0:
            continue  # the tracker itself is wrong, or says nothing
        metres = np.stack([points[axis] for axis in "xyz"], axis=1)
        seen = view.project(metres, message.header.frame_id, at_ns)
        assert distances_px(seen, there).max() < 1.0
        assert np.hypot(*(seen - pixels).T).max() < 0.01
        shown += 1
    assert shown >= 0.8 * len(truth)


def test_the_wall_lies_on_the_wall(trial):
    _, found, truth = trial
    view = View(found)
    angles = np.linspace(0.0, 2 * np.pi, 90)
    wall = RADIUS_MM * MM * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    for at_ns, row in truth.items():
        u, v = view.project(wall, row["chamber"], at_ns).T
        off = np.hypot(u - row["circle_u_px"], v - row["circle_v_px"]) - row["circle_radius_px"]
        assert np.abs(off).max() < 1.0


def test_there_is_a_picture_for_every_camera_info_and_the_worm_in_it_is_dark(trial):
    _, found, truth = trial
    view = View(found)
    (topic,) = [name for name in found if name.startswith("/image_raw")]
    assert [stamp_ns(message) for _, message in found[topic]] == sorted(truth)
    for (at_ns, message), (_, line) in zip(found[topic], found["/worm/midline"], strict=True):
        assert message.header.frame_id == "camera_optical_frame"
        points, grey = cloud(line), picture(message)
        if not len(points["x"]):
            continue
        metres = np.stack([points[axis] for axis in "xyz"], axis=1)
        u, v = np.rint(view.project(metres, line.header.frame_id, at_ns)).astype(int).T
        inside = (u >= 0) & (u < grey.shape[1]) & (v >= 0) & (v < grey.shape[0])
        assert np.median(grey[v[inside], u[inside]]) < 0.6 * np.median(grey[grey > 100])


def test_annotations_lie_on_the_worm_and_the_wall(trial):
    _, found, truth = trial
    corner = 0.5  # Foxglove counts from the corner of a pixel
    for at_ns, message in found["/worm/annotations"]:
        row = truth[at_ns]
        walls = [circle for circle in message.circles if circle.diameter > 100]
        off = min(
            np.hypot(
                wall.position.x - corner - row["circle_u_px"],
                wall.position.y - corner - row["circle_v_px"],
            )
            for wall in walls
        )
        assert off < 1.0
        body = [line for line in message.points if len(line.points) > 2]
        points = np.array([[p.x - corner, p.y - corner] for line in body for p in line.points])
        assert not len(points) or np.median(distances_px(points, true_midline(row))) < 1.0


def test_it_replays_as_a_whole_to_the_same_tracks(trial):
    folder, _, _ = trial
    replay(folder / "out" / "bag", folder / "again", "--with-pictures")
    for name in ("tracks.parquet", "contacts.parquet", "sums.parquet"):
        assert (folder / "again" / name).read_bytes() == (folder / "out" / name).read_bytes()
    first, second = (messages_by_topic(folder / name) for name in ("out", "again"))
    assert {topic: len(each) for topic, each in first.items()} == {
        topic: len(each) for topic, each in second.items()
    }
