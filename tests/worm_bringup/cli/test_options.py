"""One name an option, in every command; and the command says its version."""

from importlib.metadata import version

import pytest
import typer
from typer.testing import CliRunner

from worm_bringup.cli.app import app

ONE_NAME = {"exit": {"--exit-deg", "--exit-width-mm"}, "width": {"--exit-width-mm",
            "--body-width-mm", "--effective-width"}, "passage": {"--passage-mm"}}  # fmt: skip
"""What W, d_w and L are called: no other option speaks of an exit, a width or the passage."""


def commands(group):
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from ((f"{name} {inner}", its) for inner, its in commands(command))
        else:
            yield name, command


COMMANDS = dict(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("name", COMMANDS)
def test_an_option_is_written_in_one_way(name):
    for parameter in COMMANDS[name].params:
        long = [option for option in parameter.opts if option.startswith("--")]
        assert len(long) <= 1, long
        for word, names in ONE_NAME.items():
            assert not [option for option in long if word in option and option not in names]


@pytest.mark.parametrize(
    ("option", "told_by"),
    [
        ("--exit-width-mm", {"replay", "live", "simulate", "analyse", "model solve"}),
        ("--body-width-mm", {"replay", "live", "simulate", "analyse"}),
        ("--passage-mm", {"replay", "live", "analyse"}),
    ],
)
def test_w_and_d_w_and_l_have_these_names(option, told_by):
    has = {name for name, its in COMMANDS.items() if any(option in p.opts for p in its.params)}
    assert has >= told_by


def test_the_version_is_that_of_the_installed_package():
    shown = CliRunner().invoke(app, ["--version"])
    assert (shown.exit_code, shown.stdout) == (0, f"worm-escape {version('worm-escape')}\n")
