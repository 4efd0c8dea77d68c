"""What pages and docstrings send a reader to is there: files, modules, what these define."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("src", "tests", "benchmarks", "docs", "bags")
FILES = [
    f"/{file.relative_to(ROOT).as_posix()}"
    for folder in FOLDERS
    for file in [*(ROOT / folder).rglob("*.py"), *(ROOT / folder).rglob("*.js")]
] + [f"/{file.relative_to(ROOT).as_posix()}" for file in ROOT.rglob("docs/*.md")]
READERS = {"test_mine.py": "README: what a reader calls his own test"}
QUOTED = re.compile(r"`+([\w./]+)`+")
DOTTED = re.compile(r"(?:worm_[a-z_]+|benchmarks)(?:\.\w+)+")
TEXTS = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "tests/README.md")),
    *(ROOT / "docs").glob("*.md"),
    *(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py")),
]


def missing(text: str) -> list[str]:
    """Return the files and modules that a text names in quotes and that are not there."""
    names = set(QUOTED.findall(text)) - set(READERS)
    files = {name for name in names if name.endswith((".py", ".js", ".md"))}
    gone = {name for name in files if not any(file.endswith(f"/{name}") for file in FILES)}
    return sorted(
        gone | {name for name in names - files if DOTTED.fullmatch(name) and unfound(name)}
    )


def unfound(dotted: str) -> bool:
    """Tell whether a dotted name is neither a module nor in the last module that it leads to."""
    parts = dotted.split(".")
    for k in range(len(parts), 0, -1):
        ends = "/" + "/".join(parts[:k])
        for file in FILES:
            if file.endswith((f"{ends}.py", f"{ends}/__init__.py")):
                text = (ROOT / file[1:]).read_text(encoding="utf-8")
                return not all(re.search(rf"\b{part}\b", text) for part in parts[k:])
    return True


@pytest.mark.parametrize("folder", ["", *FOLDERS])
def test_what_a_text_names_is_there(folder):
    texts = [
        file
        for file in TEXTS
        if file.relative_to(ROOT).parts[:-1][:1] == ((folder,) if folder else ())
    ]
    assert texts
    gone = {
        str(file.relative_to(ROOT)): missing(file.read_text(encoding="utf-8")) for file in texts
    }
    assert {file: names for file, names in gone.items() if names} == {}


def test_a_name_that_leads_nowhere_is_found():
    there = (
        "`tracker.py`, `worm_tracker.tracker.Tracker`, `docs/science.md`, `figures/`, `make bench`"
    )
    assert missing(there) == []
    gone = ["contour.py", "worm_tracker.hiding", "worm_tracker.tracker.Sight", "cli/tracker.py"]
    assert missing(" ".join(f"`{name}`" for name in gone)) == sorted(gone)
