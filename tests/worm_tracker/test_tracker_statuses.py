"""Each status occurs, is explained, and has its picture."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from worm_msgs_py import Status

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def drawing():
    spec = importlib.util.spec_from_file_location("make_statuses", DOCS / "make_statuses.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def films(drawing):
    return drawing.films()


@pytest.mark.parametrize("status", list(Status), ids=lambda status: status.label)
def test_a_film_has_a_frame_with_this_status(status, drawing, films):
    _, tracked = drawing.first_of(status, films[status])
    has_head = np.isfinite(tracked.state.head.u_px)
    assert has_head == status.has_pose
    assert (len(tracked.midline.u_px) > 0) == (has_head or status is Status.END_HIDDEN)
    in_part = status in (Status.END_HIDDEN, Status.LOOP_IN_DOUBT)
    assert np.isfinite(tracked.midline.u_px).all() == (not in_part)


def test_two_of_the_worms_size_do_not_matter_while_it_is_followed(drawing, films):
    *_, last = films[Status.TRACKED]
    *_, pair = films[Status.AMBIGUOUS]
    _, tracked = drawing.first_of(Status.TRACKED, [*films[Status.TRACKED], last, pair])
    assert tracked.state.frame == len(films[Status.TRACKED]) + 1


@pytest.mark.parametrize("status", list(Status), ids=lambda status: status.label)
def test_the_documentation_explains_and_shows_it(status):
    (row,) = [
        line
        for line in (DOCS / "statuses.md").read_text().splitlines()
        if line.startswith(f"| `{status.label}` | {int(status)} |")
    ]
    assert status.reason in row
    assert (DOCS / "statuses" / f"{status.label}.png").is_file()
