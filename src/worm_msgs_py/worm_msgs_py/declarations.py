"""What a node may be told: each parameter's default, unit, range, and whether it may change."""

from collections.abc import Callable
from dataclasses import Field, dataclass, field, fields
from enum import StrEnum
from math import isnan
from typing import Any

from worm_msgs_py.limits import Limit

_IN_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "words",
    list: "a list of words",
}


@dataclass(frozen=True, slots=True)
class Declaration:
    """One parameter, as users read of it and as every way to give it is checked.

    Attributes
    ----------
    name : str
        As in a parameter file.
    default
        Its type is the parameter's.
    description : str
        A sentence for people.
    limit : Limit or None
        What a number may be, with its unit.
    or_else : float or None
        A value beyond the limit that has a meaning of its own, such as NaN.
    means : str
        What `or_else` says.
    choices : tuple of str
        All that a word may be; empty where it may be anything.
    check : callable or None
        Returns what is wrong with a value of the right type, as `refusal` does.
    changes : bool
        Whether it may be changed while the node runs; fixed otherwise.
    shown : callable or None
        Returns what others may see of the value, where that is not all of it.
    """

    name: str
    default: Any
    description: str
    limit: Limit | None = None
    or_else: float | None = None
    means: str = ""
    choices: tuple[str, ...] = ()
    check: Callable[[Any], str] | None = None
    changes: bool = False
    shown: Callable[[str], str] | None = None

    @property
    def kind(self) -> type:
        """The parameter's type: bool, int, float, str or list (of str)."""
        return type(self.default)

    @property
    def unit(self) -> str:
        """The unit; ``1`` of a plain number, empty of what is none."""
        if self.kind not in (int, float):
            return ""
        return (self.limit.unit if self.limit else "") or "1"

    @property
    def allowed(self) -> str:
        """What it may be, in words."""
        if self.choices:
            return " or ".join(self.choices)
        said = self.limit.in_words() if self.limit else _IN_WORDS[self.kind]
        return said if self.or_else is None else f"{said}; {self.or_else:g}: {self.means}"

    def refusal(self, value: Any) -> str:
        """Return what is wrong with a value, going on from its name; empty where it is right."""
        if not self._is_of_kind(value):
            return f"is {value!r}: give {self._kind_in_words()}"
        if self.choices and value not in self.choices:
            return f"is {str(value)!r}: give {self.allowed}"
        if self.or_else is not None and (
            value == self.or_else or (isnan(self.or_else) and isnan(value))
        ):
            return ""
        wrong = self.limit.refusal(value) if self.limit else ""
        return wrong or (self.check(value) if self.check else "")

    def _is_of_kind(self, value: Any) -> bool:
        if self.kind is list:
            return isinstance(value, list | tuple) and all(isinstance(x, str) for x in value)
        if self.kind is float:
            return isinstance(value, int | float) and not isinstance(value, bool)
        return isinstance(value, self.kind) and (self.kind is bool or not isinstance(value, bool))

    def _kind_in_words(self) -> str:
        if self.kind in (int, float):
            return f"{_IN_WORDS[self.kind]}, {self.allowed}"
        quoted = self.kind is str and not self.choices
        return self.allowed + (", in quotation marks" if quoted else "")


def declare(default: Any, description: str, limit: Limit | None = None, **more: Any) -> Any:
    """Return a dataclass field that is a parameter; the rest is as in `Declaration`.

    Where the default is None, which ROS does not have, `or_else` stands for it.
    """
    return field(default=default, metadata={"description": description, "limit": limit, **more})


def declarations(parameters: type) -> tuple[Declaration, ...]:
    """Return what the fields of a dataclass declare (see `declare`)."""
    return tuple(_declaration(item) for item in fields(parameters))


def first_refusal_of(parameters: object) -> str:
    """Return one line on the first field that is not as declared; empty where none is."""
    for item in fields(parameters):  # type: ignore[arg-type]
        value = getattr(parameters, item.name)
        wrong = "" if value is item.default else _declaration(item).refusal(value)
        if wrong:
            return f"{item.name} {wrong}"
    return ""


def _declaration(item: Field[Any]) -> Declaration:
    default = item.metadata.get("or_else") if item.default is None else item.default
    if isinstance(default, StrEnum):
        default = str(default)
    return Declaration(item.name, default, **item.metadata)
