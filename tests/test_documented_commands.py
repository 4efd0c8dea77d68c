"""What README and docs tell to type works as it stands: commands, Python, tests of nodes.

Fenced blocks are run. What stands in a sentence may take minutes (benchmarks) or need what the
reader has: its names and options are held to those that there are.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import typer
from forked_commands import run_command

from worm_bringup.cli.app import app

ROOT = Path(__file__).parents[1]
PAGES = [
    *(
        ROOT / name
        for name in ("README.md", "CONTRIBUTING.md", "bags/README.md", "tests/README.md")
    ),
    *sorted((ROOT / "docs").glob("*.md")),
]
WORM = typer.main.get_command(app)
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NOT_RUN = {
    "make demo": "sets up an environment, then replays all of bags/trial and pools: a minute",
    "make test": "runs this test",
    "source .venv/bin/activate": "tests run in an environment that is active",
    "worm live --camera /dev/video0 --out out/today --record out/today-bag-2": "needs a camera",
    "export ROS_SECURITY_KEYSTORE=~/keystore ROS_SECURITY_ENABLE=true "
    "ROS_SECURITY_STRATEGY=Enforce": "needs keys of ROS 2",
    "export ROS_SECURITY_ENCLAVE_OVERRIDE=/worm": "needs keys of ROS 2",
    "cd ros2_ws": "needs a full ROS 2 installation, as the next four; test_workspace.py builds",
    "colcon build": "test_workspace.py does",
    "source install/setup.bash": "needs a full ROS 2 installation",
    "mkdir -p ../out/launched": "needs a full ROS 2 installation",
    "ros2 launch worm_bringup replay.launch.py bag:=../bags/larva out:=../out/launched": "needs it",
    "worm live --network --camera /dev/video0 --out out/today": "needs a camera, and a network",
}
"""Commands that are checked to parse only, and why."""


def blocks(page):
    """Return language and text of each fenced block."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


def lines(text):
    """Return the commands of a block without what is said beside them."""
    return [shlex.join(words) for line in text.splitlines() if (words := split(line))]


def split(line):
    return shlex.split(line, comments=True)


def parses(command):
    """Read a command's words as it would itself, and do nothing."""
    name, *words = split(command)
    if name == "make":
        assert subprocess.run(
            ["make", "--dry-run", *words], cwd=ROOT, capture_output=True, check=False
        ).returncode == 0, command  # fmt: skip
    elif name == "worm":
        subcommand = WORM.commands[words[0]]
        subcommand.make_context(words[0], words[1:]).close()
    elif name == "ros2":
        package, file, *arguments = words[1:]
        launch = (ROOT / "src" / package / "launch" / file).read_text(encoding="utf-8")
        assert all(f'"{argument.split(":=")[0]}"' in launch for argument in arguments)
    else:
        assert name in ("source", "export", "cd", "colcon", "mkdir"), command


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a command in a folder that has all of the repository but out/."""
    for item in ROOT.iterdir():
        if item.name not in ("out", ".venv", ".git"):
            (tmp_path / item.name).symlink_to(item)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "ROS_DOMAIN_ID": "83"}  # nobody else's graph

    def run(*words):
        if words[0] == "worm":
            status, said = run_command(words[1:], tmp_path, environment)
        else:
            done = subprocess.run(
                words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
            )
            status, said = done.returncode, done.stdout + done.stderr
        assert status == 0, f"{words}\n{said}"
        return said

    return run


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_stands_on_a_page_works_in_its_order(page, run, tmp_path):
    for number, (language, text) in enumerate(blocks(page)):
        assert language in ("sh", "python", "text"), f"say what this is:\n{text}"
        if language == "sh":
            for command in lines(text):
                if command in map(shlex.join, map(split, NOT_RUN)):
                    parses(command)
                else:
                    run(*split(command))
        elif language == "python":
            script = tmp_path / f"test_block_{number}.py"
            script.write_text(text, encoding="utf-8")
            if "def test_" in text:
                assert "1 passed" in run("pytest", "-q", str(script))
            else:
                assert run("python", str(script))
    for table in (tmp_path / "out").rglob("*.parquet"):
        for column in pq.read_schema(table):
            assert column.metadata[b"description"], f"{table}: {column.name}"


def test_what_is_not_run_stands_somewhere():
    said = {command for page in PAGES for _, text in blocks(page) for command in lines(text)}
    assert {shlex.join(split(command)) for command in NOT_RUN} <= said


def told(pattern):
    """Return what stands in a text as code, with the name of its page."""
    return [
        pytest.param(code, id=f"{page.stem}: {code}")
        for page in PAGES
        for code in dict.fromkeys(re.findall(pattern, BLOCK.sub("", page.read_text("utf-8"))))
    ]


@pytest.mark.parametrize("code", told(r"`(worm [a-z][^`]*)`"))
def test_a_command_in_a_sentence_has_this_name_and_these_options(code):
    _, name, *words = code.split()
    command = WORM.commands[name]
    if words and words[0] in getattr(command, "commands", {}):
        command = command.commands[words.pop(0)]
    if name == "node" and "--ros-args" in words:  # what follows is ROS's
        words = words[: words.index("--ros-args")]
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known | {"--help"}


@pytest.mark.parametrize("code", told(r"`(python [^`]*)`"))
def test_a_script_in_a_sentence_is_there_and_has_these_options(code):
    words = code.split()[1:]
    module = words[1].replace(".", "/") if words[0] == "-m" else words[0].removesuffix(".py")
    file = next(
        path for path in (ROOT / f"{module}.py", ROOT / module / "__main__.py") if path.is_file()
    )
    source = file.read_text(encoding="utf-8")
    for option in (word for word in words if word.startswith("--")):  # argparse's, or typer's
        assert f'"{option}"' in source or f"{option[2:].replace('-', '_')}:" in source


@pytest.mark.parametrize("code", told(r"`make ([a-z]+)`"))
def test_a_make_target_in_a_sentence_is_there(code):
    parses(f"make {code}")
