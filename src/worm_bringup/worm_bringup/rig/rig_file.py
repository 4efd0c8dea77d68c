"""Reads a rig file: parameters of the graph's nodes in ROS's own form, each checked and named."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from worm_analysis.parameters import AnalysisParameters
from worm_bringup.graph.nodes import NODES, ROS_NAMES, parameters_of
from worm_model.inference.comparison import ModelParameters
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.errors import BadInput
from worm_msgs_py.ros.claims import full_name
from worm_msgs_py.ros.parameter_files import nodes_of_section
from worm_msgs_py.ros.parameters import unknown_parameter
from worm_msgs_py.text import printable
from worm_tracker.parameters import TrackerParameters

_WHOLE: dict[str, Any] = {
    "tracker": TrackerParameters,
    "analysis": AnalysisParameters,
    "model": ModelParameters,
}
"""Nodes whose parameters may contradict each other."""


class _RosLoader(yaml.SafeLoader):
    """Reads values as rcl does: 1e-3 is a number, 2026-03-21 and ~ are words, y is true."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 (as PyYAML has it)
    bool_values = {**yaml.SafeLoader.bool_values, "y": True, "n": False}  # noqa: RUF012


for _tag, _pattern in (
    (
        "bool",
        r"(?:[yYnN]|yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF)$",
    ),
    ("int", r"[-+]?(?:0x[0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)$"),
    ("float", r"[-+]?(?:(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|\.?inf|\.?nan)$"),
):
    _RosLoader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_pattern), None)


@dataclass(frozen=True)
class RigParameters:
    """What rig files say to each node of a graph.

    Attributes
    ----------
    files : tuple of Path
        Where it stands; none where no file was given.
    told : mapping
        Parameters by the node's name.
    """

    files: tuple[Path, ...] = ()
    told: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def of(self, node: str, among: Iterable[Declaration] | None = None) -> dict[str, Any]:
        """Return what is said to a node; of a source, which shares its name, `among` its own."""
        told = dict(self.told.get(node, {}))
        if among is None:
            return told
        own = {declared.name for declared in among}
        return {name: value for name, value in told.items() if name in own}


def read_rig(files: Sequence[Path] | None, namespace: str = "") -> RigParameters:
    """Read rig files; where several say something of one parameter the last one counts.

    Parameters
    ----------
    namespace : str
        Of the graph: a section may be for another one, as ``/rig2/tracker``.

    Raises
    ------
    BadInput
        One line that names the file, the node, the parameter, what is wrong, and the remedy.
    """
    told: dict[str, dict[str, Any]] = {}
    for file in files or ():
        for node, parameters in _read_parameters(file, namespace).items():
            told.setdefault(node, {}).update(parameters)
    for node, kind in _WHOLE.items():
        own = {k: v for k, v in told.get(node, {}).items() if k in kind.__dataclass_fields__}
        try:
            kind(**own)
        except BadInput as error:
            raise BadInput(f"{', '.join(map(str, files or ()))}: {node}: {error}") from None
    return RigParameters(tuple(files or ()), told)


def _read_parameters(file: Path, namespace: str) -> dict[str, dict[str, Any]]:
    told: dict[str, dict[str, Any]] = {}
    for section, entry in _sections(file).items():
        given = entry.get("ros__parameters") if isinstance(entry, dict) else None
        if not isinstance(given, dict) or len(entry) != 1:
            raise BadInput(f"{file}: {section}: give its parameters under ros__parameters:")
        nodes = nodes_of_section(section)
        if not nodes:
            known = sorted({ROS_NAMES.get(name, name) for name in NODES})
            like = get_close_matches(section.rpartition("/")[2], known, n=1)
            guess = f"did you mean {like[0]!r}? " if like else ""
            raise BadInput(
                f"{file}: {section!r} is no node of the graph: {guess}give /** for all, or one of "
                + ", ".join(known)
            )
        for name, value in given.items():
            to = _nodes_with(file, section, nodes, name, value)
            for node in to:
                if _speaks_to(section, full_name(namespace, node)):
                    told.setdefault(node, {})[name] = value
    return told


def _sections(file: Path) -> dict[str, Any]:
    try:
        content = yaml.load(file.read_text(encoding="utf-8"), _RosLoader)
    except OSError as error:
        raise BadInput(f"{file}: {error.strerror}: give a rig file that is there") from None
    except UnicodeDecodeError:
        raise BadInput(f"{file}: is no text: give a YAML file") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f", line {mark.line + 1}" if mark is not None else ""
        why = printable(getattr(error, "problem", None) or error)
        raise BadInput(f"{file}{where}: is no YAML: {why}") from None
    if not isinstance(content, dict) or not all(isinstance(name, str) for name in content):
        raise BadInput(
            f"{file}: is no parameter file: give a node's name, below it ros__parameters:, below "
            "that its parameters (docs/examples/rig.yaml is one)"
        )
    return content


def _nodes_with(file: Path, section: str, nodes: Sequence[str], name: Any, value: Any) -> list[str]:
    """Return the nodes of a section that have a parameter; refuse what none has, or takes."""
    found = []
    for node in nodes:
        declared = declared_of(node).get(name)
        if declared is None:
            continue
        wrong = declared.refusal(value)
        if wrong and name not in ("out", "bag", "record"):  # whether they are there is told later
            raise BadInput(f"{file}: {node}: {name} {wrong}")
        found.append(node)
    if not found:
        known = [name for node in nodes for name in declared_of(node)]
        line = unknown_parameter(nodes[0] if len(nodes) == 1 else section, str(name), known)
        raise BadInput(f"{file}: {line.removeprefix('node ')}")
    return found


def declared_of(node: str) -> dict[str, Declaration]:
    """Return all that the nodes of this name may be told, by the parameter's name."""
    return {
        declared.name: declared
        for name in NODES
        if ROS_NAMES.get(name, name) == node
        for declared in parameters_of(name)
    }


def _speaks_to(section: str, node: str) -> bool:
    """Tell whether rcl gives a node this section: ** stands for any names, * for one."""
    pattern = "/" + section.lstrip("/")
    regex = re.escape(pattern).replace(r"/\*\*", r"(?:/\w+)*").replace(r"/\*", r"/\w+")
    return re.fullmatch(regex, node) is not None
