"""Lets several commands take the same options: a group is a dataclass, each field an option."""

import inspect
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import wraps
from inspect import Parameter
from typing import Any


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that is typed with the options of its groups, for typer.

    Parameters
    ----------
    command : callable
        Takes keywords alone. An argument that is annotated with a dataclass is a group: the
        dataclass's fields, which are annotated as typer's options are, stand in its place.
    """
    arguments = inspect.signature(command).parameters
    groups: dict[str, Any] = {
        name: argument.annotation
        for name, argument in arguments.items()
        if is_dataclass(argument.annotation)
    }

    @wraps(command)
    def run(**given: Any) -> None:
        for name, group in groups.items():
            given[name] = group(**{field.name: given.pop(field.name) for field in fields(group)})
        command(**given)

    options: list[Parameter] = []
    for name, argument in arguments.items():
        options += _options_of_group(groups[name]) if name in groups else [argument]
    run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return run


def _options_of_group(group: Any) -> list[Parameter]:
    return [
        Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
        for field in fields(group)
    ]
