"""Where a result comes from: the input and its hash, the software's version, every parameter."""

import hashlib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

_BLOCK_BYTES = 1 << 20


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
