"""What was typed and cannot be used: one line that names the option, the cause and the remedy."""

from collections.abc import Mapping
from typing import Any

import typer

from worm_msgs_py.errors import BadInput

UsageFault: type[Exception] = typer.BadParameter.__mro__[2]
"""The base of what typer raises for wrong options; it has that class under several names."""

_NOT_GIVEN = (None, False, "", ())


def usage_line(fault: Any) -> str:
    """Return one line for an option that typer, or the check of a number, does not take.

    Empty where it is that nothing was typed, for which there is the help.
    """
    param = getattr(fault, "param", None)
    if param is not None and type(fault) is typer.BadParameter:
        name = max(param.opts, key=len)
        named = name if name.startswith("-") else name.upper()
        goes_on = fault.message.split(" ", 1)[0] == "is"
        return f"{named}{' ' if goes_on else ': '}{fault.message}"
    said = str(fault.format_message()).rstrip(".")
    if not said or "\n" in said:
        return ""
    context = getattr(fault, "ctx", None)
    return f"{said}; see {context.command_path} --help" if context is not None else said


def option_name(name: str) -> str:
    """Return how an argument's option is written."""
    return "--" + name.replace("_", "-")


def refuse_together(given: Mapping[str, Any], reason: str, one: str, *others: str) -> None:
    """Refuse options that say nothing, or the contrary, beside another one.

    Parameters
    ----------
    given : mapping
        Values of the options, by name; None, False or empty where not given.
    reason : str
        Why not both: goes on from the name of `one`.
    one, *others : str
        Names; where `one` is given, none of the others may be.

    Raises
    ------
    BadInput
        The first of the others that is given.
    """
    if given[one] in _NOT_GIVEN:
        return
    for other in others:
        if given[other] not in _NOT_GIVEN:
            raise BadInput(
                f"{option_name(one)} {reason}: leave out {option_name(other)}, or "
                f"{option_name(one)}"
            )


def refuse_without(given: Mapping[str, Any], one: str, needed: str, why: str) -> None:
    """Refuse an option that has no effect without another one.

    Raises
    ------
    BadInput
        `one` is given and `needed` is not.
    """
    if given[one] not in _NOT_GIVEN and given[needed] in _NOT_GIVEN:
        raise BadInput(
            f"{option_name(one)} {why}: add {option_name(needed)}, or leave out {option_name(one)}"
        )
