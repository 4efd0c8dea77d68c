"""Where a result comes from: the input and its hash, the software's version, every parameter."""

import hashlib
import json
import platform
from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

_BLOCK_BYTES = 1 << 20
_PACKAGES = ("worm_msgs_py", "worm_tracker", "worm_analysis", "worm_model", "worm_bringup")
_LIBRARIES = ("numpy", "scipy", "opencv-python-headless", "pyarrow")


def provenance(source: Mapping[str, Any], parameters: Mapping[str, Mapping[str, Any]]) -> Any:
    """Return the document that goes into `summary.json`.

    Nothing in it depends on the time, the machine, the output or the way of running the graph:
    the same input gives the same bytes.

    Parameters
    ----------
    source : mapping
        What the pictures came from (name, hash, topic).
    parameters : mapping of node name to parameters
        Every parameter that a result can depend on.
    """
    return {
        "software": "worm-escape",
        "version": version("worm-escape"),
        "source": dict(source),
        "parameters": {node: dict(values) for node, values in parameters.items()},
    }


def fingerprint(source: Mapping[str, Any], parameters: Mapping[str, Mapping[str, Any]]) -> Any:
    """Return all that the bytes of a result depend on, as a JSON document.

    Beside the provenance that is the code itself, and the libraries that compute: a run that was
    stopped goes on only where all of them are the same.
    """
    libraries = {name: version(name) for name in _LIBRARIES}
    document = {
        **provenance(source, parameters),
        "code": _code_hash(),
        "python": platform.python_version(),
        **libraries,
    }
    return json.loads(json.dumps(document), parse_constant=str)  # a NaN is equal to no other


def _code_hash() -> str:
    """Return a hash of the files of all our packages."""
    digest = hashlib.sha256()
    for name in _PACKAGES:
        for folder in import_module(name).__path__:
            for file in sorted(item for item in Path(folder).rglob("*") if item.is_file()):
                if file.parent.name != "__pycache__":
                    name_in = str(file.relative_to(folder))
                    digest.update(name_in.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file's bytes, as `sha256sum` gives it."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def bag_hash(path: Path) -> str:
    """Return the SHA-256 of a bag's files, in the order of their names."""
    digest = hashlib.sha256()
    files = sorted(item for item in path.rglob("*") if item.is_file()) if path.is_dir() else [path]
    for file in files:
        digest.update(file.name.encode() + b"\0")
        with file.open("rb") as stream:
            while block := stream.read(_BLOCK_BYTES):
                digest.update(block)
    return digest.hexdigest()
