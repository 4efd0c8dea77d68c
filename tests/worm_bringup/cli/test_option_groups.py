"""A command with groups is typed, and refused, as if it named each option itself."""

from dataclasses import dataclass
from typing import Annotated

import typer
from typer.testing import CliRunner

from worm_bringup.cli.option_groups import grouped


@dataclass(frozen=True)
class Light:
    colour: Annotated[str, typer.Option(help="Of the lamp.")] = "white"
    watts: Annotated[float | None, typer.Option(min=0.0)] = None


def shine(*words):
    """Return what the command was given, its exit status and its help."""
    given = []
    app = typer.Typer()

    @app.command()
    @grouped
    def command(
        *,
        lamp: Annotated[str, typer.Argument()],
        light: Light,
        night: Annotated[bool, typer.Option("--night")] = False,
    ) -> None:
        """Shine."""
        given.append((lamp, light, night))

    done = CliRunner().invoke(app, words)
    return given, done.exit_code, done.output


def test_options_of_a_group_reach_the_command_as_the_group():
    given, status, _ = shine("one", "--watts", "5", "--night")
    assert (given, status) == ([("one", Light(watts=5.0), True)], 0)
    assert shine("one")[0] == [("one", Light(), False)]


def test_an_option_of_a_group_is_checked_and_explained_like_any_other():
    given, status, _ = shine("one", "--watts", "-1")
    assert (given, status) == ([], 2)
    _, status, said = shine("--help")
    assert status == 0
    assert said.index("Shine.") < said.index("--colour") < said.index("--night")
    assert "Of the lamp." in said
