"""Every option is checked when it is read: one line names it, the cause and the remedy."""

import io
import re
import sys

import numpy as np
import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.table import Table

from worm_bringup.cli.app import app, main
from worm_bringup.cli.terminal import Terminal
from worm_msgs_py.errors import BadInput
from worm_msgs_py.text import printable
from worm_tracker.calibration.calibrate import calibrate
from worm_tracker.parameters import TrackerParameters


def numeric_options(command, path=()):
    """Yield the command line and the option, with its parts, of every number that is taken."""
    for name, part in getattr(command, "commands", {}).items():
        yield from numeric_options(part, (*path, name))
    for param in command.params:
        shown = str(param.type_descriptor.annotation) if hasattr(param, "type_descriptor") else ""
        if "float" in shown or "int" in shown.replace("print", ""):
            yield (*path, max(param.opts, key=len)), max(param.nargs, 1)


OPTIONS = sorted(numeric_options(typer.main.get_command(app)))
NAMES = [" ".join(words) for words, _ in OPTIONS]


def typed(*words):
    """Return the exit status and what is on stderr of a command."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["worm", *map(str, words)])
        errors = Lines()
        patch.setattr(sys, "stderr", errors)
        with pytest.raises(SystemExit) as left:
            main()
    return left.value.code, errors.lines()


class Lines:
    """Takes what is written, as a terminal would."""

    def __init__(self):
        self._written = []

    def write(self, text):
        self._written.append(text)

    def flush(self):
        pass

    def isatty(self):
        return False

    def lines(self):
        return "".join(self._written).splitlines()


def refused(words, option):
    status, lines = typed(*words)
    assert status == 2, lines
    assert len(lines) == 1, lines
    assert lines[0].startswith(f"worm: {option}")
    return lines[0]


def test_the_options_that_take_numbers_are_found():
    assert len(OPTIONS) > 45
    assert ("replay", "--radius-mm") in [words for words, _ in OPTIONS]
    assert (("live", "--circle-px"), 3) in OPTIONS
    assert ("model", "solve", "--at-s") in [words for words, _ in OPTIONS]


@pytest.mark.parametrize(("words", "parts"), OPTIONS, ids=NAMES)
@pytest.mark.parametrize("value", ["nan", "inf", "-1e300", "ten"])
def test_every_number_of_every_command_is_refused_where_it_makes_no_sense(words, parts, value):
    line = refused((*words, *[value] * parts), words[-1])
    assert ": " in line.removeprefix("worm: ")


@pytest.mark.parametrize(("words", "parts"), OPTIONS, ids=NAMES)
def test_each_part_of_an_option_is_checked(words, parts):
    for part in range(parts):
        values = ["100"] * parts
        values[part] = "nan"
        line = refused((*words, *values), words[-1])
        assert "nan" in line or "integer" in line


@settings(max_examples=40)
@given(st.sampled_from(OPTIONS), st.floats().filter(lambda x: not -1e9 < x < 1e9))
def test_no_number_beyond_all_measure_is_taken(option, value):
    words, parts = option
    if words[-1] != "--seed" or not 0 <= value < 2**32:
        refused((*words, *[repr(value)] * parts), words[-1])


CIRCLE = ["--circle-px", 128, 128, 100]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--px-per-mm", 20], "--px-per-mm is the scale .*: add --no-chamber"),
        (["--circle-b-px", 1, 1, 100], "--circle-b-px is a second chamber: add --circle-px"),
        (["--no-chamber", "--radius-mm", 8], "--no-chamber .*: leave out --radius-mm"),
        (["--no-chamber", "--body-width-mm", 0.4], "--no-chamber .*: leave out --body-width-mm"),
        ([*CIRCLE, "--circle-b-px", 128, 128, 100], "--circle-b-px.* overlaps the first"),
        (["--exit-width-mm", 25], "--exit-width-mm .*25 mm: an exit is narrower"),
        (["--radius-mm", 0.01], "--radius-mm is 0.01: .*if that is in m, give 10"),
        (["--namespace", "bad name"], "--namespace: 'bad name' is no ROS namespace"),
        (["--radiu-mm", 10], "No such option: --radiu-mm"),
    ],
)
def test_options_that_say_nothing_together_are_refused(tmp_path, words, said):
    status, lines = typed("replay", "bags/larva", "--out", tmp_path / "out", *words)
    assert (status, len(lines)) == (2, 1), lines
    assert re.search(said, lines[0]), lines[0]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("circle", [(500.0, 500.0, 4000.0), (900.0, 20.0, 50.0)])
def test_a_circle_that_cannot_be_in_the_pictures_is_refused(circle):
    names = ("centre_u_px", "centre_v_px", "radius_px")
    parameters = TrackerParameters(**dict(zip(names, circle, strict=True)))
    with pytest.raises(BadInput, match=r"--circle-px .* in pictures of 256 x 256 px"):
        calibrate(np.full((256, 256), 200, np.uint8), parameters, 0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--minutes", 10_000, "--fps", 1000], "is 600000000 frames"),
        (["--minutes", 1e12], "--minutes is 1e+12: give 0.005 to"),
        (["--minutes", 10_000, "--tracks-only", "--trials", 1000, "--fps", 100], "GB are free"),
    ],
)
def test_a_film_that_nobody_would_wait_for_is_refused(tmp_path, words, said):
    status, lines = typed("simulate", "--out", tmp_path / "bag", *words)
    assert (status, len(lines)) == (2, 1), lines
    assert said in lines[0]


@pytest.mark.parametrize("name", ["[/x]", "[red]", ":smile:", "a\x1b[2J", "b\udcff"])
def test_names_are_shown_as_text(name):
    shown = io.StringIO()
    terminal = Terminal(file=shown, width=80)
    table = Table(name, title=name)
    table.add_row(name)
    terminal.print(name, table)
    assert shown.getvalue().count(printable(name)) == 4
    assert "\x1b" not in shown.getvalue()
