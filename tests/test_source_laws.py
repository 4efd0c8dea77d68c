"""The source stays as small, as flat and as plainly named as it is; each law is seen to bite."""

import ast
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src"
MOST_FUNCTION_LINES, MOST_FILE_LINES, MOST_REASSIGNED = 50, 400, 8
MOST_ROOMS, MOST_FLOORS = 16, 7
COMMANDS = "cli"
"""A command's signature is its help page: as long as its options are many."""
SHARED_PUBLIC = {
    "main": "how a program is started: each entry point has one",
    "simulate": "the command, and what it calls: a trial of the filament",
    "calibrate": "the command, and what it calls for each picture",
    "generate_launch_description": "what ros2 launch calls in a launch file",
    "NAME": "of a node: each has its own",
    "SCHEMA": "of a file: each module of results writes one",
}
SHARED_PRIVATE = {
    "_OUT": "the topics that a node sends: each has its own",
    "_REAL": "fields of a message that are real numbers: each message has its own",
    "_WHOLE": "fields of a message that are whole numbers",
    "_READING": "how a figure is read: each has its own",
    "_READING_LONG": "what is added to it where a trial is long",
}

Parsed = dict[Path, ast.Module]


@cache
def parsed(src: Path) -> Parsed:
    """Return all modules of all packages by their path below src; a setup.py is setuptools'."""
    return {
        file.relative_to(src): ast.parse(file.read_text(encoding="utf-8"))
        for file in sorted(src.rglob("*.py"))
        if file.name != "setup.py"
    }


def long_functions(src: Path) -> list[str]:
    return [
        f"{file}: {item.name} has {lines} lines"
        for file, module in parsed(src).items()
        if COMMANDS not in file.parts
        for item in ast.walk(module)
        if isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef)
        and (lines := item.end_lineno - item.lineno + 1) > MOST_FUNCTION_LINES
    ]


def long_files(src: Path) -> list[str]:
    lines = {file: len((src / file).read_text("utf-8").splitlines()) for file in parsed(src)}
    return [f"{file} has {n} lines" for file, n in lines.items() if n > MOST_FILE_LINES]


def changing_classes(src: Path) -> list[str]:
    """Return the classes whose state is more than a reader can keep in mind."""
    found = []
    for file, module in parsed(src).items():
        for item in ast.walk(module):
            if isinstance(item, ast.ClassDef):
                n = len(reassigned(item))
                if n > MOST_REASSIGNED:
                    found.append(f"{file}: {item.name} reassigns {n} attributes")
    return found


def reassigned(of: ast.ClassDef) -> set[str]:
    """Return the attributes of self that a class' methods assign to, but for its constructor."""
    methods = (item for item in of.body if isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef))
    return {
        target.attr
        for method in methods
        if method.name != "__init__"
        for target in ast.walk(method)
        if isinstance(target, ast.Attribute)
        and isinstance(target.ctx, ast.Store)
        and isinstance(target.value, ast.Name)
        and target.value.id == "self"
    }


def top_level(module: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names that a module defines at its top level, and the value of each."""
    for item in module.body:
        if isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield item.name, ""
        elif isinstance(item, ast.Assign | ast.AnnAssign) and item.value is not None:
            targets = item.targets if isinstance(item, ast.Assign) else [item.target]
            for target in targets:
                yield from assigned(target, item.value)


def assigned(target: ast.expr, value: ast.expr) -> Iterator[tuple[str, str]]:
    if isinstance(target, ast.Name):
        yield target.id, ast.unparse(value)
    elif isinstance(target, ast.Tuple):
        values = value.elts if isinstance(value, ast.Tuple) else [value] * len(target.elts)
        for each, its in zip(target.elts, values, strict=True):
            yield from assigned(each, its)


def shared_public_names(src: Path) -> list[str]:
    where = defaultdict(set)
    for file, module in parsed(src).items():
        for name, _ in top_level(module):
            if not name.startswith("_") and name not in SHARED_PUBLIC:
                where[name].add(str(file))
    return [f"{name} in {sorted(files)}" for name, files in where.items() if len(files) > 1]


def shared_private_names(src: Path) -> list[str]:
    """Return the names that a reader who knows one module would take for another's.

    A constant may stand twice with the same value; a function or class has its own name.
    """
    values = defaultdict(lambda: defaultdict(list))
    for file, module in parsed(src).items():
        for name, value in top_level(module):
            private = name.startswith("_") and not name.startswith("__")
            if private and name not in SHARED_PRIVATE:
                values[name][value or str(file)].append(str(file))
    return [f"{name}: {dict(its)}" for name, its in values.items() if len(its) > 1]


def imported(module: ast.Module, modules: Collection[str]) -> Iterator[str]:
    """Yield which of some modules a module imports, whole or names from them."""
    for item in ast.walk(module):
        if isinstance(item, ast.Import):
            yield from (alias.name for alias in item.names if alias.name in modules)
        elif isinstance(item, ast.ImportFrom) and item.module:
            whole = (f"{item.module}.{alias.name}" for alias in item.names)
            names = (name if name in modules else item.module for name in whole)
            yield from (name for name in names if name in modules)


def modules_of(src: Path) -> dict[str, ast.Module]:
    """Return all modules by the name that they are imported by."""
    return {
        ".".join(file.with_suffix("").parts[1:]).removesuffix(".__init__"): module
        for file, module in parsed(src).items()
    }


def rooms(src: Path, package: str) -> dict[str, set[str]]:
    """Return the modules and folders at a package's root, and which others each imports."""
    modules = modules_of(src)
    inside = [name for name in modules if name.startswith(f"{package}.")]
    needs: dict[str, set[str]] = {name.split(".")[1]: set() for name in inside}
    for name in inside:
        others = {other.split(".")[1] for other in imported(modules[name], inside)}
        needs[name.split(".")[1]] |= others - {name.split(".")[1]}
    return needs


def packages(src: Path) -> list[str]:
    return sorted(path.name for path in src.iterdir() if (path / path.name).is_dir())


def crowded_packages(src: Path) -> list[str]:
    counts = {package: len(rooms(src, package)) for package in packages(src)}
    return [f"{package} has {n} rooms" for package, n in counts.items() if n > MOST_ROOMS]


def floors_of(needs: dict[str, set[str]]) -> int:
    """Return the length of the longest chain of imports.

    Raises
    ------
    graphlib.CycleError
        Where imports lead back to where they began.
    """
    floor: dict[str, int] = {}
    for room in TopologicalSorter(needs).static_order():
        floor[room] = 1 + max((floor[needed] for needed in needs[room]), default=0)
    return max(floor.values(), default=0)


def tall_packages(src: Path) -> list[str]:
    """Return the packages whose rooms import each other in a long chain, or in a ring."""
    found = []
    for package in packages(src):
        try:
            floors = floors_of(rooms(src, package))
        except CycleError as error:
            found.append(f"{package}: a ring of imports: {error.args[1]}")
        else:
            if floors > MOST_FLOORS:
                found.append(f"{package} has {floors} floors")
    return found


def ring_of_modules(src: Path) -> list[str]:
    """Return the packages in which modules of whatever rooms import each other in a ring."""
    trees = modules_of(src)
    needs = {name: set(imported(module, trees)) - {name} for name, module in trees.items()}
    try:
        floors_of(needs)
    except CycleError as error:
        return [f"a ring of imports: {error.args[1]}"]
    return []


LAWS: dict[str, Callable[[Path], list[str]]] = {
    "a function fits on a screen": long_functions,
    "a file can be read in one go": long_files,
    "a class changes little of itself": changing_classes,
    "a public name has one meaning": shared_public_names,
    "a private name has one meaning": shared_private_names,
    "a package has few rooms": crowded_packages,
    "a package has few floors and its rooms no ring": tall_packages,
    "modules import one way": ring_of_modules,
}


@pytest.mark.parametrize("law", LAWS)
def test_the_source_keeps_the_law(law):
    assert LAWS[law](SRC) == []


def test_no_name_is_allowed_twice_that_is_not_there_twice():
    """An exception that nobody needs any longer would let the next one in."""
    public, private = defaultdict(set), defaultdict(set)
    for file, module in parsed(SRC).items():
        for name, value in top_level(module):
            public[name].add(file)
            private[name].add(value)
    assert all(len(public[name]) > 1 for name in SHARED_PUBLIC)
    assert all(len(private[name]) > 1 for name in SHARED_PRIVATE)


def function(lines: int) -> str:
    return "def crawl():\n" + "    pass\n" * (lines - 1)


def worm(attributes: int) -> str:
    body = "".join(f"        self.part_{k}, x[0] = 0, 1\n" for k in range(attributes))
    return f"class Worm:\n    def __init__(self):\n{body}{body}    def crawl(self):\n{body}"


def chain(rooms: int) -> dict[str, str]:
    texts = {f"room_{k}.py": f"from worm_x.room_{k - 1} import A{k - 1}" for k in range(1, rooms)}
    return {"room_0.py": "A0 = 0", **texts}


KEPT = {
    "a function fits on a screen": {"a.py": function(50), "cli/b.py": function(51)},
    "a file can be read in one go": {"a.py": "\n" * 400},
    "a class changes little of itself": {"a.py": worm(8)},
    "a public name has one meaning": {"a.py": "NAME = 1\n_A = 1", "b.py": "NAME = 2\n_A = 1"},
    "a private name has one meaning": {"a.py": "_A, _B = 1, 2", "b.py": "_B = 2"},
    "a package has few rooms": {f"room_{k}.py": "" for k in range(16)},
    "a package has few floors and its rooms no ring": chain(7),
    "modules import one way": {"a/b.py": "import worm_x.a.c", "a/c.py": ""},
}
BROKEN = {
    "a function fits on a screen": {"a.py": "class A:\n " + function(51).replace("\n", "\n ")},
    "a file can be read in one go": {"a/b.py": "\n" * 401},
    "a class changes little of itself": {"a.py": worm(9)},
    "a public name has one meaning": {"a.py": "SPEED = 1", "b/c.py": "class SPEED: ..."},
    "a private name has one meaning": {"a.py": "def _crawl(): ...", "b.py": "class _crawl: ..."},
    "a package has few rooms": {f"room_{k}/a.py": "" for k in range(17)},
    "a package has few floors and its rooms no ring": chain(8),
    "modules import one way": {"a/b.py": "import worm_x.a.c", "a/c.py": "from worm_x.a import b"},
}


def written(texts: dict[str, str], src: Path) -> Path:
    for name, text in texts.items():
        file = src / "worm_x" / "worm_x" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return src


@pytest.mark.parametrize("law", LAWS)
def test_the_law_allows_what_is_just_within_it(law, tmp_path):
    assert LAWS[law](written(KEPT[law], tmp_path)) == []


@pytest.mark.parametrize("law", LAWS)
def test_the_law_finds_what_is_just_beyond_it(law, tmp_path):
    assert len(LAWS[law](written(BROKEN[law], tmp_path))) == 1


def test_a_private_constant_of_two_values_is_found(tmp_path):
    texts = {"a.py": "_A, _B = 1, 2", "b.py": "_B: int = 3"}
    assert len(shared_private_names(written(texts, tmp_path))) == 1


def test_rooms_that_need_each_other_are_found(tmp_path):
    texts = {"a/b.py": "import worm_x.c", "c.py": "from worm_x.a import d", "a/d.py": ""}
    assert "ring" in tall_packages(written(texts, tmp_path))[0]
