"""Pickles arrays so that they come back with their strides, and views as views of one memory.

numpy pickles a view as an array of its own. But a core may write into a part of an array and read
it through another, and a product with a turned array rounds otherwise than one with its copy: a
run that went on from such a state would not give the same bytes.
"""

import io
import pickle
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class _Pickler(pickle.Pickler):
    def reducer_override(self, obj: Any) -> Any:
        if type(obj) is not np.ndarray or obj.size == 0 or not isinstance(obj.base, np.ndarray):
            return NotImplemented
        root = _root(obj)
        if root.dtype.hasobject or not root.flags.forc:
            return NotImplemented
        offset = _address(obj) - _address(root)
        writeable = obj.flags.writeable
        return _view_of_memory, (root, obj.shape, obj.dtype, offset, obj.strides, writeable)


def dumps(thing: Any) -> bytes:
    """Return a thing pickled."""
    stream = io.BytesIO()
    _Pickler(stream, protocol=pickle.HIGHEST_PROTOCOL).dump(thing)
    return stream.getvalue()


def loads(data: bytes) -> Any:
    """Return what was pickled. Runs whatever `data` asks for: never on bytes of others."""
    return pickle.loads(data)


def _root(view: Array) -> Array:
    """Return the outermost array that a view looks into."""
    while isinstance(view.base, np.ndarray):
        view = view.base
    return view


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def _view_of_memory(
    root: Array,
    shape: tuple[int, ...],
    dtype: np.dtype[Any],
    offset: int,
    strides: tuple[int, ...],
    writeable: bool,
) -> Array:
    buffer = root if root.flags.c_contiguous else root.T
    view: Array = np.ndarray(shape, dtype, buffer, offset, strides)
    view.flags.writeable = writeable
    return view
