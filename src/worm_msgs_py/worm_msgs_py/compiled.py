"""Compiles inner loops to machine code, once for each version of them."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit, types

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
    compiled anew. Numba looks at the function's own file alone: where it calls what other files
    compile, a number of their sources must be in a variable of the function around it.
    """
    try:
        fast: Function = njit(cache=True)(function)
    except RuntimeError:  # no folder that Numba may write to
        fast = njit(function)
    return fast


def compiled_for(*arguments: Any) -> Callable[[Function], Function]:
    """Return what compiles a function for such arguments when its module is imported, and keeps it.

    No frame of a live trial waits for the compiler then.
    """

    def compiled_at_once(function: Function) -> Function:
        try:
            fast: Function = njit(arguments, cache=True)(function)
        except RuntimeError:  # no folder that Numba may write to
            fast = njit(arguments)(function)
        return fast

    return compiled_at_once


def array_read(dtype: Any, dimensions: int = 1) -> Any:
    """Return the type of an array that a compiled function reads, however it lies in memory."""
    return types.Array(dtype, dimensions, "A", readonly=True)


def array_written(dtype: Any, dimensions: int = 1) -> Any:
    """Return the type of an array that a compiled function writes, contiguous in memory."""
    return types.Array(dtype, dimensions, "C")
