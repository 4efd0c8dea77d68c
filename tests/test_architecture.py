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


WHOLE_RUNS = {
    "worm_bringup/test_main_job.py": "`worm replay` on both example bags",
    "worm_bringup/test_live_job.py": "`worm live`",
    "worm_bringup/test_bad_input.py": "what every command does with input that is bad",
    "worm_bringup/overlay/test_layouts.py": "the layouts for viewers in docs",
    "worm_bringup/overlay/test_over_the_picture.py": "a result bag, read by other libraries",
}


def named_for_no_module(tests):
    """Return the tests named neither `test_<module>.py` nor `test_<module>_<what of it>.py`.

    The module, or folder, is one of the same folder below `src`, or that folder itself.
    """
    found = []
    for test in sorted(tests.glob("worm_*/**/test_*.py")):
        inside = test.relative_to(tests)
        folder = SRC / inside.parts[0] / inside.parent
        words = test.stem.split("_")[1:]
        names = {"_".join(words[:k]) for k in range(1, len(words) + 1)}
        there = {item.stem.rstrip("_") for item in [folder, *folder.glob("*")]}
        if not names & there:
            found.append(inside.as_posix())
    return found


def test_tests_mirror_the_modules_that_they_are_of():
    assert set(named_for_no_module(Path(__file__).parent)) == set(WHOLE_RUNS)


def test_a_test_of_no_module_is_found(tmp_path):
    wrong = ["test_drawing.py", "simulator/test_sight.py", "gone/test_truth.py"]
    for name in [*wrong, "simulator/rig/test_drawing.py", "evaluation/test_evaluation_of_it.py"]:
        (tmp_path / "worm_model" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "worm_model" / name).touch()
    assert named_for_no_module(tmp_path) == sorted(f"worm_model/{name}" for name in wrong)
