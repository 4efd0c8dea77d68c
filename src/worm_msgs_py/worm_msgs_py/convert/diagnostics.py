"""Dataclasses as `diagnostic_msgs/DiagnosticStatus`: text that a person and a program can read.

Numbers are written with `repr`, so that they come back to the last bit. The unit is part of the
key (``distance_m``), nothing is left out: a value that is not there is the word ``none``.
"""

import types
from dataclasses import fields
from enum import StrEnum
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_origin

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_NONE = "none"
Record = TypeVar("Record", bound="DataclassInstance")


def record_to_status(name: str, message: str, record: Any, hardware_id: str = "") -> Any:
    """Write every field of a flat dataclass as a key and a value."""
    return DiagnosticStatus(
        level=DiagnosticStatus.OK,
        name=str(name),
        message=str(message),
        hardware_id=str(hardware_id),
        values=[
            KeyValue(key=field.name, value=_text_of_value(getattr(record, field.name)))
            for field in fields(record)
        ],
    )


def status_to_record(status: Any, kind: type[Record]) -> Record:
    """Read a flat dataclass back; KeyError where a field is missing, ValueError where it is bad."""
    texts = {item.key: item.value for item in status.values}
    return kind(
        **{field.name: _value_of_text(texts[field.name], field.type) for field in fields(kind)}
    )


def _text_of_value(value: object) -> str:
    if value is None:
        return _NONE
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, StrEnum | str):
        return str(value)
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    raise TypeError(f"cannot write a {type(value).__name__} into a diagnostic value: {value!r}")


def _value_of_text(text: str, hint: Any) -> Any:
    if get_origin(hint) is types.UnionType:
        if text == _NONE:
            return None
        hint = next(kind for kind in get_args(hint) if kind is not type(None))
    if hint is bool:
        return {"true": True, "false": False}[text]
    value = hint(text)
    if hint is int and not -(2**63) <= value < 2**63:
        raise ValueError(f"{text[:20]}... is no whole number of 64 bits")
    return value
