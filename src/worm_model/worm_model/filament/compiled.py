"""Compiles the inner loops of the filament to machine code, once for each version of them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar
from zlib import crc32

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Return a function compiled for others that are compiled.

    Sums are not reordered (`fastmath`): the same input gives the same bytes.
    """
    fast: Function = njit(function)
    return fast


def compiled_and_kept(function: Function) -> Function:
    """Return a compiled function whose machine code is kept for the next process.

    It lies beside the module or in the user's cache; where neither can be written, the function is
    compiled anew. Numba looks at the function's own file alone, so the function must hold
    `sources_number()` in a variable of the function around it: then a change of any other file
    makes new code, too.
    """
    try:
        fast: Function = njit(cache=True)(function)
    except RuntimeError:  # no folder that Numba may write to
        fast = njit(function)
    return fast


def sources_number() -> int:
    """Return a number that changes with any file of this folder."""
    number = 0
    for file in sorted(Path(__file__).parent.glob("*.py")):
        number = crc32(file.read_bytes(), number)
    return number
