"""What the tests of a module share is made once, however many workers run them.

pytest-xdist says nothing where it does not heed groups: pytest-dev/pytest-xdist#1386.
"""

import subprocess
import sys
from pathlib import Path

CONFTEST = Path(__file__).parent / "conftest.py"
MODULE = """
import os
from pathlib import Path

import pytest

pytestmark = {mark}


@pytest.fixture(scope="module")
def made():
    with Path("made").open("a") as file:
        file.write("{name} ")


@pytest.mark.parametrize("number", range(6))
def test_it(made, number):
    with Path("workers").open("a") as file:
        file.write("{name} " + os.environ["PYTEST_XDIST_WORKER"] + "\\n")
"""


def test_the_tests_of_a_module_and_of_a_group_share_a_worker(tmp_path):
    (tmp_path / "conftest.py").write_text(CONFTEST.read_text(encoding="utf-8"), encoding="utf-8")
    marks = {"one": "[]", "other": "[]", "first": "pytest.mark.xdist_group('a pair')"}
    for name, mark in {**marks, "second": marks["first"]}.items():
        (tmp_path / f"test_{name}.py").write_text(MODULE.format(mark=mark, name=name))
    words = ["-q", "-n", "2", "--dist", "loadgroup", "-p", "no:cacheprovider", "--rootdir", "."]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words], cwd=tmp_path, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert "24 passed" in done.stdout, done.stdout
    assert sorted((tmp_path / "made").read_text().split()) == ["first", "one", "other", "second"]
    lines = set((tmp_path / "workers").read_text().splitlines())
    worker = dict(line.split() for line in lines)
    assert len(lines) == len(worker) == 4
    assert worker["first"] == worker["second"]
