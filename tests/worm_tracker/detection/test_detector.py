"""The first picture: what of it is the worm, and what the rig."""

from benchmarks.drawn_lines import LINE_LOOKS, light_and_wall, picture_of, true_line_px
from benchmarks.fold_films import WORMS_FILE

from worm_model.simulator.folded_worms import read_folded_worms
from worm_msgs_py import Status
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker


def test_a_worm_that_lies_across_the_mouth_at_first_is_not_joined_to_the_passages_walls():
    """The walls blur the passage's edges: two dark lines, from the mouth to the picture's edge."""
    look, worm = LINE_LOOKS["lines"], read_folded_worms(WORMS_FILE)["4003"]
    light, wall = light_and_wall(look)
    tracker, given = Tracker(TrackerParameters()), []
    for frame in range(4):
        line, widths = true_line_px(worm, frame, look)
        picture = picture_of(line, widths, look, light, wall, seed=frame)
        given += tracker.push(picture, frame * 40_000_000)
    given += tracker.finish()
    assert Status.TOUCHES_BORDER not in {one.state.status for one in given}
