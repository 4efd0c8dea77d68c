"""The `worm` command: its subcommands, and what every one of them does with an error."""

import logging
import signal
import sys
from importlib.metadata import version
from typing import Annotated, NoReturn

import typer

from worm_bringup.cli.analyse import analyse
from worm_bringup.cli.calibrate import calibrate
from worm_bringup.cli.doctor import doctor
from worm_bringup.cli.evaluate import evaluate
from worm_bringup.cli.export import export
from worm_bringup.cli.import_ import import_
from worm_bringup.cli.live import live
from worm_bringup.cli.lost_terminal import outliving_the_terminal
from worm_bringup.cli.model import model
from worm_bringup.cli.node import node
from worm_bringup.cli.repair import repair
from worm_bringup.cli.replay import replay
from worm_bringup.cli.report import report
from worm_bringup.cli.review import review
from worm_bringup.cli.simulate import simulate
from worm_bringup.cli.usage_errors import UsageFault, usage_line
from worm_bringup.outputs.results_directory import Kept
from worm_bringup.trial import EndedEarly, Incomplete, WithoutPose
from worm_msgs_py.errors import BAD_INPUT, INCOMPLETE, BadInput, NodeFailed, ReportError
from worm_msgs_py.ros.running import interrupted_by_signals
from worm_msgs_py.text import printable

INTERRUPTED = 128 + signal.SIGINT
"""As shells say it, whichever signal it was."""

app = typer.Typer(
    name="worm",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"worm-escape {version('worm-escape')}")
        raise typer.Exit


@app.callback()
def _worm(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Track a worm in a round chamber, analyse its search for the exit, and report."""


app.command("import")(import_)
for command in (
    replay,
    repair,
    live,
    calibrate,
    simulate,
    analyse,
    evaluate,
    report,
    review,
    export,
    doctor,
):
    app.command()(command)
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(node)
app.add_typer(model)


def main() -> None:
    """Run the command.

    Exit status: 0 the result is complete; 1 it is not, or not one frame has a pose: nothing was
    written, or the last line on stderr names where it is kept; 2 bad input, one line on stderr says
    what and what to do; 130 interrupted.
    """
    # A machine's first figure looks for fonts, and matplotlib warns of that: errors are one line.
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    with outliving_the_terminal(), interrupted_by_signals():
        try:
            _run()
        except KeyboardInterrupt:
            _say_interrupted()
            sys.exit(INTERRUPTED)


def _run() -> None:
    try:
        status = app(standalone_mode=False)
    except UsageFault as fault:
        line = usage_line(fault)
        if not line:  # the help was printed instead
            sys.exit(BAD_INPUT)
        _leave_refusing(line)
    except (BadInput, ReportError) as error:
        _leave_refusing(error)
    except Kept as error:
        print(f"worm: {printable(error)}", file=sys.stderr)
        sys.exit(INTERRUPTED if error.interrupted else INCOMPLETE)
    except NodeFailed as error:
        print(f"worm: incomplete, no results were written: {printable(error)}", file=sys.stderr)
        sys.exit(INCOMPLETE)
    except EndedEarly as error:
        print(f"worm: ended before its time: {printable(error)}", file=sys.stderr)
        sys.exit(INCOMPLETE)
    except WithoutPose as error:
        print(f"worm: {printable(error)}", file=sys.stderr)
        sys.exit(INCOMPLETE)
    except OSError as error:
        if error.filename is None:
            raise
        _leave_refusing(f"{error.filename}: {error.strerror}: is the path right, and open to you?")
    except MemoryError as error:
        _leave_refusing(f"out of memory ({error}): give the machine more, or ask for less")
    except Incomplete as error:
        print(f"worm: incomplete, no results were written: {printable(error)}", file=sys.stderr)
        for note in getattr(error, "__notes__", ()):
            print(f"worm: {printable(note)}", file=sys.stderr)
        sys.exit(INTERRUPTED if error.result.interrupted else INCOMPLETE)
    else:
        if status == INTERRUPTED:  # typer's word for KeyboardInterrupt
            _say_interrupted()
        sys.exit(status or 0)


def _say_interrupted() -> None:
    print("worm: interrupted", file=sys.stderr)


def _leave_refusing(error: object) -> NoReturn:
    print(f"worm: {printable(error)}", file=sys.stderr)
    sys.exit(BAD_INPUT)
