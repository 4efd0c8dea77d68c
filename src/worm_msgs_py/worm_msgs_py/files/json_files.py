"""Reads JSON files that others may have written: of a bounded size, and finite numbers alone."""

import json
from math import isfinite
from pathlib import Path
from typing import Any, NoReturn

MOST_BYTES = 64 << 20
"""Of a file: a summary of ours has some 50 kB."""


def read_json(path: Path, most_bytes: int = MOST_BYTES) -> Any:
    """Return what a JSON file holds.

    Raises
    ------
    OSError
        It is not there, or is not open to us.
    ValueError
        It is no regular file, is larger than `most_bytes`, is no JSON, holds NaN or an infinite
        number, or is nested too deeply: what is wrong, on one line.
    """
    if path.exists() and not path.is_file():
        raise ValueError("is not a file")
    with path.open("rb") as stream:
        raw = stream.read(most_bytes + 1)
    if len(raw) > most_bytes:
        raise ValueError(f"is larger than {most_bytes >> 20} MB")
    try:
        return json.loads(
            raw.decode("utf-8"), parse_constant=_refuse_word, parse_float=_finite_number
        )
    except RecursionError:
        raise ValueError("is nested too deeply") from None


def _refuse_word(word: str) -> NoReturn:
    raise ValueError(f"holds {word}, which is no JSON")


def _finite_number(text: str) -> float:
    value = float(text)
    if not isfinite(value):
        raise ValueError(f"holds {text[:40]}, which no number can be")
    return value
