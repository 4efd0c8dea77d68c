"""Machine code is made at import, takes arrays however they lie in memory, and is not lost."""

import numpy as np
import pytest
from numba import types

from worm_msgs_py.compiled import array_read, array_written, compiled_and_kept, compiled_for


def doubled(values, out):
    for k in range(len(values)):
        out[k] = 2 * values[k]


def refusing_to_keep(function=None, **options):
    if options.get("cache"):
        raise RuntimeError("cannot cache function: no locator available")
    return function if callable(function) else lambda its_function: its_function


def test_machine_code_that_cannot_be_kept_is_made_anew(monkeypatch):
    monkeypatch.setattr("worm_msgs_py.compiled.njit", refusing_to_keep)
    assert compiled_and_kept(abs) is abs
    assert compiled_for(types.float64)(abs) is abs


@pytest.mark.parametrize("way", [1, -1, 2])
@pytest.mark.parametrize("writable", [True, False])
def test_what_is_read_may_lie_in_memory_as_it_likes(way, writable):
    fast = compiled_for(array_read(types.float64), array_written(types.float64))(doubled)
    values = np.arange(6.0)[::way]
    values.flags.writeable = writable
    out = np.empty(len(values))
    fast(values, out)
    assert (out == 2 * values).all()
    assert len(fast.signatures) == 1  # no other was made for it, which a live trial would wait for
