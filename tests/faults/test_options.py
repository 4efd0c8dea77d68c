"""Every option is checked when it is read: one line names it, the cause and the remedy."""

import sys

import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_bringup.cli.app import app, main


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
