"""Data flows one way: cores do not import rclpy, and packages import only what they may."""

import ast
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src"
MAY_IMPORT = {
    "worm_msgs_py": set(),
    "worm_tracker": {"worm_msgs_py"},
    "worm_analysis": {"worm_msgs_py"},
    "worm_model": {"worm_msgs_py"},
    "worm_monitor": {"worm_msgs_py", "worm_tracker", "worm_analysis"},
    "worm_bringup": {
        "worm_msgs_py",
        "worm_tracker",
        "worm_analysis",
        "worm_model",
        "worm_monitor",
    },
}
ROS = {"rclpy", "std_msgs", "sensor_msgs", "geometry_msgs", "diagnostic_msgs"}
ROS_FILES = {  # what is allowed to know ROS: nodes, conversions, and the graph
    "worm_msgs_py": {"ros", "convert"},
    "worm_monitor": {"operator_commands.py"},
}


def imports(file):
    """Return the top-level packages that a module imports anywhere in it."""
    found = set()
    for item in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(item, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in item.names}
        elif isinstance(item, ast.ImportFrom) and item.module:
            found.add(item.module.partition(".")[0])
    return found


def modules(package):
    return sorted((SRC / package / package).rglob("*.py"))


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_a_package_imports_only_what_it_may(package):
    for file in modules(package):
        ours = {name for name in imports(file) if name.startswith("worm_")} - {package}
        assert ours <= MAY_IMPORT[package], f"{file.relative_to(SRC)} imports {ours}"


@pytest.mark.parametrize(
    "package", ["worm_msgs_py", "worm_tracker", "worm_analysis", "worm_model", "worm_monitor"]
)
def test_a_core_does_not_import_ros(package):
    for file in modules(package):
        inside = file.relative_to(SRC / package / package)
        knows_ros = file.stem.endswith("node") or inside.parts[0] in ROS_FILES.get(package, ())
        if not knows_ros:
            assert not imports(file) & ROS, f"{file.relative_to(SRC)} is a core and imports ROS"


def test_every_module_says_what_it_is_for():
    for file in SRC.rglob("worm_*/**/*.py"):
        if "launch" not in file.parts and file.name != "setup.py":
            assert ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))), file
